// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/model.h>
#include <io/gradient_samples.h>
#include <io/model_files.h>

#include <cstdint>

#include "io/vtk/vtk_xml.h"

namespace espalier::io {
namespace {

/// A stretch by 2 along x; its cofactors are diag(1, 2, 2).
constexpr DeformationGradient kStretch = {2, 0, 0, 0, 1, 0, 0, 0, 1};

/// Returns a piece of two points.
std::string piece(const std::string& pointData, const std::string& points = "0 0 0 1 0 0") {
    return "<Piece NumberOfPoints=\"2\" NumberOfCells=\"0\">\n" + pointData +
           "<Points>\n<DataArray type=\"Float64\" Name=\"p\" NumberOfComponents=\"3\" "
           "format=\"ascii\">\n  " +
           points + "\n</DataArray>\n</Points>\n<Cells/>\n</Piece>\n";
}

std::string file(const std::string& pieces, const std::string& attributes = {},
                 const std::string& appended = {}) {
    return "<VTKFile type=\"UnstructuredGrid\"" + attributes + ">\n<UnstructuredGrid>\n" + pieces +
           "</UnstructuredGrid>\n" + appended + "</VTKFile>\n";
}

std::string array(const std::string& name, const std::string& numbers,
                  const std::string& type = "Float32", int components = 3) {
    return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
           std::to_string(components) + "\" format=\"ascii\">\n  " + numbers + "\n</DataArray>\n";
}

std::string pointData(const std::string& arrays, const std::string& attributes = {}) {
    return "<PointData" + attributes + ">\n" + arrays + "</PointData>\n";
}

TEST(VtuDirections, AreCarriedInAscii) {
    const auto text = [](const std::string& normals, const std::string& tangents) {
        return file(piece(pointData(array("uv", "1 2\n  3 4", "Float32", 2) +
                                    array("Normals", normals) + array("Velocity", "1 2 3 4 5 6") +
                                    array("Tangents", tangents, "Float64"))));
    };
    const std::string before = text("1 0 0\n  0.6 0 0.8", "0.1 0.2 0.3\n  0 0 0");
    const auto model = readModel("a.vtu", before);
    EXPECT_TRUE(model->hasDirections());
    EXPECT_EQ(turned(*model, kIdentity), before);
    EXPECT_EQ(turned(*model, kQuarterTurn), text("0 1 0\n  0 0.6 0.8", "-0.2 0.1 0.3\n  0 0 0"));
    EXPECT_EQ(written(*model, model->positions(),
                      std::vector<DeformationGradient>{kIdentity, kQuarterTurn}),
              text("1 0 0\n  0 0.6 0.8", "0.1 0.2 0.3\n  0 0 0"));
    const std::vector<Point3> moved = {{0, 0, 0}, {2, 0, 0}};
    EXPECT_THAT(written(*model, moved), HasSubstr("0.6 0 0.8"));
}

TEST(VtuDirections, NormalsUseCofactorsAndTangentsTheGradient) {
    const auto text = [](const std::string& normals, const std::string& tangents) {
        return file(piece(pointData(array("Tangents", tangents) + array("Normals", normals))));
    };
    // (2, 0, 1) becomes (2, 0, 2), of length √5: √2.5 = 1.58113883, which is the float 1.5811388.
    // (1, 0, 2) becomes (2, 0, 2).
    EXPECT_EQ(turned(*readModel("a.vtu", text("2 0 1\n  1 0 0", "1 0 2\n  0 0 1")), kStretch),
              text("1.5811388 0 1.5811388\n  1 0 0", "1.5811388 0 1.5811388\n  0 0 1"));
}

TEST(VtuDirections, MayHaveAnyNameIfActive) {
    const auto text = [](const std::string& numbers) {
        return file(piece(pointData(array("shade", numbers) + array("Normal", "1 0 0\n  1 0 0"),
                                    " Scalars=\"uv\" Normals=\"shade\" Vectors=\"Normal\"")));
    };
    EXPECT_EQ(turned(*readModel("a.vtu", text("1 0 0\n  0 1 0")), kQuarterTurn),
              text("0 1 0\n  -1 0 0"));
}

TEST(VtuDirections, NeedThreeRealComponents) {
    for (const std::string& arrays :
         {array("Normals", "1 0 0 1 0 0", "Int8"), array("Normals", "1 0 1 0", "Float32", 2),
          array("normals", "1 0 0 1 0 0"),
          std::string("<Array type=\"String\" Name=\"Normals\" NumberOfComponents=\"3\"/>\n")}) {
        const std::string text = file(piece(pointData(arrays)));
        const auto model = readModel("a.vtu", text);
        EXPECT_FALSE(model->hasDirections()) << arrays;
        EXPECT_EQ(turned(*model, kQuarterTurn), text);
    }
    // Normals of cells are ignored.
    const std::string text =
        file(piece("<CellData Normals=\"n\">" + array("n", "") + "</CellData>\n"));
    EXPECT_FALSE(readModel("a.vtu", text)->hasDirections());
}

TEST(VtuDirections, EachPieceFollowsItsOwnPoints) {
    const auto text = [](const std::string& first, const std::string& last) {
        return file(piece(pointData(array("Normals", first))) + piece(pointData("")) +
                    piece(pointData(array("Normals", last))));
    };
    const std::string same = "1 0 0 1 0 0";
    std::vector<DeformationGradient> gradients(6, kIdentity);
    gradients[5] = kQuarterTurn;
    const auto model = readModel("a.vtu", text(same, same));
    EXPECT_EQ(written(*model, model->positions(), gradients), text(same, "1 0 0\n  0 1 0"));
}

TEST(VtuDirections, VectorsThatAreNoDirectionStay) {
    const VtkCoding coding{std::endian::little, true, false};
    const auto text = [&](const std::vector<double>& numbers, NumberType type) {
        return file(piece(pointData(dataArrayElement<double>({"Normals", type, 3}, numbers,
                                                             VtkArrayForm::Base64, coding, ""))),
                    " byte_order=\"LittleEndian\" header_type=\"UInt64\"");
    };
    for (const NumberType type : {NumberType::Float32, NumberType::Float64}) {
        for (const double other : {kNan, kInfinity, 0.0}) {
            const std::string before = text({1, 0, 0, 1, other, 0}, type);
            const auto model = readModel("a.vtu", before);
            EXPECT_EQ(turned(*model, kIdentity), before);
            EXPECT_EQ(turned(*model, kQuarterTurn), other == 0
                                                        ? text({0, 1, 0, 0, 1, 0}, type)
                                                        : text({0, 1, 0, 1, other, 0}, type));
        }
    }
}

/// Uses files as VTK writes them; their arrays become inline arrays.
TEST(VtuDirections, AreCarriedInEveryEncoding) {
    for (const std::endian order : {std::endian::little, std::endian::big}) {
        for (const bool has64BitHeader : {false, true}) {
            for (const bool isCompressed : {false, true}) {
                const VtkCoding coding{order, has64BitHeader, isCompressed};
                const std::string attributes =
                    std::string(" byte_order=\"") +
                    (order == std::endian::little ? "LittleEndian" : "BigEndian") +
                    "\" header_type=\"" + (has64BitHeader ? "UInt64" : "UInt32") + "\"" +
                    (isCompressed ? " compressor=\"vtkZLibDataCompressor\"" : "");
                const auto element = [&](const std::vector<double>& numbers) {
                    return dataArrayElement<double>({"Normals", NumberType::Float32, 3}, numbers,
                                                    VtkArrayForm::Base64, coding, "") +
                           "\n";
                };
                const std::string before =
                    file(piece(pointData(element({1, 0, 0, 0.5, 0, 0}))), attributes);
                const std::string after =
                    file(piece(pointData(element({0, 1, 0, 0, 0.5, 0}))), attributes);
                EXPECT_EQ(turned(*readModel("a.vtu", before), kIdentity), before);
                EXPECT_EQ(turned(*readModel("a.vtu", before), kQuarterTurn), after);
                if (isCompressed) continue;

                std::string raw = has64BitHeader ? bytesOf(std::uint64_t{24}, order)
                                                 : bytesOf(std::uint32_t{24}, order);
                for (const float number : {1.0f, 0.0f, 0.0f, 0.5f, 0.0f, 0.0f})
                    raw += bytesOf(number, order);
                const std::string appended =
                    "<AppendedData encoding=\"raw\">_junk" + raw + "</AppendedData>\n";
                const std::string head =
                    "<DataArray type=\"Float32\" Name=\"Normals\" NumberOfComponents=\"3\" "
                    "format=\"appended\" RangeMin=\"0\" offset=\"4\"/>\n";
                const std::string withRaw = file(piece(pointData(head)), attributes, appended);
                EXPECT_EQ(turned(*readModel("a.vtu", withRaw), kIdentity), withRaw);
                EXPECT_EQ(
                    turned(*readModel("a.vtu", withRaw), kQuarterTurn),
                    file(piece(pointData(element({0, 1, 0, 0, 0.5, 0}))), attributes, appended));
            }
        }
    }
}

TEST(VtuDirections, WrongNumberOfTuplesIsRefused) {
    EXPECT_THAT([] { readModel("a.vtu", file(piece(pointData(array("Normals", "1 0 0"))))); },
                ThrowsMessage<FileError>(AllOf(HasSubstr("a.vtu:5: "), HasSubstr("'Normals'"),
                                               HasSubstr("has 3 numbers; expected 2 times 3"))));
}

}  // namespace
}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/model.h>
#include <io/gradient_samples.h>
#include <io/model_files.h>

namespace espalier::io {
namespace {

/// Returns a surface of three points, with these data at its points.
std::string surface(const std::string& pointData, const std::string& version = "3.0") {
    return "# vtk DataFile Version " + version +
           "\na\nASCII\nDATASET POLYDATA\nPOINTS 3 double\n0 0 0 1 0 0 0 1 0\n" +
           (version == "5.1"
                ? "METADATA\nINFORMATION 0\n\nPOLYGONS 2 3\nOFFSETS vtktypeint64\n0 3\n"
                  "CONNECTIVITY vtktypeint64\n0 1 2\n"
                : "POLYGONS 1 4\n3 0 1 2\n") +
           "CELL_DATA 1\nNORMALS ofCells float\n1 0 0\nPOINT_DATA 3\n" + pointData;
}

TEST(VtkLegacyDirections, NormalsAndTangentsAreCarried) {
    const auto text = [](const std::string& normals, const std::string& tangents,
                         const std::string& version) {
        return surface(
            "SCALARS T double 1\nLOOKUP_TABLE default\n1 2 3\nNORMALS any%20name float\n" +
                normals + "\nMETADATA\nINFORMATION 0\n\nFIELD FieldData 2\nTangents 3 3 double\n" +
                tangents + "\nu 3 3 double\n1 0 0 1 0 0 1 0 0\n",
            version);
    };
    for (const std::string version : {"3.0", "5.1"}) {
        const std::string before =
            text("1 0 0\n0.60 0 0.8 0 0 1", "0.1 0.2 0.3 0 0 0\n1 0 0", version);
        const auto model = readModel("a.vtk", before);
        EXPECT_TRUE(model->hasDirections());
        EXPECT_EQ(turned(*model, kIdentity), before);
        // x becomes y, and y becomes -x. The text of a component that stays is kept.
        EXPECT_EQ(turned(*model, kQuarterTurn),
                  text("0 1 0\n0 0.6 0.8 0 0 1", "-0.2 0.1 0.3 0 0 0\n0 1 0", version));
        // Without gradients the directions stay.
        std::vector<Point3> moved = copyOf(model->positions());
        moved[2] = {0, 2, 0};
        std::string expected = before;
        expected.replace(expected.find("0 1 0\n"), 5, "0 2 0");
        EXPECT_EQ(written(*model, moved), expected);
        // Points and directions change in one file.
        const std::vector<DeformationGradient> gradients = {kIdentity, kIdentity, kQuarterTurn};
        expected.replace(expected.find("\n1 0 0\nu"), 6, "\n0 1 0");
        EXPECT_EQ(written(*model, moved, gradients), expected);
    }
}

TEST(VtkLegacyDirections, OfBinaryFilesAreCarriedInPlace) {
    const auto vectors = [](std::initializer_list<float> numbers) {
        std::string bytes;
        for (const float number : numbers) bytes += bytesOf(number, std::endian::big);
        return bytes;
    };
    const auto file = [&](const std::string& normals) {
        return "# vtk DataFile Version 3.0\na\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 2 "
               "float\n" +
               vectors({0, 0, 0, 1, 0, 0}) + "\nCELLS 0 0\n\nCELL_TYPES 0\n\nPOINT_DATA 2\n" +
               "NORMALS Normals float\n" + normals + "\n";
    };
    const auto model = readModel("a.vtk", file(vectors({1, 0, 0, 0, 0, 0})));
    EXPECT_EQ(turned(*model, kIdentity), file(vectors({1, 0, 0, 0, 0, 0})));
    EXPECT_EQ(turned(*model, kQuarterTurn), file(vectors({0, 1, 0, 0, 0, 0})));
    // NaN is no direction, and stays.
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(turned(*readModel("a.vtk", file(vectors({1, 0, 0, nan, 1, 0}))), kQuarterTurn),
              file(vectors({0, 1, 0, nan, 1, 0})));
}

TEST(VtkLegacyDirections, OtherArraysStay) {
    for (const std::string data :
         {"NORMALS n int\n1 0 0 1 0 0 1 0 0\n", "VECTORS v float\n1 0 0 1 0 0 1 0 0\n",
          "FIELD f 1\nNormals 1 3 float\n1 0 0\n", "COLOR_SCALARS Normals 3\n1 0 0 1 0 0 1 0 0\n",
          "CELL_DATA 3\nNORMALS n float\n1 0 0 1 0 0 1 0 0\n", ""}) {
        const auto model = readModel("a.vtk", surface(data));
        EXPECT_FALSE(model->hasDirections()) << data;
        EXPECT_EQ(turned(*model, kQuarterTurn), surface(data));
    }
    // The name tells, whatever the keyword is.
    EXPECT_TRUE(readModel("a.vtk", surface("VECTORS Tangents float\n1 0 0 1 0 0 1 0 0\n"))
                    ->hasDirections());
}

TEST(VtkLegacyDirections, MalformedNumbersAreRefusedWithTheLine) {
    EXPECT_REFUSED(FileError, "a.vtk:15: 'x' is not a number; expected a component of a direction",
                   readModel("a.vtk", surface("NORMALS n float\n1 0 0\n1 x 0\n1 0 0\n")));
    EXPECT_REFUSED(
        FileError,
        "a.vtk:13: the file ends; expected 9 times a component of a direction, got 16 bytes",
        readModel("a.vtk", surface("NORMALS n float\n1 0 0\n1 0 0\n1 0")));
    EXPECT_REFUSED(FileError, "the array 'Normals' has 2 tuples for 3 points",
                   readModel("a.vtk", surface("FIELD f 1\nNormals 3 2 float\n1 0 0 1 0 0\n")));
}

}  // namespace
}  // namespace espalier::io

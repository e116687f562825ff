// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/base64.h>
#include <espalier/io/model.h>

#include "io/files/coding.h"
#include "lattice_samples.h"
#include "model_files.h"

namespace espalier::test {
namespace {

std::vector<std::filesystem::path> dataFiles() {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(
             std::filesystem::path(ESPALIER_SOURCE_DIR) / "tests/io/data"))
        if (entry.path().extension() == ".vtu") files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    EXPECT_EQ(files.size(), 7u);
    return files;
}

std::vector<Point3> moved(std::span<const Point3> points) {
    std::vector<Point3> result(points.begin(), points.end());
    for (Point3& point : result) point = {point[1] + 0.1, point[2] / 3, -point[0]};
    return result;
}

std::string written(const io::Model& model, std::span<const Point3> positions) {
    const TemporaryFolder folder;
    model.write(folder / "out.vtu", positions);
    return io::readFile(folder / "out.vtu");
}

std::unique_ptr<io::Model> modelOf(const std::string& bytes) {
    const TemporaryFolder folder;
    putLatticeFile(folder / "a.vtu", bytes);
    return io::readModel(folder / "a.vtu");
}

TEST(VtuModel, ReadsThePoints) {
    for (const auto& file : dataFiles()) {
        const auto model = io::readModel(file);
        ASSERT_EQ(model->positions().size(), 11u) << file;
        EXPECT_EQ(model->positions()[10], (Point3{2.3, 0.1, 0.1})) << file;
    }
}

TEST(VtuModel, IsUnchangedIfNoPointMoves) {
    for (const auto& file : dataFiles()) {
        const auto model = io::readModel(file);
        EXPECT_EQ(written(*model, model->positions()), io::readFile(file)) << file;
    }
}

/// The array of points is replaced by an inline array, and everything else stays.
TEST(VtuModel, ReplacesOnlyThePoints) {
    for (const auto& file : dataFiles()) {
        SCOPED_TRACE(file);
        const auto model = io::readModel(file);
        const std::vector<Point3> positions = moved(model->positions());
        const std::string before = io::readFile(file);
        const std::string after = written(*model, positions);
        const auto again = modelOf(after);
        EXPECT_EQ(bitsOf(std::vector<Point3>(again->positions().begin(), again->positions().end())),
                  bitsOf(positions));
        const std::size_t begin = before.find("<DataArray", before.find("<Points>"));
        const std::string rest = before.substr(before.find("</Points>"));
        EXPECT_EQ(after.substr(0, begin), before.substr(0, begin));
        ASSERT_GE(after.size(), begin + rest.size());
        EXPECT_EQ(after.substr(after.size() - rest.size()), rest);

        Lattice expected = io::readLattice(file);
        expected.positions = positions;
        expectSameLattice(latticeOf("a.vtu", after), expected);
    }
}

std::string twoPieces(const std::string& type) {
    const auto piece = [&](const std::string& points) {
        return "<Piece NumberOfPoints='2' NumberOfCells='0'><Points>\n  <DataArray type='" + type +
               "' Name='p' NumberOfComponents='3'>" + points + "</DataArray>\n</Points></Piece>\n";
    };
    return "<VTKFile type='UnstructuredGrid'><UnstructuredGrid>\n" + piece("0 0 0 1 2 3") +
           "<Piece NumberOfPoints='0' NumberOfCells='0'><Points/></Piece>\n" +
           piece("4 5 6 7 8 9") + "</UnstructuredGrid></VTKFile>";
}

TEST(VtuModel, RewritesOnlyPiecesThatMoved) {
    const std::string text = twoPieces("Float32");
    const auto model = modelOf(text);
    ASSERT_EQ(model->positions().size(), 4u);
    std::vector<Point3> positions(model->positions().begin(), model->positions().end());
    positions[3] = {0.1, 8, 9};
    const std::string got = written(*model, positions);
    const std::size_t second = text.rfind("<DataArray");
    EXPECT_EQ(got, text.substr(0, second) +
                       "<DataArray type=\"Float32\" Name=\"p\" NumberOfComponents=\"3\" "
                       "format=\"ascii\">\n    4 5 6\n    0.1 8 9\n  </DataArray>" +
                       text.substr(text.rfind("\n</Points>")));
    EXPECT_EQ(modelOf(got)->positions()[3][0], double{0.1f});
}

TEST(VtuModel, IntegerPointsBecomeFloat64) {
    const auto model = modelOf(twoPieces("Int16"));
    std::vector<Point3> positions(model->positions().begin(), model->positions().end());
    positions[0][0] = 0.1;
    const std::string got = written(*model, positions);
    EXPECT_THAT(got, HasSubstr("type=\"Float64\""));
    EXPECT_EQ(modelOf(got)->positions()[0][0], 0.1);
}

TEST(VtuModel, RefusesTooLargeOrTooFewPositions) {
    const auto model = modelOf(twoPieces("Float32"));
    std::vector<Point3> positions(model->positions().begin(), model->positions().end());
    positions[2][1] = 1e300;
    EXPECT_THROW(written(*model, positions), Error);
    positions.pop_back();
    EXPECT_THROW(written(*model, positions), Error);
}

/// OpenFOAM 1912 claims four times the bytes of the array in its binary .vtp files. VTK reads them.
TEST(VtuModel, ArraysMayClaimAWrongSizeIfTheTextHasTheRightOne) {
    const auto file = [](std::int32_t claim, const std::string& more = "") {
        std::string connectivity = bytesOf(std::uint64_t(claim), std::endian::little);
        for (const std::int32_t point : {0, 1, 2})
            connectivity += bytesOf(point, std::endian::little);
        return "<VTKFile type='PolyData' byte_order='LittleEndian' header_type='UInt64'><PolyData>"
               "<Piece NumberOfPoints='3' NumberOfPolys='1'><Points><DataArray type='Float32' "
               "NumberOfComponents='3'>0 0 0 1 0 0 0 1 0</DataArray></Points><Polys><DataArray "
               "type='Int32' Name='connectivity' format='binary'>\n" +
               io::encodeBase64(connectivity + more) +
               "\n</DataArray><DataArray type='Int32' Name='offsets'>3</DataArray></Polys>"
               "</Piece></PolyData></VTKFile>";
    };
    const auto cornersOf = [](const std::string& bytes) {
        return io::readModel("a.vtp", bytes)->readSurface().faces.corners;
    };
    for (const std::int32_t claim : {12, 48, 0})
        EXPECT_EQ(cornersOf(file(claim)), (std::vector<Index>{0, 1, 2})) << claim;
    EXPECT_REFUSED(io::FileError, "the array 'connectivity' has 12 numbers; expected 3",
                   cornersOf(file(48, "more")));
}

}  // namespace
}  // namespace espalier::test

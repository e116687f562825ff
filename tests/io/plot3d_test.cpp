// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <io/mesh_samples.h>

#include "support/test.h"

namespace espalier::io {
namespace {

/// Returns the grid of one block of 2 × 3 × 2 points in binary.
template <class Real>
std::string binaryGrid(std::endian order, bool hasMarkers, bool hasCount, bool hasBlank,
                       int dimension = 3) {
    const auto number = [&](int value) { return bytesOf(std::int32_t(value), order); };
    const auto record = [&](const std::string& content) {
        return hasMarkers ? number(int(content.size())) + content + number(int(content.size()))
                          : content;
    };
    std::string extents = number(2) + number(3) + (dimension == 3 ? number(2) : "");
    const int nk = dimension == 3 ? 2 : 1;
    std::string data;
    for (int axis = 0; axis < dimension; ++axis)
        for (int k = 0; k < nk; ++k)
            for (int j = 0; j < 3; ++j)
                for (int i = 0; i < 2; ++i)
                    data += bytesOf(Real(axis == 0 ? i : axis == 1 ? 2 * j : 3 * k), order);
    for (int i = 0; hasBlank && i < 6 * nk; ++i) data += number(1);
    return (hasCount ? record(number(1)) : "") + record(extents) + record(data);
}

TEST(Plot3d, TextIsReadAndWrittenInPlace) {
    const std::string text = sampleGrid({{2, 3, 2}, {2, 2, 2}}, {{0, 0, 0}, {1, 0, 0}});
    for (const char* name : {"a.xyz", "a.p3d", "a.FMT", "a.g", "a.x", "a.grd", "a.ufmt"}) {
        const auto model = readModel(name, text);
        ASSERT_EQ(model->positions().size(), 20u);
        EXPECT_EQ(model->positions()[5], (Point3{1, 4, 0}));
        EXPECT_EQ(model->positions()[19], (Point3{2, 2, 3}));
        EXPECT_EQ(model->storage(), CoordinateStorage::Text);
        EXPECT_EQ(written(*model, model->positions()), text);
        auto moved = copyOf(model->positions());
        moved[0] = {0.5, 0.25, 0.125};
        moved[19][0] = 7;
        const std::string expected =
            "2\n2 3 2\n2 2 2\n"
            "0.5 1\n0 1\n0 1\n0 1\n0 1\n0 1\n0.25 0\n2 2\n4 4\n0 0\n2 2\n4 4\n"
            "0.125 0\n0 0\n0 0\n3 3\n3 3\n3 3\n1 2\n1 2\n1 2\n1 7\n0 0\n2 2\n0 0\n2 2\n0 0\n0 0\n3 "
            "3\n3 3\n";
        EXPECT_EQ(written(*model, moved), expected);
        EXPECT_EQ(model->readCells().volume.cellCount(), 3);
        EXPECT_EQ(model->readSurface().faces.count(), 0u);
    }
}

TEST(Plot3d, VariantsOfTextAreToldByTheirNumbers) {
    const std::string multi = sampleGrid({{2, 2, 2}}, {{0, 0, 0}});
    const std::string single = multi.substr(2);
    const std::string blank = sampleGrid({{2, 2, 2}}, {{0, 0, 0}}, true);
    for (const std::string& text : {multi, single, blank, blank.substr(2)})
        EXPECT_EQ(copyOf(readModel("a.xyz", text)->positions()),
                  copyOf(readModel("a.xyz", multi)->positions()));
    // Two dimensions: no z. Commas, and exponents of Fortran.
    const auto plane = readModel("a.xyz", "2, 2\n0, 1.0D+00, 0 1.0d0\n0 0 1 1\n");
    EXPECT_THAT(copyOf(plane->positions()),
                ElementsAre(Point3{0, 0, 0}, Point3{1, 0, 0}, Point3{0, 1, 0}, Point3{1, 1, 0}));
    EXPECT_EQ(plane->readSurface().faces.count(), 1u);
    auto moved = copyOf(plane->positions());
    moved[1] = {1.5, 0, 0};
    EXPECT_EQ(written(*plane, moved), "2, 2\n0, 1.5, 0 1.0d0\n0 0 1 1\n");
    moved[1][2] = 1;
    EXPECT_REFUSED(Error, "the mesh is of two dimensions", written(*plane, moved));
    // Bytes above 127 separate nothing.
    EXPECT_REFUSED(FileError, "is not a number", readModel("a.xyz", "2 2\n0 1 0 1\n0 0 1\xB7 1\n"));
}

TEST(Plot3d, BinaryVariantsAreToldByTheirExtent) {
    const auto expected =
        copyOf(readModel("a.xyz", binaryGrid<double>(std::endian::little, true, true, false))
                   ->positions());
    ASSERT_EQ(expected.size(), 12u);
    EXPECT_EQ(expected[11], (Point3{1, 4, 3}));
    for (const std::endian order : {std::endian::little, std::endian::big})
        for (const bool hasMarkers : {true, false})
            for (const bool hasCount : {true, false})
                for (const bool hasBlank : {true, false}) {
                    const auto check = [&](const std::string& bytes, CoordinateStorage storage) {
                        const auto model = readModel("a.xyz", bytes);
                        EXPECT_EQ(copyOf(model->positions()), expected);
                        EXPECT_EQ(model->storage(), storage);
                        EXPECT_TRUE(written(*model, model->positions()) == bytes);
                        auto moved = expected;
                        moved[3] = {0.5, 2, -1};
                        const std::string now = written(*model, moved);
                        EXPECT_EQ(now.size(), bytes.size());
                        EXPECT_EQ(copyOf(readModel("a.xyz", now)->positions()), moved);
                        EXPECT_EQ(model->readCells().volume.cellCount(), 2);
                    };
                    check(binaryGrid<double>(order, hasMarkers, hasCount, hasBlank),
                          CoordinateStorage::Double);
                    check(binaryGrid<float>(order, hasMarkers, hasCount, hasBlank),
                          CoordinateStorage::Float);
                }
    const auto plane =
        readModel("a.p3d", binaryGrid<double>(std::endian::big, true, true, false, 2));
    EXPECT_EQ(plane->positions().size(), 6u);
    EXPECT_EQ(plane->readSurface().faces.count(), 2u);
}

TEST(Plot3d, BlocksOfALatticeAreWelded) {
    const std::string text =
        sampleGrid({{2, 3, 2}, {3, 3, 2}, {2, 2, 2}}, {{0, 0, 0}, {1, 0, 0}, {0, 0, 3}});
    const Lattice lattice = readLattice("a.xyz", text);
    EXPECT_EQ(lattice.complex.count(3), 2 + 4 + 1);
    // 12 + 18 + 8 points, of which 6 are on x = 1, and 4 on z = 3.
    EXPECT_EQ(lattice.complex.count(0), 38 - 6 - 4);
    EXPECT_REFUSED(
        FileError, "block 1 has 2 × 2 × 1 points; a block of a lattice has at least 2",
        readLattice("a.xyz", sampleGrid({{2, 2, 2}, {2, 2, 1}}, {{0, 0, 0}, {5, 0, 0}})));
    // An edge without length.
    std::string flat = sampleGrid({{2, 2, 2}}, {{0, 0, 0}});
    flat.replace(flat.find("0 1\n"), 4, "0 0\n");
    EXPECT_REFUSED(far::TopologyError, "a.xyz: ", readLattice("a.xyz", flat));
}

TEST(Plot3d, MalformedFilesAreRefused) {
    const std::string text = sampleGrid({{2, 2, 2}}, {{0, 0, 0}});
    const auto expectRefused = [](const std::string& bytes, const std::string& message) {
        EXPECT_REFUSED(FileError, message, readModel("a.xyz", bytes));
    };
    expectRefused("", "a.xyz: is not a PLOT3D grid: its 0 numbers are not");
    expectRefused("1.5 2.5 3.5\n4.5 5.5 6.5\n", "its 6 numbers are not those of a grid");
    expectRefused(text + "7", "its 29 numbers are not");
    expectRefused(text.substr(0, text.size() - 2), "its 27 numbers are not");
    std::string word = text;
    word.replace(word.find("0 1\n"), 3, "0 x");
    expectRefused(word, "a.xyz:3: 'x' is not a number");
    word.replace(word.find("0 x\n"), 3, "4*0");
    expectRefused(word, "a.xyz:3: '4*0' is a repeat count of Fortran");
    expectRefused("1\n2000000000 2000000000 2000000000\n0 0 0\n", "its 7 numbers are not");
    const std::string binary = binaryGrid<double>(std::endian::little, true, true, false);
    // The beginning of a file may happen to be a grid of another variant.
    std::size_t refused = 0;
    for (std::size_t size = 4; size < binary.size(); ++size) {
        const auto pointCount = [&] {
            return readModel("a.xyz", binary.substr(0, size))->positions().size();
        };
        if (messageOf<FileError>(pointCount).empty()) {
            EXPECT_NE(pointCount(), 12u);
        } else {
            ++refused;
        }
    }
    EXPECT_GT(refused, binary.size() - 15);
    std::string wrong = binary;
    wrong[8] = 5;  // The length after the first record.
    expectRefused(wrong, "bytes are not those of a grid");
}

}  // namespace
}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/vtk/vtk_legacy.h>
#include <io/model_files.h>

namespace espalier::io {
namespace {

/// A surface as OpenFOAM's surface commands write it.
std::string surfaceText(const std::string& type = "float") {
    return "# vtk DataFile Version 2.0\nsampleSurface\nASCII\nDATASET POLYDATA\nPOINTS 4 " + type +
           "\n0 0 0\n1.50 0 0  1e0 1 0\n0 1 0\n\nPOLYGONS 2 8\n3 0 1 2\n3 0 2 3\n"
           "VERTICES 1 2\n1 0\nPOINT_DATA 4\nNORMALS n float\n0 0 1 0 0 1 0 0 1 0 0 1\n";
}

std::vector<std::vector<Index>> legacyFaces(const std::string& bytes) {
    const ModelFaces faces = readModel("a.vtk", bytes)->readSurface().faces;
    std::vector<std::vector<Index>> result;
    for (std::size_t face = 0; face < faces.count(); ++face)
        result.emplace_back(faces[face].begin(), faces[face].end());
    return result;
}

TEST(VtkLegacyModel, ChangedCoordinatesAreReplacedAndAllOtherBytesStay) {
    const auto model = readModel("a.VTK", surfaceText());
    EXPECT_EQ(model->extension(), ".vtk");
    EXPECT_EQ(model->storage(), CoordinateStorage::Float);
    EXPECT_TRUE(model->hasDirections());
    ASSERT_EQ(model->positions().size(), 4u);
    EXPECT_EQ(model->positions()[1], (Point3{1.5, 0, 0}));
    EXPECT_EQ(written(*model, model->positions()), surfaceText());
    auto moved = copyOf(model->positions());
    moved[2] = {1, 1, 0.1};
    std::string expected = surfaceText();
    expected.replace(expected.find("1e0 1 0"), 7, "1e0 1 0.1");
    EXPECT_EQ(written(*model, moved), expected);
    // A float is the shortest text that reads back as the same float, a double as the same double.
    moved[2][2] = 0.1 + 0.2;
    EXPECT_THAT(written(*model, moved), HasSubstr("1e0 1 0.3\n"));
    EXPECT_THAT(written(*readModel("a.vtk", surfaceText("double")), moved),
                HasSubstr("1e0 1 0.30000000000000004\n"));
}

TEST(VtkLegacyModel, BinaryPointsAreReplacedInPlace) {
    for (const bool isFloat : {true, false}) {
        const auto numbers = [&](std::initializer_list<double> values) {
            std::string bytes;
            for (const double value : values)
                bytes += isFloat ? bytesOf(static_cast<float>(value), std::endian::big)
                                 : bytesOf(value, std::endian::big);
            return bytes;
        };
        const auto integers = [](std::initializer_list<int> values) {
            std::string bytes;
            for (const int value : values) bytes += bytesOf(value, std::endian::big);
            return bytes;
        };
        const auto file = [&](const std::string& points) {
            return std::string(
                       "# vtk DataFile Version 3.0\na\nBINARY\nDATASET POLYDATA\nFIELD f 1\n"
                       "TIME 1 1 double\n") +
                   bytesOf(0.5, std::endian::big) + "\nPOINTS 3 " + (isFloat ? "float" : "double") +
                   "\n" + points + "\nPOLYGONS 1 4\n" + integers({3, 2, 1, 0}) +
                   "\nCELL_DATA 1\nSCALARS s int\nLOOKUP_TABLE default\n" + integers({7});
        };
        const std::string before = file(numbers({0, 0, 0, 1, 0, 0, 0, 1, 0}));
        const auto model = readModel("a.vtk", before);
        EXPECT_EQ(written(*model, model->positions()), before);
        auto moved = copyOf(model->positions());
        moved[1] = {1, 2, 0.1};
        EXPECT_EQ(written(*model, moved), file(numbers({0, 0, 0, 1, 2, 0.1, 0, 1, 0})));
        EXPECT_EQ(legacyFaces(before), (std::vector<std::vector<Index>>{{2, 1, 0}}));
    }
}

TEST(VtkLegacyModel, FacesArePolygonsAndStripsOrCellsOfSurfaces) {
    EXPECT_EQ(legacyFaces(surfaceText()), (std::vector<std::vector<Index>>{{0, 1, 2}, {0, 2, 3}}));
    const std::string head =
        "# vtk DataFile Version 5.1\na\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n"
        "0 0 0 1 0 0 1 1 0 0 1 0\nMETADATA\nINFORMATION 0\n\n";
    EXPECT_EQ(legacyFaces(head + "TRIANGLE_STRIPS 2 4\nOFFSETS vtktypeint64\n0 4\n"
                                 "CONNECTIVITY vtktypeint64\n0 1 2 3\n"),
              (std::vector<std::vector<Index>>{{0, 1, 2}, {2, 1, 3}}));
    EXPECT_REFUSED(FileError, "a face names point 4; there are 4 points",
                   legacyFaces(head + "POLYGONS 2 3\nOFFSETS vtktypeint64\n0 3\n"
                                      "CONNECTIVITY vtktypeint64\n0 1 4\n"));
    const std::string grid =
        "# vtk DataFile Version 2.0\na\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n"
        "0 0 0 1 0 0 1 1 0 0 1 0\nCELLS 3 12\n3 0 1 2\n2 0 1\n4 0 1 2 3\nCELL_TYPES 3\n5 3 9\n";
    EXPECT_EQ(legacyFaces(grid), (std::vector<std::vector<Index>>{{0, 1, 2}, {0, 1, 2, 3}}));
}

TEST(VtkLegacyModel, StructuredGridsOfOneLayerAreFaces) {
    const std::string head = "# vtk DataFile Version 3.0\na\nASCII\nDATASET STRUCTURED_GRID\n";
    const std::string points = "POINTS 6 float\n0 0 0 1 0 0 2 0 0\n0 1 0 1 1 0 2 1 0\n";
    EXPECT_EQ(legacyFaces(head + "DIMENSIONS 3 2 1\n" + points),
              (std::vector<std::vector<Index>>{{0, 1, 4, 3}, {1, 2, 5, 4}}));
    EXPECT_EQ(legacyFaces(head + "DIMENSIONS 3 1 2\n" + points),
              (std::vector<std::vector<Index>>{{0, 1, 4, 3}, {1, 2, 5, 4}}));
    EXPECT_TRUE(legacyFaces(head + "DIMENSIONS 6 1 1\n" + points).empty());
    const auto model = readModel("a.vtk", head + "DIMENSIONS 3 2 1\n" + points);
    EXPECT_EQ(written(*model, std::vector<Point3>(6, {0, 0, 1.5})),
              head +
                  "DIMENSIONS 3 2 1\nPOINTS 6 float\n0 0 1.5 0 0 1.5 0 0 1.5\n0 0 1.5 0 0 1.5 0 0 "
                  "1.5\n");
    EXPECT_REFUSED(FileError, "there are 6 points, but DIMENSIONS has 0 × 0 × 0",
                   readModel("a.vtk", head + points));
}

TEST(VtkLegacyModel, MalformedFilesAreRefusedWithTheLine) {
    EXPECT_REFUSED(FileError, "a.vtk:5: the points are of type 'int', which cannot hold a deformed",
                   readModel("a.vtk", surfaceText("int")));
    EXPECT_REFUSED(
        FileError, "a.vtk:4: 'points,' is not a keyword that can stand here",
        readModel("a.vtk", "# vtk DataFile Version 2.0\na\nASCII\nDATASET POLYDATA POINTS, 3"));
    std::string word = surfaceText();
    word.replace(word.find("1.50"), 4, "x");
    EXPECT_REFUSED(FileError, "a.vtk:7: ", readModel("a.vtk", word));
    EXPECT_REFUSED(FileError, "a.vtk:5: ",
                   readModel("a.vtk",
                             "# vtk DataFile Version 2.0\na\nBINARY\nDATASET POLYDATA\n"
                             "POINTS 1000000000000 float\n"));
    EXPECT_REFUSED(FileError, "a.vtk:18: 'junk' is not a keyword that can stand here",
                   readModel("a.vtk", surfaceText() + "JUNK 4"));
    EXPECT_REFUSED(FileError, "the data are for 3 points, but there are 4", [&] {
        std::string text = surfaceText();
        readModel("a.vtk", text.replace(text.find("POINT_DATA 4"), 12, "POINT_DATA 3"));
    }());
    EXPECT_REFUSED(FileError, "a.vtk:5: POINT_DATA stands before POINTS",
                   readModel("a.vtk",
                             "# vtk DataFile Version 2.0\na\nASCII\nDATASET POLYDATA\n"
                             "POINT_DATA 0\nNORMALS n float\nPOINTS 0 float\n"));
    EXPECT_REFUSED(FileError, "a.vtk:7: a second section POINTS",
                   readModel("a.vtk",
                             "# vtk DataFile Version 2.0\na\nASCII\nDATASET POLYDATA\n"
                             "POINTS 1 float\n0 0 0\nPOINTS 1 float\n0 0 0\n"));
    EXPECT_REFUSED(FileError, "a.vtk:4: the file ends; expected POINTS",
                   readModel("a.vtk", "# vtk DataFile Version 2.0\na\nASCII\nDATASET POLYDATA\n"));
    // A model whose faces nobody asks for may have wrong ones.
    std::string faces = surfaceText();
    faces.replace(faces.find("3 0 2 3"), 7, "3 0 2 9");
    EXPECT_EQ(readModel("a.vtk", faces)->positions().size(), 4u);
    EXPECT_REFUSED(FileError, "a face names point 9", legacyFaces(faces));
}

}  // namespace
}  // namespace espalier::io

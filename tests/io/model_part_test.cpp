// SPDX-License-Identifier: Apache-2.0
// The attributes and the groups of models, and the weights of their parts. Those of glTF are in
// gltf_test.cpp.
#include <espalier/io/model_part.h>
#include <io/model_files.h>

#include <cstdint>

namespace espalier::io {
namespace {

using test::bytesOf;

std::vector<std::string> groupsOf(const Model& model) {
    std::vector<std::string> texts;
    for (const PointGroup& group : model.groups()) {
        std::string text = group.name + ":";
        for (const Index point : group.read()) text += " " + std::to_string(point);
        texts.push_back(text);
    }
    return texts;
}

using NameList = std::vector<std::string>;
using NumberList = std::vector<double>;

// Each type of a PLY, in both byte orders and as text. Bytes of colours are parts of 255; all other
// integers are numbers.
TEST(PlyAttributes, AreThePropertiesOfThePoints) {
    const auto header = [](const std::string& format) {
        return "ply\nformat " + format +
               " 1.0\nelement other 1\nproperty int bend\nelement vertex 2\nproperty double "
               "bend\nproperty float x\nproperty list uchar short tags\nproperty float y\nproperty "
               "float z\nproperty uchar red\nproperty uchar count\nproperty short part\nproperty "
               "float w\nend_header\n";
    };
    const auto check = [](const std::string& bytes) {
        const auto model = readModel("a.ply", bytes);
        EXPECT_EQ(namesOf(model->attributes()), (NameList{"bend", "red", "count", "part", "w"}));
        EXPECT_EQ(numbersOf("a.ply", *model, "bend"), (NumberList{0.1, 0.75}));
        EXPECT_EQ(numbersOf("a.ply", *model, "red"), (NumberList{1, 0.2}));
        EXPECT_EQ(numbersOf("a.ply", *model, "count"), (NumberList{255, 3}));
        EXPECT_EQ(numbersOf("a.ply", *model, "part"), (NumberList{-2, 300}));
        EXPECT_EQ(numbersOf("a.ply", *model, "w"), (NumberList{0.5, 1}));
        EXPECT_EQ(groupsOf(*model), NameList{});
    };
    check(header("ascii") + "7\n0.1 1 1 9 2 3 255 255 -2 .5\n0.75 4 0 5 6 51 3 300 1\n");
    for (const std::endian order : {std::endian::little, std::endian::big}) {
        const auto row = [&](double bend, float x, std::uint8_t red, std::uint8_t count,
                             std::int16_t part, float w) {
            const auto number = [&](auto value) { return bytesOf(value, order); };
            return number(bend) + number(x) + number(std::uint8_t{1}) + number(std::int16_t{9}) +
                   number(x) + number(x) + number(red) + number(count) + number(part) + number(w);
        };
        check(header(order == std::endian::big ? "binary_big_endian" : "binary_little_endian") +
              bytesOf(std::int32_t{7}, order) + row(0.1, 1, 255, 255, -2, 0.5f) +
              row(0.75, 4, 51, 3, 300, 1));
    }
}

TEST(ObjAttributes, AreColorsIfEachPointHasOne) {
    const auto model = readModel("a.obj", "v 0 0 0 1 .5 0\nv 1 2 3 0.25 0 1\n");
    EXPECT_EQ(namesOf(model->attributes()), (NameList{"red", "green", "blue"}));
    EXPECT_EQ(numbersOf("a.obj", *model, "green"), (NumberList{0.5, 0}));
    EXPECT_TRUE(readModel("a.obj", "v 0 0 0 1 .5 0\nv 1 2 3\n")->attributes().empty());
}

// A face belongs to all groups of the last `g`, to the last object and to the last material.
// Corners may count back; lines and point elements count too.
TEST(ObjGroups, AreGroupsObjectsAndMaterials) {
    const auto model =
        readModel("a.obj",
                  "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no upper arm\ng skin left\n"
                  "usemtl red\nf 3/1 2/1/1 1//1\nv 0 0 1\ng left\nf -1 -2 -3\n"
                  "usemtl\no\nf 1 2 3\no hand\ng\nusemtl blue sky\nv 5 5 5\nv 6 6 6\nl 5 6\np 1\n"
                  "usemtl red\nf 4 5 6\n");
    EXPECT_EQ(groupsOf(*model), (NameList{"skin: 0 1 2", "left: 0 1 2 3", "upper arm: 0 1 2 3",
                                          "red: 0 1 2 3 4 5", "hand: 0 3 4 5", "blue sky: 0 4 5"}));
    EXPECT_TRUE(model->attributes().empty());
}

std::string vtuPiece(const std::string& x, const std::string& arrays) {
    return "<Piece NumberOfPoints='2' NumberOfCells='0'><Points><DataArray type='Float64' "
           "NumberOfComponents='3' format='ascii'>" +
           x + "</DataArray></Points><PointData>" + arrays + "</PointData></Piece>\n";
}

TEST(VtuAttributes, AreTheArraysOfPointData) {
    const auto file = [](const std::string& pieces) {
        return "<VTKFile type='UnstructuredGrid'><UnstructuredGrid>\n"
               "<Piece NumberOfPoints='0' NumberOfCells='0'><Points/></Piece>\n" +
               pieces + "</UnstructuredGrid></VTKFile>";
    };
    const auto arrays = [](const std::string& bend, const std::string& pair) {
        return "<DataArray type='Float32' Name='bend' format='ascii'>" + bend +
               "</DataArray><DataArray type='UInt8' Name='pair' NumberOfComponents='2' "
               "format='ascii'>" +
               pair + "</DataArray><DataArray type='String' Name='text' format='ascii'>" +
               "65 0 66 0</DataArray>";
    };
    const auto model =
        readModel("a.vtu", file(vtuPiece("0 0 0 1 1 1", arrays("0 .5", "1 2 3 4")) +
                                vtuPiece("2 2 2 3 3 3", arrays("1 .25", "5 6 7 8"))));
    EXPECT_EQ(namesOf(model->attributes()), (NameList{"bend", "pair:0", "pair:1"}));
    EXPECT_EQ(numbersOf("a.vtu", *model, "bend"), (NumberList{0, 0.5, 1, 0.25}));
    EXPECT_EQ(numbersOf("a.vtu", *model, "pair:1"), (NumberList{2, 4, 6, 8}));
    // Three bytes for each point are a colour.
    const auto colors = readModel(
        "a.vtu", file(vtuPiece("0 0 0 1 1 1",
                               "<DataArray type='UInt8' Name='RGB' NumberOfComponents='3' "
                               "format='ascii'>255 0 51 0 102 255</DataArray>")));
    EXPECT_EQ(numbersOf("a.vtu", *colors, "RGB:0"), (NumberList{1, 0}));
    EXPECT_EQ(numbersOf("a.vtu", *colors, "RGB:2"), (NumberList{0.2, 1}));
    const auto uneven = readModel(
        "a.vtu", file(vtuPiece("0 0 0 1 1 1", arrays("0 .5", "1 2 3 4")) +
                      vtuPiece("2 2 2 3 3 3",
                               "<DataArray type='Float32' Name='bend' NumberOfComponents='2' "
                               "format='ascii'>1 1 1 1</DataArray>")));
    EXPECT_REFUSED(FileError, "the array 'bend' has 2 components, and 1 in another piece",
                   numbersOf("a.vtu", *uneven, "bend"));
    EXPECT_REFUSED(FileError, "pair", numbersOf("a.vtu", *uneven, "pair:0"));
}

TEST(VtkLegacyAttributes, AreTheArraysOfPointData) {
    const std::string text =
        "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 2 float\n0 0 0 1 1 1\n"
        "FIELD before 1\nother 1 2 int\n1 2\nCELL_DATA 1\nSCALARS cells int\nLOOKUP_TABLE x\n1\n"
        "POINT_DATA 2\nSCALARS bend float 1\nLOOKUP_TABLE default\n0.5 1\n"
        "FIELD more 3\npair 2 2 double\n.1 .2 .3 .4\nlast 1 2 unsigned_char\n0 1\n"
        "rgba 4 2 unsigned_char\n255 0 0 51\n0 0 0 255\n";
    const auto model = readModel("a.vtk", text);
    EXPECT_EQ(namesOf(model->attributes()), (NameList{"bend", "pair:0", "pair:1", "last", "rgba:0",
                                                      "rgba:1", "rgba:2", "rgba:3"}));
    EXPECT_EQ(numbersOf("a.vtk", *model, "bend"), (NumberList{0.5, 1}));
    EXPECT_EQ(numbersOf("a.vtk", *model, "pair:0"), (NumberList{0.1, 0.3}));
    EXPECT_EQ(numbersOf("a.vtk", *model, "last"), (NumberList{0, 1}));
    EXPECT_EQ(numbersOf("a.vtk", *model, "rgba:3"), (NumberList{0.2, 1}));
}

// Four points of two triangles. The weights are the attribute, and 0 outside the groups.
TEST(ModelParts, AreAttributesTimesGroups) {
    const auto model = readModel("a.obj",
                                 "v 0 0 0 1 .5 0\nv 1 0 0 .5 0 1\nv 1 1 0 .25 0 1\nv 0 1 0 2e-1 0 "
                                 "1\ng a\nf 1 2 3\ng b\nf 1 3 4\n");
    EXPECT_EQ(weightsOf("a.obj", *model, {}, true), bind::PointWeights());
    EXPECT_EQ(weightsOf("a.obj", *model, {{}, {"b"}}, false).values, (NumberList{1, 0, 1, 1}));
    EXPECT_EQ(weightsOf("a.obj", *model, {{}, {"b", "a"}}, false).values, (NumberList{1, 1, 1, 1}));
    EXPECT_EQ(weightsOf("a.obj", *model, {"red", {}}, false).values,
              (NumberList{1, 0.5, 0.25, 0.2}));
    const auto both = weightsOf("a.obj", *model, {"red", {"b"}}, true);
    EXPECT_EQ(both.values, (NumberList{1, 0, 0.25, 0.2}));
    EXPECT_EQ(both.slopes,
              bind::slopesOnSurface(model->positions(), std::vector<Index>{0, 1, 2, 0, 2, 3},
                                    std::vector<std::size_t>{3, 6}, both.values));
    // In the triangle 1 2 3 the weight falls by 1 along x, and rises by 0.25 along y.
    for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(both.slopes[1][c], (Point3{-1, 0.25, 0})[c], 1e-15);  // The rounding of sums.
    const auto points = readModel("a.obj", "v 0 0 0 1 .5 0\n");
    EXPECT_TRUE(weightsOf("a.obj", *points, {"red", {}}, true).slopes.empty());
}

TEST(ModelParts, HoldPoints) {
    const auto model = readModel("a.obj",
                                 "v 0 0 0 1 .5 0\nv 1 0 0 .5 0 1\nv 1 1 0 .25 0 1\nv 0 1 0 2e-1 0 "
                                 "1\ng a\nf 1 2 3\ng b\nf 1 3 4\n");
    EXPECT_EQ(weightsOf("a.obj", *model, {.holds = {"b"}}, false).values, (NumberList{0, 1, 0, 0}));
    EXPECT_EQ(weightsOf("a.obj", *model, {.weights = "red", .groups = {"a"}, .holds = {"b"}}, false)
                  .values,
              (NumberList{0, 0.5, 0, 0}));
    EXPECT_THAT(heldPointsOf("a.obj", *model, {.holds = {"b", "a"}}), ElementsAre(0, 1, 2, 3));
    EXPECT_THAT(heldPointsOf("a.obj", *model, {.groups = {"a"}}), IsEmpty());
    EXPECT_REFUSED(FileError, "a.obj: has no group 'c' of points; it has 'a', 'b'",
                   heldPointsOf("a.obj", *model, {.holds = {"c"}}));
}

// A group of an OBJ has the faces within it; a patch of a mesh is as the mesh has it.
TEST(ModelParts, ArePatchesWithFaces) {
    const auto model = readModel(
        "a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 2 0\ng a\nf 1 2 3\ng b\nf 1 3 4\n");
    const far::MeshPatch patch = patchOf("a.obj", *model, "b");
    EXPECT_EQ(patch.name, "b");
    EXPECT_EQ(patch.dimension, 2);
    EXPECT_THAT(patch.points, ElementsAre(0, 2, 3));
    ASSERT_EQ(patch.faceCount(), 1);
    EXPECT_THAT(patch.faces[0], ElementsAre(0, 2, 3));
    EXPECT_REFUSED(FileError, "a.obj: has no group 'c'", patchOf("a.obj", *model, "c"));
    const auto mesh = readModel("a.su2",
                                "NDIME= 2\nNELEM= 1\n9 0 1 2 3\nNPOIN= 4\n0 0\n1 0\n1 1\n0 1\n"
                                "NMARK= 1\nMARKER_TAG= wall\nMARKER_ELEMS= 2\n3 0 1\n3 1 2\n");
    const far::MeshPatch wall = patchOf("a.su2", *mesh, "wall");
    EXPECT_EQ(wall.dimension, 1);
    ASSERT_EQ(wall.lines.count(), 2u);
    EXPECT_THAT(wall.lines[1], ElementsAre(1, 2));
}

TEST(ModelParts, ThatDoNotExistAreRefusedWithTheNames) {
    const auto model =
        readModel("a.obj", "v 0 0 0 1 .5 0\nv 1 0 0 .5 1.5 1\nv 0 1 0 0 0 0\ng a b\nf 1 2 3\n");
    const auto refuse = [&](const std::string& message, const ModelPart& part, const Model& of) {
        EXPECT_REFUSED(FileError, message, weightsOf("a.obj", of, part, true));
    };
    refuse("a.obj: has no attribute 'x' of points; it has 'red', 'green', 'blue'", {"x", {}},
           *model);
    refuse("has 'green' = 1.5 at point 1; weights are 0 to 1", {"green", {}}, *model);
    refuse("a.obj: has no group 'c' of points; it has 'a', 'b'", {{}, {"a", "c"}}, *model);
    const auto ply =
        readModel("a.ply",
                  "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty "
                  "float y\nproperty float z\nproperty float w\nproperty float "
                  "v\nend_header\n0 0 0 1 nan\n1 1 1 1.5 0\n");
    refuse("has 'w' = 1.5 at point 1; weights are 0 to 1", {"w", {}}, *ply);
    refuse("has 'v' = nan at point 0; weights are 0 to 1", {"v", {}}, *ply);
    const auto word =
        readModel("b.ply",
                  "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty "
                  "float y\nproperty float z\nproperty float w\nend_header\n0 0 0 abc\n");
    refuse("b.ply:9: 'abc' is not a number; expected the property 'w'", {"w", {}}, *word);
    refuse("has no attribute 'x' of points; it has 'w', 'v'", {"x", {}}, *ply);
    refuse("has no group 'g' of points; there are none", {{}, {"g"}}, *ply);
}

}  // namespace
}  // namespace espalier::io

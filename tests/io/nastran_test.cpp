// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/number_text.h>
#include <espalier/far/second_order_cells.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <io/mesh_samples.h>
#include <io/meshes/nastran_card.h>

#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <tuple>

#include "support/test.h"

namespace espalier::io {
namespace {

/// A tetrahedron in fields of 8, of 16 and of any number of characters. Its points have the numbers
/// 10, 11, 12 and 13.
const std::string kSmall =
    "SOL 101\nCEND\nTITLE = GRID\nBEGIN BULK\n$ points\n"
    "GRID          10              0.      0.      0.\n"
    "GRID          11              1.     0.0     0.0       0 $ second\n"
    "GRID          12                      1.\n"
    "GRID    13              0.      0.      1.\n"
    "CTETRA         1       1      10      11      12      13\nENDDATA\nGRID is not read\n";
const std::string kLarge =
    "GRID*                 10                              0.              0.*\n"
    "*                     0.\n"
    "grid*   11                              1.0D+0          0.              *G1\n"
    "*G1     0.              \n"
    "GRID*                 12                              0.             1.0\n"
    "GRID*                 13                              0.              0.*\r\n"
    "*                   1.+0               0\n"
    "CTETRA  1       1       10      11      12      13\n";
const std::string kFree =
    "GRID,10,,0.,0.,0.\nGRID,11,0,1., ,0. $ second\nGRID,12,,,1.\nGRID,13,,,,1.,\n"
    "CTETRA,1,1,10,11,\n,12\n";

const std::vector<Point3> kCorners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

TEST(Nastran, FieldsOfAllKindsAreRead) {
    const std::string free = kFree.substr(0, kFree.find("CTETRA")) + "CTETRA,1,1,10,11,12,13\n";
    for (const std::string& text : {kSmall, kLarge, free}) {
        SCOPED_TRACE(text);
        const auto model = readModel("a.bdf", text);
        EXPECT_EQ(copyOf(model->positions()), kCorners);
        EXPECT_THAT(model->readCells().volume.corners(0), ElementsAre(0, 1, 2, 3));
        EXPECT_EQ(readLattice("a.NAS", text).complex.count(3), 1);
        EXPECT_EQ(written(*model, model->positions()), text);
    }
}

TEST(Nastran, OnlyChangedFieldsAreReplaced) {
    const auto moved = [](const std::string& text, std::size_t point, Point3 to) {
        const auto model = readModel("a.bdf", text);
        auto points = copyOf(model->positions());
        points[point] = to;
        const std::string result = written(*model, points);
        EXPECT_EQ(copyOf(readModel("a.bdf", result)->positions()), model->stored(points)) << result;
        return result;
    };
    const auto replaced = [](std::string text, const std::string& before,
                             const std::string& after) {
        const std::size_t at = text.find(before);
        EXPECT_NE(at, std::string::npos) << before;
        return text.replace(at, before.size(), after);
    };
    // Numbers stay at the right of their fields, or at the left.
    EXPECT_EQ(moved(kSmall, 1, {1.0 / 3, 0, -2}),
              replaced(kSmall, "      1.     0.0     0.0 ", ".3333333     0.0     -2. "));
    EXPECT_EQ(moved(kSmall, 3, {-1.5, 0, 1}),
              replaced(kSmall, "13              0.  ", "13              -1.5"));
    // The line ends before its last field.
    EXPECT_EQ(moved(kSmall, 2, {0, 1, 4}), replaced(kSmall, "      1.\n", "      1.      4.\n"));
    EXPECT_EQ(moved(kLarge, 1, {0.1, 0, -1.0 / 3}),
              replaced(replaced(kLarge, "1.0D+0", ".1    "), "*G1     0.              ",
                       "*G1     -.33333333333333"));
    // The file has no line for z.
    EXPECT_EQ(
        moved(kLarge, 2, {0, 1, 2}),
        replaced(kLarge, "             1.0\n", "             1.0\n*                     2.\n"));
    EXPECT_EQ(moved(kLarge, 3, {0, 0, 2}), replaced(kLarge, "1.+0", "  2."));
    const std::string free = kFree.substr(0, kFree.find("CTETRA"));
    EXPECT_EQ(moved(free, 1, {0.1, 1.0 / 3, 0}), replaced(free, "1., ,", ".1,.3333333333333333,"));
    EXPECT_EQ(moved(free, 2, {0, 1, 2}), replaced(free, ",,,1.\n", ",,,1.,2.\n"));
    EXPECT_EQ(moved(free, 3, {1e-9, 0, 1}), replaced(free, "13,,,,1.", "13,,1.-9,,1."));
}

/// A tab goes to the next multiple of 8 columns.
TEST(Nastran, TabsSeparateFields) {
    const std::string text =
        "GRID\t1\t\t0.5\t 1.\nGRID    2\t\t0.\t0.\t2.\t$ end\n"
        "GRID*\t3\t\t\t\t\t\t1.\t\t*\n*\t4.\nGRID\t4\nCTETRA\t1\t1\t1\t2\t3\t4\n";
    const auto model = readModel("a.bdf", text);
    EXPECT_EQ(copyOf(model->positions()),
              (std::vector<Point3>{{0.5, 1, 0}, {0, 0, 2}, {0, 1, 4}, {0, 0, 0}}));
    EXPECT_EQ(model->readCells().volume.cellCount(), 1);
    EXPECT_EQ(written(*model, model->positions()), text);
    const std::vector<Point3> moved = {{0.25, 2, 3}, {0, -1.0 / 3, 2}, {0, 5, 6}, {0, 7, 0}};
    const std::string result = written(*model, moved);
    // "GRID" and a tab are 8 columns, and the number of the last point is in column 8.
    EXPECT_EQ(result,
              "GRID\t1\t\t.25           2.      3.\nGRID    2\t\t0.\t-.3333332.\t$ end\n"
              "GRID*\t3\t\t\t\t\t\t5.              *\n*\t6.              \nGRID\t4" +
                  std::string(29, ' ') + "7.\nCTETRA\t1\t1\t1\t2\t3\t4\n");
    EXPECT_EQ(copyOf(readModel("a.bdf", result)->positions()), model->stored(moved));
}

/// No shorter or longer text of a number that fits is nearer to it, by more than the last digit.
TEST(Nastran, NumbersKeepTheDigitsThatFit) {
    for (const auto& [number, width, text] :
         std::vector<std::tuple<double, std::size_t, std::string>>{
             {1, 8, "1."},
             {-1, 8, "-1."},
             {0, 8, "0."},
             {-0.0, 8, "-0."},
             {1234567890, 8, "1.2346+9"},
             {-1234567890, 8, "-1.235+9"},
             {123456.789, 8, "123456.8"},
             {1.0 / 3, 8, ".3333333"},
             {-1.0 / 3, 8, "-.333333"},
             {0.0012345678, 8, ".0012346"},
             {1.2345678e-5, 8, "1.2346-5"},
             {-1.2345678e-105, 8, "-1.2-105"},
             {9.9999999, 8, "10."},
             {99999999, 8, "1.+8"},
             {1.0 / 3, 16, ".333333333333333"},
             {-2.0 / 3, 16, "-.66666666666667"},
             {1.0 / 3, 0, ".3333333333333333"},
             {1e300, 0, "1.+300"},
             {std::numeric_limits<double>::max(), 8, "1.79+308"},
             {std::numeric_limits<double>::denorm_min(), 8, "5.-324"}}) {
        EXPECT_EQ(nastranText(number, width), text) << number;
    }
    std::mt19937 random(7);
    std::uniform_real_distribution<double> mantissa(-10, 10);
    std::uniform_int_distribution<int> exponent(-40, 40);
    for (int i = 0; i < 20000; ++i) {
        const double number = mantissa(random) * std::pow(10, exponent(random));
        for (const std::size_t width : {8, 16}) {
            const std::string text = nastranText(number, width);
            EXPECT_LE(text.size(), width) << text;
            EXPECT_NE(text.find('.'), std::string::npos) << text;
            // A field of 8 keeps at least 4 digits of a number with an exponent of two digits.
            EXPECT_NEAR(roundedToField(number, width), number,
                        std::abs(number) * (width == 8 ? 0.006 : 1e-10));
            EXPECT_EQ(nastranText(roundedToField(number, width), width), text);
        }
        EXPECT_EQ(parseNastranReal(nastranText(number, 0)), number);
    }
}

TEST(Nastran, LossesAreSaid) {
    EXPECT_EQ(
        readModel("a.bdf", kSmall)->checkTarget("b.bdf"),
        "b.bdf: 4 points in fields of 8 characters: a coordinate that moves keeps 6 digits, or "
        "7 if it is positive, which rounds it by at most 5e-06 up to a size of 1");
    EXPECT_THAT(readModel("a.bdf", kLarge)->checkTarget("b.bdf"),
                HasSubstr("4 points in fields of 16 characters: a coordinate that moves keeps 14"));
    EXPECT_EQ(readModel("a.bdf", kFree)->checkTarget("b.bdf"), "");
}

/// The bound that checkTarget() tells holds for all numbers, and is not much too large: negative
/// numbers just below a power of ten reach half of it.
TEST(Nastran, RoundingHasABound) {
    std::mt19937 random(8);
    std::uniform_real_distribution<double> share(-1, 1);
    for (const std::size_t width : {8, 16})
        for (int power = -3; power <= 20; ++power) {
            const double size = std::nextafter(std::pow(10, power), 0);
            const double bound = largestRounding(size, width);
            double worst = 0;
            for (int i = 0; i < 2000; ++i) {
                const double number = i % 2 == 0 ? share(random) * size
                                                 : -size * (1 - 1e-3 * std::abs(share(random)));
                worst = std::max(worst, std::abs(roundedToField(number, width) - number));
            }
            EXPECT_LE(worst, bound + 1e-15 * size) << width << " " << power;
            // Below 1 the bound is that of 1; numbers of 17 digits fit where it is small.
            if (power >= 0 && bound > 4e-16 * size) {
                EXPECT_GE(worst, bound / 2) << width << " " << power;
            }
        }
}

TEST(Nastran, PropertiesAreGroups) {
    const std::string grids =
        "GRID,1\nGRID,2,,1.\nGRID,3,,,1.\nGRID,4,,,,1.\nGRID,5,,2.\nGRID,6,,3.\n";
    const std::string elements =
        "CTETRA,1,7,1,2,3,4\nCTRIA3,2,3,1,2,3\nCTRIA3,3,4,1,2,4\nCTRIA3,4,3,2,3,4\nCBAR,5,9,5,6\n";
    const auto namesOf = [&](const std::string& comments) {
        std::vector<std::string> names;
        for (const far::MeshPatch& patch :
             readModel("a.bdf", comments + grids + elements)->readCells().patches)
            names.push_back(patch.name);
        return names;
    };
    const auto patches = readModel("a.bdf", grids + elements)->readCells().patches;
    ASSERT_EQ(patches.size(), 4u);
    EXPECT_EQ(patches[0].dimension, 3);
    EXPECT_THAT(patches[1].points, ElementsAre(0, 1, 2, 3));
    EXPECT_EQ(patches[1].faceCount(), 2);
    EXPECT_THAT(patches[2].points, ElementsAre(0, 1, 3));
    EXPECT_THAT(patches[3].points, ElementsAre(4, 5));
    EXPECT_THAT(namesOf(""), ElementsAre("volume 7", "surface 3", "surface 4", "line 9"));
    EXPECT_THAT(namesOf("$HMNAME PROP                   3\"wall 1\" 4\n"
                        "$HMNAME COMP                   4\"other\"\n"
                        "$ANSA_NAME_COMMENT;4;PSHELL;in let;;NO;\n"
                        "$ Femap with NX Nastran Property 7 : Solid\n"
                        "$*  I-DEAS property: 9  name: beams\r\n"),
                ElementsAre("Solid", "wall 1", "in let", "beams"));
    EXPECT_THAT(namesOf("$ Elements and Element Properties for region : skin\nPSHELL   3       1\n"
                        "$*  NX Property: core\n$*\nPSOLID,7,1\n$*  NX Property: lost\nMAT1,4\n"),
                ElementsAre("core", "skin", "surface 4", "line 9"));
}

/// Nastran has the points between the ends of a hexahedron and of a wedge before those of the
/// second end.
TEST(Nastran, ElementsOfSecondOrderAreInTheOrderOfVtk) {
    const auto read = [](const std::string& name, const std::string& numbers, int points) {
        std::string text;
        for (int i = 1; i <= points; ++i)
            text += concat("GRID,", i, ",,", i, ".,", i * i, ".,", i * i * i, ".\n");
        return readModel("a.bdf", text + name + ",1,1" + numbers + "\n")->readCells();
    };
    const ModelCells box =
        read("CHEXA", ",1,2,3,4,5,6\n,7,8,9,10,11,12,13,14\n,15,16,17,18,19,20", 20);
    ASSERT_EQ(box.volume.cellCount(), 1);
    const auto points = box.volume.points(0);
    const std::set<Index> turned(points.begin(), points.end());
    EXPECT_EQ(turned.size(), 20u);
    // Point 12 (number 13) is between the corners 0 and 4, whichever way the cell is turned.
    const auto placeOf = [&](Index point) {
        return far::cellPoints(
            20)[static_cast<std::size_t>(std::ranges::find(points, point) - points.begin())];
    };
    for (const auto& [middle, a, b] :
         {std::tuple(8, 0, 1), {11, 3, 0}, {12, 0, 4}, {15, 3, 7}, {16, 4, 5}, {19, 7, 4}})
        EXPECT_EQ(placeOf(middle), placeOf(a) | placeOf(b)) << middle;
    const ModelCells wedge = read("CPENTA", ",1,2,3,4,5,6\n,7,8,9,10,11,12,13,14\n,15", 15);
    ASSERT_EQ(wedge.volume.cellCount(), 1);
    const auto corners = wedge.volume.points(0);
    const auto inWedge = [&](Index point) {
        return far::cellPoints(
            15)[static_cast<std::size_t>(std::ranges::find(corners, point) - corners.begin())];
    };
    for (const auto& [middle, a, b] :
         {std::tuple(6, 0, 1), {8, 2, 0}, {9, 0, 3}, {11, 2, 5}, {12, 3, 4}, {14, 5, 3}})
        EXPECT_EQ(inWedge(middle), inWedge(a) | inWedge(b)) << middle;
    EXPECT_EQ(read("CQUAD8", ",1,2,3,4,5,6\n,7,8,,,,0.5", 8).surface.points(0).size(), 8u);
    // A point between corners is missing.
    EXPECT_EQ(read("CTRIA6", ",1,2,3,4,,6", 6).curvedFaces, 1);
    EXPECT_EQ(read("CTRIA6", ",1,2,3", 6).surface.points(0).size(), 3u);
    EXPECT_EQ(read("CTETRA", ",1,2,3,4,5,6\n,7,8,9,10", 10).volume.points(0).size(), 10u);
    EXPECT_EQ(read("CTETRA", ",1,2,3,4,5,6\n,7,8,9", 10).curvedCells, 1);
    EXPECT_EQ(read("CPYRAM", ",1,2,3,4,5,6\n,7,8,9,10,11,12,13", 13).volume.points(0).size(), 13u);
    // Words of OptiStruct follow the points.
    EXPECT_EQ(read("CHEXA", ",1,2,3,4,5,6\n,7,8\n,CORDM,0", 8).volume.cellCount(), 1);
    EXPECT_EQ(read("CQUADX4", ",1,2,3,4", 4).unknownElements, 1);
    EXPECT_EQ(read("CBAR", ",1,2,0.,1.,0.", 4).unknownElements, 0);
}

TEST(Nastran, OtherFilesAreNamed) {
    const auto model =
        readModel("a.bdf", kFree.substr(0, kFree.find("CTETRA")) + "INCLUDE 'more.bdf'\n");
    EXPECT_THAT(model->notes(),
                ElementsAre("did not read the files that INCLUDE names: 'more.bdf'"));
    EXPECT_REFUSED(FileError, "has no entry GRID of its own; INCLUDE names 'more.bdf'",
                   readModel("a.bdf", "BEGIN BULK\ninclude 'more.bdf'\n"));
}

TEST(Nastran, MalformedFilesAreRefusedWithTheLine) {
    const auto expectRefused = [](const std::string& bytes, const std::string& message) {
        EXPECT_REFUSED(FileError, message, readModel("a.bdf", bytes)->readCells());
    };
    expectRefused("SOL 101\n", "a.bdf: has no entry GRID");
    expectRefused("GRID,1,,0.,x,0.\n", "a.bdf:1: 'x' is not a number; expected y of a point");
    expectRefused("GRID,1,,0.,inf,0.\n", "a.bdf:1: 'inf' is not a number");
    expectRefused("GRID,2\nGRID,1,3,0.,0.,0.\nGRID,3,2\n",
                  "a.bdf:2: a GRID is in the coordinate system 3, and 2 of 3 are not in the basic "
                  "one; write the mesh in the basic system (0) first");
    expectRefused("GRDSET,,3\nGRID,1,,0.,0.,0.\n",
                  "a.bdf:1: GRDSET puts points in the coordinate system 3");
    expectRefused("GRID,,,0.,0.,0.\n", "a.bdf:1: a GRID has no number");
    expectRefused("GRID,1\nGRID,1\nCBAR,1,1,1,1\n", "a.bdf: two entries GRID have the number 1");
    expectRefused(kFree, "a.bdf:5: a CTETRA has 2 points; expected 4");
    expectRefused("GRID,1\nCTRIA3,1,1,1,1,2\n",
                  "a.bdf:2: a CTRIA3 names GRID 2, which does not exist");
}

}  // namespace
}  // namespace espalier::io

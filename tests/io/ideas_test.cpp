// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/second_order_cells.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <io/mesh_samples.h>
#include <io/meshes/ideas_elements.h>

#include <cmath>
#include <cstdio>
#include <random>
#include <tuple>

#include "support/test.h"

namespace espalier::io {
namespace {

/// A text right-aligned in columns.
std::string columns(const std::string& text, std::size_t width) {
    return std::string(width - text.size(), ' ') + text;
}

std::string integers(const std::vector<int>& numbers) {
    std::string text;
    for (const int number : numbers) text += columns(std::to_string(number), 10);
    return text + "\n";
}

std::string dataset(int number, const std::string& lines) {
    return "    -1\n" + columns(std::to_string(number), 6) + "\n" + lines + "    -1\n";
}

/// A number as Salome writes it, in columns of 25 characters.
std::string real(double number) {
    char text[40];
    std::snprintf(text, sizeof text, "%25.16E", number);
    return text;
}

std::string nodes(const std::vector<Point3>& points) {
    std::string text;
    int number = 0;
    for (const Point3& point : points)
        text += integers({++number, 1, 1, 11}) + real(point[0]) + real(point[1]) + real(point[2]) +
                "\n";
    return dataset(2411, text);
}

std::string element(int number, int descriptor, const std::vector<int>& points) {
    std::string text = integers({number, descriptor, 2, 1, 7, static_cast<int>(points.size())});
    if (descriptor < 40) text += integers({0, 0, 0});
    for (std::size_t i = 0; i < points.size(); i += 8)
        text += integers(
            {points.begin() + static_cast<std::ptrdiff_t>(i),
             points.begin() + static_cast<std::ptrdiff_t>(std::min(i + 8, points.size()))});
    return text;
}

/// The mesh of mesh_samples.h.
std::string sampleIdeas() {
    std::string elements = element(1, 21, {1, 2});
    const int descriptors[] = {115, 312, 112, 111};
    for (std::size_t cell = 0; cell < 4; ++cell) {
        std::vector<int> points = sampleCells()[cell];
        for (int& point : points) ++point;
        elements += element(static_cast<int>(cell) + 2, descriptors[cell], points);
    }
    elements += element(6, 44, {1, 4, 3, 2}) + element(7, 91, {5, 6, 9}) + element(8, 161, {3});
    const std::string groups = integers({1, 0, 0, 0, 0, 0, 0, 3}) + "walls\n" +
                               integers({8, 6, 0, 0, 8, 7, 0, 0}) + integers({8, 99, 0, 0}) +
                               integers({2, 0, 0, 0, 0, 0, 0, 2}) + "tip\n" +
                               integers({7, 12, 0, 0, 7, 9, 0, 0});
    return dataset(164, "         1  SI: Meter (newton)         2\n") + nodes(samplePoints()) +
           dataset(2412, elements) + dataset(2467, groups);
}

TEST(Ideas, MeshesAreReadAndWrittenInPlace) {
    const std::string text = sampleIdeas();
    const auto model = readModel("a.unv", text);
    EXPECT_EQ(copyOf(model->positions()), samplePoints());
    EXPECT_THAT(model->notes(), IsEmpty());
    EXPECT_EQ(model->checkTarget("b.unv"), "");
    EXPECT_EQ(written(*model, model->positions()), text);
    const ModelCells cells = model->readCells();
    EXPECT_EQ(cells.volume.cellCount(), 4);
    EXPECT_EQ(cells.unknownElements, 0);
    EXPECT_EQ(model->readSurface().faces.count(), 2u);
    EXPECT_EQ(readLattice("a.UNV", text).complex.count(3), 4);
    ASSERT_EQ(cells.patches.size(), 2u);
    EXPECT_EQ(cells.patches[0].name, "walls");
    EXPECT_EQ(cells.patches[0].faceCount(), 2);
    EXPECT_THAT(cells.patches[0].points, ElementsAre(0, 1, 2, 3, 4, 5, 8));
    EXPECT_EQ(cells.patches[1].name, "tip");
    EXPECT_EQ(cells.patches[1].dimension, 0);
    EXPECT_THAT(cells.patches[1].points, ElementsAre(8, 11));
}

/// Programs read the coordinates by their columns.
TEST(Ideas, NewCoordinatesStayInTheirColumns) {
    const std::string text = sampleIdeas();
    const auto model = readModel("a.unv", text);
    auto moved = copyOf(model->positions());
    moved[1][1] = -1.2345678901234567e-100;
    moved[11] = {1.0 / 3, -7, 3};
    std::string expected = text;
    const auto replace = [&](std::size_t node, std::size_t axis, const std::string& number) {
        std::size_t at = expected.find(integers({static_cast<int>(node) + 1, 1, 1, 11}));
        at = expected.find('\n', at) + 1 + 25 * axis;
        expected.replace(at, 25, columns(number, 25));
    };
    replace(1, 1, "-1.2345678901234567E-100");
    replace(11, 0, "3.333333333333333E-01");
    replace(11, 1, "-7.0E+00");
    EXPECT_EQ(written(*model, moved), expected);
    EXPECT_EQ(copyOf(readModel("a.unv", expected)->positions()), moved);
    EXPECT_EQ(model->stored(moved), moved);
}

/// The dataset 15 has columns of 13 characters, and exponents may begin with a D.
TEST(Ideas, NodesOfSinglePrecisionAreRounded) {
    const std::string text = dataset(
        15,
        "         3         0         0         8  1.00000E+00  0.00000E+00 -2.50000E+02\n"
        "         4         0         0         8  1.00000D+00  0.00000E+00 -2.50000E+02\n");
    const auto model = readModel("a.unv", text);
    EXPECT_EQ(copyOf(model->positions()), (std::vector<Point3>{{1, 0, -250}, {1, 0, -250}}));
    EXPECT_EQ(
        model->checkTarget("b.unv"),
        "b.unv: 2 points in fields of 13 characters (dataset 15): a coordinate that moves keeps "
        "6 digits, or 7 if it is positive, which rounds it by at most 5e-04 up to a size of "
        "250");
    auto moved = copyOf(model->positions());
    moved[0] = {1.0 / 3, 0, -100.0 / 3};
    moved[1][0] = -1e-7 / 3;
    const std::string result = written(*model, moved);
    EXPECT_THAT(result, HasSubstr("         8 3.333333E-01  0.00000E+00 -3.33333E+01\n"));
    EXPECT_THAT(result, HasSubstr("         8 -3.33333D-08  0.00000E+00 -2.50000E+02\n"));
    EXPECT_EQ(copyOf(readModel("a.unv", result)->positions()), model->stored(moved));
    // The bound of checkTarget() holds up to the largest coordinate.
    std::mt19937 random(3);
    std::uniform_real_distribution<double> number(-250, 250);
    double worst = 0;
    for (int i = 0; i < 2000; ++i) {
        moved[0][0] = number(random);
        worst = std::max(worst, std::abs(model->stored(moved)[0][0] - moved[0][0]));
    }
    EXPECT_LE(worst, 0.0005 * (1 + 1e-9));
    EXPECT_GE(worst, 0.0004);
}

/// Some programs do not use the columns.
TEST(Ideas, NumbersWithoutColumnsKeepAllDigits) {
    const std::string text = dataset(2411, "1 0 0 0\n0.1 2 -3.5\n");
    const auto model = readModel("a.unv", text);
    EXPECT_EQ(model->checkTarget("b.unv"), "");
    std::vector<Point3> moved = {{0.1, 2.0 / 3, 12}};
    const std::string result = written(*model, moved);
    EXPECT_THAT(result, HasSubstr("\n0.1 6.666666666666666E-01 1.2E+01\n"));
    EXPECT_EQ(copyOf(readModel("a.unv", result)->positions()), moved);
}

/// More numbers in the columns of a coordinate, or beside it, stay.
TEST(Ideas, ColumnsHaveOneNumber) {
    const std::string text =
        dataset(2411, "1 0 0 0\n" + real(1) + real(2) + "                3. 4.\n2 0 0 0\n" +
                          real(1) + real(2) + real(3) + "    5.\n3 0 0 0\n" + "  1." +
                          std::string(21, ' ') + "2." + std::string(23, ' ') + real(3) + "\n");
    const auto model = readModel("a.unv", text);
    const std::vector<Point3> moved = {{1, 2, -1.0 / 3}, {1, 2, -1.0 / 3}, {-1.0 / 3, 2, -1.0 / 3}};
    const std::string result = written(*model, moved);
    EXPECT_THAT(result, HasSubstr("                -3.333333333333333E-01 4.\n"));
    EXPECT_THAT(result, HasSubstr("E+00   -3.333333333333333E-01    5.\n"));
    // The second number is where the first one could end.
    EXPECT_THAT(result, HasSubstr("\n  -3.333333333333333E-01" + std::string(21, ' ') + "2."));
    EXPECT_EQ(copyOf(readModel("a.unv", result)->positions()), moved);
    // A number at the begin of its columns gets a space before it.
    const std::string left =
        dataset(2411, "1 0 0 0\n1." + std::string(24, ' ') + "2." + std::string(23, ' ') + "3.\n");
    const std::vector<Point3> longer = {{-1.0 / 3, -1.0 / 3, -1.0 / 3}};
    const std::string replaced = written(*readModel("a.unv", left), longer);
    EXPECT_EQ(copyOf(readModel("a.unv", replaced)->positions()), longer);
    const std::string number = "   -3.333333333333333E-01";
    EXPECT_THAT(replaced, HasSubstr("\n" + number + number + number + "\n"));
}

/// I-deas has the points between corners on the way around. The points are in the middle of the
/// corners, so that each order but the right one gives another cell.
TEST(Ideas, ElementsOfSecondOrder) {
    const auto middleOf = [](const Point3& a, const Point3& b) {
        return Point3{(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2};
    };
    const auto test = [&](int descriptor, const std::vector<Point3>& corners,
                          const std::vector<std::array<int, 2>>& order) {
        // {c, c} is corner c, and {a, b} the middle between two corners.
        std::vector<Point3> points;
        std::vector<int> numbers;
        for (const auto& [a, b] : order) {
            points.push_back(middleOf(corners[static_cast<std::size_t>(a)],
                                      corners[static_cast<std::size_t>(b)]));
            numbers.push_back(static_cast<int>(points.size()));
        }
        const auto model =
            readModel("a.unv", nodes(points) + dataset(2412, element(1, descriptor, numbers)));
        const ModelCells cells = model->readCells();
        ASSERT_EQ(cells.cellCount(), 1) << descriptor;
        const bool isFace = cells.isSurface();
        const auto ofCell = isFace ? cells.surface.points(0) : cells.volume.points(0);
        ASSERT_EQ(ofCell.size(), points.size());
        const auto at = [&](std::size_t i) {
            return model->positions()[static_cast<std::size_t>(ofCell[i])];
        };
        const std::size_t cornerCount = corners.size();
        for (std::size_t i = 0; i < ofCell.size(); ++i) {
            std::vector<Point3> ends;
            if (isFace && i >= cornerCount) ends = {at(i - cornerCount), at((i + 1) % cornerCount)};
            for (std::size_t c = 0; !isFace && c < cornerCount; ++c)
                if ((far::cellPoints(ofCell.size())[i] >> c) & 1) ends.push_back(at(c));
            if (ends.size() == 2) {
                EXPECT_EQ(at(i), middleOf(ends[0], ends[1])) << descriptor << " " << i;
            }
        }
    };
    const Point3 a{0, 0, 0}, b{2, 0, 0}, c{2, 4, 0}, d{0, 4, 0};
    const Point3 e{0, 0, 8}, f{2, 0, 8}, g{2, 4, 8}, h{0, 4, 8};
    test(42, {a, b, c}, {{0, 0}, {0, 1}, {1, 1}, {1, 2}, {2, 2}, {2, 0}});
    test(95, {a, b, c, d}, {{0, 0}, {0, 1}, {1, 1}, {1, 2}, {2, 2}, {2, 3}, {3, 3}, {3, 0}});
    test(118, {a, b, c, e},
         {{0, 0}, {0, 1}, {1, 1}, {1, 2}, {2, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}, {3, 3}});
    test(313, {a, b, c, d, e},
         {{0, 0},
          {0, 1},
          {1, 1},
          {1, 2},
          {2, 2},
          {2, 3},
          {3, 3},
          {3, 0},
          {0, 4},
          {1, 4},
          {2, 4},
          {3, 4},
          {4, 4}});
    test(113, {a, b, c, e, f, g},
         {{0, 0},
          {0, 1},
          {1, 1},
          {1, 2},
          {2, 2},
          {2, 0},
          {0, 3},
          {1, 4},
          {2, 5},
          {3, 3},
          {3, 4},
          {4, 4},
          {4, 5},
          {5, 5},
          {5, 3}});
    test(116, {a, b, c, d, e, f, g, h},
         {{0, 0}, {0, 1}, {1, 1}, {1, 2}, {2, 2}, {2, 3}, {3, 3}, {3, 0}, {0, 4}, {1, 5},
          {2, 6}, {3, 7}, {4, 4}, {4, 5}, {5, 5}, {5, 6}, {6, 6}, {6, 7}, {7, 7}, {7, 4}});
    EXPECT_EQ(ideasElement(117)->nodes, 0u);  // of third order
    EXPECT_EQ(ideasElement(9999), std::nullopt);
}

TEST(Ideas, OlderDatasetsAndUnknownElements) {
    const std::string old =
        dataset(781, "1 0 0 0\n0. 0. 0.\n2 0 0 0\n1. 0. 0.\n3 0 0 0\n0. 1.D0 0.\n") +
        dataset(780, integers({1, 41, 1, 1, 1, 1, 7, 3}) + integers({1, 2, 3}) +
                         integers({2, 500, 1, 1, 1, 1, 7, 3}) + integers({1, 2, 9})) +
        dataset(2432, integers({5, 0, 0, 0, 0, 0, 0, 2}) + "\n" + integers({8, 1, 7, 3}));
    const ModelCells cells = readModel("a.unv", old)->readCells();
    EXPECT_EQ(cells.surface.faceCount(), 1);
    EXPECT_EQ(cells.unknownElements, 1);
    ASSERT_EQ(cells.patches.size(), 1u);
    EXPECT_EQ(cells.patches[0].name, "group 5");
    EXPECT_THAT(cells.patches[0].points, ElementsAre(0, 1, 2));
}

TEST(Ideas, CoordinateSystemsAreNoted) {
    const auto system = [](int number, double origin) {
        return integers({number, 0, 8}) + "name\n" + real(1) + real(0) + real(0) + "\n" + real(0) +
               real(1) + real(0) + "\n" + real(0) + real(0) + real(1) + "\n" + real(origin) +
               real(0) + real(0) + "\n";
    };
    const auto notesOf = [&](double origin) {
        return readModel("a.unv", nodes({{0, 0, 0}, {1, 0, 0}}) +
                                      dataset(2420, "1\npart\n" + system(1, origin) + system(2, 7)))
            ->notes();
    };
    EXPECT_THAT(notesOf(0), IsEmpty());
    EXPECT_THAT(notesOf(3),
                ElementsAre("took the coordinates of 2 nodes as they are, though the dataset 2420 "
                            "gives them a coordinate system"));
}

TEST(Ideas, MalformedFilesAreRefusedWithTheLine) {
    const auto expectRefused = [](const std::string& bytes, const std::string& message) {
        EXPECT_REFUSED(FileError, message, readModel("a.unv", bytes)->readCells());
    };
    const std::string node = "1 0 0 0\n0. 0. 0.\n";
    expectRefused("hello\n", "a.unv: has no dataset; expected a line -1");
    expectRefused(dataset(164, "1\n"), "a.unv: has no nodes; expected a dataset 2411, 781 or 15");
    expectRefused(dataset(2411, "1 0 0 0\n"),
                  "a.unv:4: the dataset 2411 ends; expected the coordinates of a node");
    expectRefused(dataset(2411, "1 0 0 0\n0. x 0.\n"), "a.unv:4: 'x' is not a number");
    expectRefused(dataset(2411, "1 0 0 0\n0. 0.\n"), "a.unv:4: the line ends; expected z");
    expectRefused(dataset(2411, "1 0 0 0\n0. nan 0.\n"), "a.unv:4:");
    expectRefused(dataset(2411, node + node), "a.unv: two nodes have the number 1");
    expectRefused(dataset(2411, node) + dataset(2412, integers({1, 41, 1, 1, 1, 3}) + "1 1 2\n"),
                  "a.unv:9: an element names node 2, which does not exist");
    expectRefused(dataset(2411, node) + dataset(2412, integers({1, 41, 1, 1, 1, 4}) + "1 1 1 1\n"),
                  "a.unv:8: an element of the descriptor 41 has 4 nodes; expected 3");
    expectRefused(dataset(2411, node) + dataset(2412, integers({1, 41, 1, 1, 1, 3}) + "1 1\n"),
                  "the dataset 2412 ends; expected a node of an element");
    expectRefused(dataset(2411, node) + dataset(2467, integers({1, 0, 0, 0, 0, 0, 0, 3}) + "a\n"),
                  "the dataset ends, but a group has 3 more entities");
}

}  // namespace
}  // namespace espalier::io

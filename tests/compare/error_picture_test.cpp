// SPDX-License-Identifier: Apache-2.0

#include <pugixml.hpp>
#include <sstream>

#include "compare/error_picture.h"
#include "support/test.h"

namespace espalier::test {
namespace {

using compare::Colour;
using compare::ErrorScale;
using compare::SurfaceError;
using compare::SurfaceView;

/// Returns squares of side 1 in planes of constant z, above each other.
SurfaceError squares(const std::vector<double>& heights) {
    SurfaceError surface;
    for (const double z : heights) {
        const auto first = Index(surface.positions.size());
        for (const Point3& p : {Point3{0, 0, z}, {1, 0, z}, {1, 1, z}, {0, 1, z}})
            surface.positions.push_back(p);
        surface.faces.push_back({first, first + 1, first + 2, first + 3});
    }
    surface.errors.assign(surface.positions.size(), 0);
    return surface;
}

/// Returns n by n faces of the graph of a function over the unit square.
template <class Height>
SurfaceError graph(Index n, Height height) {
    SurfaceError surface;
    for (Index j = 0; j <= n; ++j)
        for (Index i = 0; i <= n; ++i)
            surface.positions.push_back({double(i) / n, double(j) / n, height(i, j)});
    for (Index j = 0; j < n; ++j)
        for (Index i = 0; i < n; ++i) {
            const Index v = j * (n + 1) + i;
            surface.faces.push_back({v, v + 1, v + n + 2, v + n + 1});
        }
    surface.errors.assign(surface.positions.size(), 0);
    return surface;
}

Colour read(const std::string& hex) {
    return {std::stoi(hex.substr(1, 2), nullptr, 16), std::stoi(hex.substr(3, 2), nullptr, 16),
            std::stoi(hex.substr(5, 2), nullptr, 16)};
}

/// A picture, parsed.
struct Picture {
    pugi::xml_document document;
    pugi::xml_node svg;

    explicit Picture(const SurfaceError& surface, const compare::Bounds& bounds = {}) {
        const std::string text = compare::errorPicture(surface, bounds);
        const auto result = document.load_buffer(text.data(), text.size(), pugi::parse_full);
        EXPECT_TRUE(result) << result.description();
        svg = document.child("svg");
    }

    pugi::xml_node surface() const { return svg.find_child_by_attribute("g", "class", "surface"); }

    std::vector<Colour> colours() const {
        std::vector<Colour> colours;
        for (const auto path : surface().children("path"))
            colours.push_back(read(path.attribute("color").value()));
        return colours;
    }

    /// Returns the corners of all faces, in px.
    std::vector<std::array<double, 2>> corners() const {
        std::vector<std::array<double, 2>> corners;
        for (const auto path : surface().children("path")) {
            std::string d = path.attribute("d").value();
            for (char& c : d)
                if (c == 'M' || c == 'l' || c == 'z') c = ' ';
            std::istringstream words(d);
            std::array<double, 2> at = {0, 0};
            std::array<double, 2> step{};
            // The first pair is a position, the others are steps.
            while (words >> step[0] >> step[1]) {
                at = {at[0] + step[0] / 10, at[1] + step[1] / 10};
                corners.push_back(at);
            }
        }
        return corners;
    }

    std::string words() const {
        std::string all;
        for (const auto& node : svg.select_nodes(".//text")) {
            all += node.node().child_value();
            all += '\n';
        }
        return all;
    }

    std::size_t rings() const { return svg.select_nodes(".//circle").size(); }
};

/// True if a colour is a darker shade of another: its channels are the same fraction of the
/// other's, each rounded to an integer.
bool isShadeOf(const Colour& shade, const Colour& colour) {
    const double part = double(shade[0]) / colour[0];
    return part <= 1.01 && std::abs(shade[1] - part * colour[1]) < 1.5 &&
           std::abs(shade[2] - part * colour[2]) < 1.5;
}

double luminance(const Colour& colour) {
    const auto linear = [](int channel) { return std::pow(channel / 255.0, 2.2); };
    return 0.2126 * linear(colour[0]) + 0.7152 * linear(colour[1]) + 0.0722 * linear(colour[2]);
}

TEST(ErrorScale, BoundDividesTheScale) {
    const ErrorScale scale(1e-13);
    EXPECT_EQ(scale.place(0), 0);
    EXPECT_EQ(scale.place(1e-18), 0);
    EXPECT_EQ(scale.place(1e-13), ErrorScale::kBoundPlace);
    EXPECT_EQ(scale.place(1e-6), 1);
    EXPECT_EQ(scale.place(1), 1);
    // 1e-15 is three of five decades into the first part, 1e-10 three of seven into the second.
    EXPECT_NEAR(scale.place(1e-15), 2.0 / 3 * 3 / 5, 1e-12);
    EXPECT_NEAR(scale.place(1e-10), 2.0 / 3 + 1.0 / 3 * 3 / 7, 1e-12);
    EXPECT_EQ(ErrorScale(1e-10).place(1e-10), ErrorScale::kBoundPlace);
}

TEST(ErrorScale, PutsNanAtTheEnd) {
    const ErrorScale scale(1e-13);
    EXPECT_EQ(scale.place(kNan), 1);
    EXPECT_EQ(scale.place(kInfinity), 1);
    EXPECT_EQ(scale.colour(kNan), scale.colour(1));
}

TEST(ErrorScale, KeepsADecadeOfEachPartForAnyBound) {
    EXPECT_EQ(ErrorScale(0).place(1e-17), ErrorScale::kBoundPlace);
    EXPECT_EQ(ErrorScale(-1).place(1e-17), ErrorScale::kBoundPlace);
    EXPECT_EQ(ErrorScale(1e-30).place(1e-17), ErrorScale::kBoundPlace);
    EXPECT_NEAR(ErrorScale(1).place(1e-7), ErrorScale::kBoundPlace, 1e-12);
}

/// The ends and the middles of both parts are anchors of the map. The middle of 1e-18 to 1e-13 is
/// 10^-15.5, the middle of 1e-13 to 1e-6 is 10^-9.5.
TEST(ErrorScale, HasTheColoursOfTheMap) {
    const ErrorScale scale(1e-13);
    EXPECT_EQ(scale.colour(0), ErrorScale::kExact);
    EXPECT_EQ(scale.colour(1e-18), (Colour{233, 239, 197}));
    EXPECT_EQ(scale.colour(std::pow(10, -15.5)), (Colour{98, 184, 196}));
    EXPECT_EQ(scale.colour(1e-13), (Colour{44, 100, 168}));
    EXPECT_EQ(scale.colour(1.001e-13), (Colour{178, 60, 40}));
    EXPECT_EQ(scale.colour(std::pow(10, -9.5)), (Colour{149, 30, 55}));
    EXPECT_EQ(scale.colour(1e-6), (Colour{107, 13, 63}));
}

TEST(ErrorScale, GetsDarkerWithTheError) {
    const ErrorScale scale(1e-13);
    double last = 1;
    for (double log = -18; log <= -6; log += 0.25) {
        const double next = luminance(scale.colour(std::pow(10, log)));
        EXPECT_LT(next, last) << "at 10^" << log;
        last = next;
    }
}

TEST(ErrorScale, LabelsBothEndsAndTicksWithEnoughRoom) {
    std::vector<std::string> labels;
    double last = -1;
    for (const ErrorScale::Tick& tick : ErrorScale(1e-13).ticks(0.085)) {
        EXPECT_GT(tick.place, last);
        last = tick.place;
        if (!tick.label.empty()) labels.push_back(tick.label);
    }
    // Decades are 0.133 apart below the bound and 0.048 above it, so only every second one there
    // has a label, except 1e-7, which is too close to the end.
    EXPECT_THAT(labels, ElementsAre("1e-18", "1e-17", "1e-16", "1e-15", "1e-14", "1e-13", "1e-11",
                                    "1e-9", "1e-6"));
}

TEST(SurfaceView, PutsTheFartherFaceFirst) {
    // Seen from above, the square at height 1 hides the square at 0, in either order.
    EXPECT_EQ(compare::viewOf(squares({0, 1})).faces[0].face, 0);
    EXPECT_EQ(compare::viewOf(squares({1, 0})).faces[0].face, 1);
}

/// A square of side 1 is seen from 58 degrees above its plane, so that its area is multiplied by
/// sin 58°. Edge-on it would be 0. Lengths are in units of the largest coordinate, which is 1.
TEST(SurfaceView, LooksAtAFlatShapeFromWellAbove) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        SurfaceError surface = squares({0});
        for (Point3& p : surface.positions) std::rotate(p.begin(), p.begin() + 2 - axis, p.end());
        for (const Point3& p : surface.positions) EXPECT_EQ(p[axis], 0);
        const SurfaceView view = compare::viewOf(surface);
        const auto& q = view.points;
        const double area = 0.5 * ((q[2][0] - q[0][0]) * (q[3][1] - q[1][1]) -
                                   (q[2][1] - q[0][1]) * (q[3][0] - q[1][0]));
        EXPECT_NEAR(std::abs(area), 0.8480480961564260, 1e-12) << "across axis " << axis;
    }
}

TEST(SurfaceView, HasZUpUnlessTallInY) {
    const auto isUp = [](const Point3& extent, std::size_t axis) {
        SurfaceError surface;
        surface.positions = {{0, 0, 0}, {extent[0], 0, 0}, {0, extent[1], 0}, {0, 0, extent[2]}};
        surface.faces = {{0, 1, 2, 3}};
        surface.errors.assign(4, 0);
        const SurfaceView view = compare::viewOf(surface);
        // Up is vertical in the picture, and no other axis is.
        return std::abs(view.points[axis + 1][0] - view.points[0][0]) < 1e-12 &&
               view.points[axis + 1][1] < view.points[0][1];
    };
    EXPECT_TRUE(isUp({1, 1, 1}, 2));
    EXPECT_TRUE(isUp({3, 1, 1}, 2));
    EXPECT_TRUE(isUp({1, 1, 3}, 2));
    EXPECT_TRUE(isUp({1, 3, 1}, 1));
    EXPECT_TRUE(isUp({3, 0.5, 2}, 1));
    EXPECT_TRUE(isUp({0.5, 3, 2}, 0));
}

TEST(SurfaceView, IsNotAMirrorImage) {
    // In a cube, x points right and y backwards, which is up in the picture.
    const SurfaceView view = compare::viewOf(squares({0, 1}));
    EXPECT_GT(view.points[1][0], view.points[0][0]);
    EXPECT_LT(view.points[3][1], view.points[0][1]);
    EXPECT_LT(view.depths[3], view.depths[0]);
}

TEST(SurfaceView, LightsAFaceTheSameFromEitherSide) {
    SurfaceError surface = squares({0, 1});
    std::reverse(surface.faces[1].begin(), surface.faces[1].end());
    const SurfaceView view = compare::viewOf(surface);
    EXPECT_NEAR(view.faces[0].light, view.faces[1].light, 1e-12);
    EXPECT_GT(view.faces[0].light, 0.5);
}

TEST(ErrorPicture, DrawsEveryFace) {
    const Picture picture(graph(7, [](Index i, Index j) { return 0.1 * i * j; }));
    EXPECT_THAT(picture.colours(), SizeIs(49));
    EXPECT_THAT(picture.corners(), SizeIs(4 * 49));
    EXPECT_EQ(picture.svg.attribute("role").value(), std::string("img"));
    EXPECT_THAT(picture.svg.attribute("aria-label").value(), HasSubstr("49 faces"));
}

TEST(ErrorPicture, DrawsBackToFront) {
    SurfaceError surface = squares({1, 0});
    std::fill_n(surface.errors.begin(), 4, 1e-9);  // The upper square.
    const ErrorScale scale(compare::Bounds{}.position);
    const std::vector<Colour> colours = Picture(surface).colours();
    ASSERT_THAT(colours, SizeIs(2));
    EXPECT_TRUE(isShadeOf(colours[0], ErrorScale::kExact));
    EXPECT_TRUE(isShadeOf(colours[1], scale.colour(1e-9)));
}

TEST(ErrorPicture, ColoursAFaceByTheLargestErrorOfItsCorners) {
    const ErrorScale scale(compare::Bounds{}.position);
    for (const double error : {1e-18, 3e-17, 2e-16, 1e-14, 1e-13, 2e-13, 1e-9, 1.0}) {
        SurfaceError surface = squares({0});
        surface.errors = {0, error, error / 10, 0};
        const std::vector<Colour> colours = Picture(surface).colours();
        ASSERT_THAT(colours, SizeIs(1));
        EXPECT_TRUE(isShadeOf(colours[0], scale.colour(error))) << error;
    }
}

TEST(ErrorPicture, DividesTheColoursAtTheGivenBound) {
    SurfaceError surface = squares({0});
    surface.errors.assign(4, 1e-12);
    const auto colour = [&](double bound) {
        return Picture(surface, {.position = bound}).colours().at(0);
    };
    EXPECT_GT(colour(1e-13)[0], colour(1e-13)[2]);  // Red.
    EXPECT_LT(colour(1e-12)[0], colour(1e-12)[2]);  // Blue.
}

TEST(ErrorPicture, LeavesNoHairlinesBetweenFaces) {
    const Picture picture(squares({0}));
    EXPECT_EQ(picture.surface().attribute("fill").value(), std::string("currentColor"));
    EXPECT_EQ(picture.surface().attribute("stroke").value(), std::string("currentColor"));
    EXPECT_GT(picture.surface().attribute("stroke-width").as_double(), 0);
}

/// The room is 640 by 418 px, with a margin of 16 on every side; the longer dimension is filled.
TEST(ErrorPicture, FillsTheRoomAboveTheLegend) {
    const auto flat = [](Index, Index) { return 0.0; };
    SurfaceError wide = graph(4, flat);
    for (Point3& p : wide.positions) p[0] *= 10;
    SurfaceError tall = squares({0, 7});
    for (const SurfaceError& surface : {wide, tall, graph(3, flat)}) {
        const auto corners = Picture(surface).corners();
        const auto [left, right] = std::minmax_element(corners.begin(), corners.end());
        const auto [top, bottom] =
            std::minmax_element(corners.begin(), corners.end(),
                                [](const auto& a, const auto& b) { return a[1] < b[1]; });
        // Each end is rounded to 0.1 px.
        EXPECT_NEAR((*left)[0] + (*right)[0], 640, 0.11);
        EXPECT_NEAR((*top)[1] + (*bottom)[1], 418, 0.11);
        const double roomLeft =
            std::min(640 - 32 - ((*right)[0] - (*left)[0]), 418 - 32 - ((*bottom)[1] - (*top)[1]));
        EXPECT_NEAR(roomLeft, 0, 0.11);
    }
}

TEST(ErrorPicture, IsCompact) {
    SurfaceError surface =
        graph(78, [](Index i, Index j) { return 0.2 * std::sin(0.1 * i) * std::cos(0.1 * j); });
    for (std::size_t i = 0; i < surface.errors.size(); ++i)
        surface.errors[i] = 1e-17 * double(i % 13);
    ASSERT_THAT(surface.faces, SizeIs(6084));
    const std::string picture = compare::errorPicture(surface);
    EXPECT_LT(picture.size(), 70u * 6084);
    EXPECT_EQ(picture, compare::errorPicture(surface));
}

TEST(ErrorPicture, PutsARingRoundTheLargestError) {
    SurfaceError surface = squares({0, 1});
    EXPECT_EQ(Picture(surface).rings(), 0u);
    surface.errors[6] = 2e-16;
    EXPECT_EQ(compare::largestErrorVertex(surface), 6);
    const Picture picture(surface);
    EXPECT_EQ(picture.rings(), 2u);  // A dark one on a light one.
    // Vertex 6 is corner 2 of the upper square, which is drawn second.
    const auto corner = picture.corners().at(6);
    const auto circle = picture.svg.child("circle");
    EXPECT_NEAR(circle.attribute("cx").as_double(), corner[0], 0.01);
    EXPECT_NEAR(circle.attribute("cy").as_double(), corner[1], 0.01);
}

/// Under a square of side 1 at height 1, the point (0.5, 0.5, 0.9) is hidden; the point above the
/// square is not.
TEST(ErrorPicture, BreaksTheRingOfAHiddenVertex) {
    for (const bool isHidden : {true, false}) {
        const double height = isHidden ? 0.9 : 1.1;
        SurfaceError surface = squares({0, 1, height});
        for (std::size_t i = 8; i < 12; ++i) {
            surface.positions[i][0] = 0.5 + 0.01 * surface.positions[i][0];
            surface.positions[i][1] = 0.5 + 0.01 * surface.positions[i][1];
        }
        surface.errors[8] = 1e-16;
        EXPECT_EQ(!Picture(surface).svg.child("circle").attribute("stroke-dasharray").empty(),
                  isHidden);
    }
}

TEST(ErrorPicture, PutsNoRingRoundAVertexOfNoFace) {
    SurfaceError surface = squares({0});
    surface.positions.push_back({100, 100, 100});
    surface.errors.push_back(1e-9);
    EXPECT_EQ(Picture(surface).rings(), 0u);
}

TEST(LargestErrorVertex, IsTheFirstOfEqualsAndNoneOfZeros) {
    SurfaceError surface = squares({0});
    EXPECT_EQ(compare::largestErrorVertex(surface), std::nullopt);
    EXPECT_EQ(compare::largestErrorVertex({}), std::nullopt);
    surface.errors = {0, 1e-16, 1e-17, 1e-16};
    EXPECT_EQ(compare::largestErrorVertex(surface), 1);
    surface.errors = {0, 1e-16, kNan, 1};
    EXPECT_EQ(compare::largestErrorVertex(surface), 2);
}

TEST(ErrorPicture, WithoutFacesIsALineOfText) {
    EXPECT_THAT(Picture({}).words(), HasSubstr("no faces"));
    SurfaceError point = squares({0});
    for (Point3& p : point.positions) p = {1, 2, 3};
    EXPECT_THAT(Picture(point).words(), HasSubstr("all positions are the same"));
    SurfaceError lost = squares({0});
    lost.positions[2][1] = kNan;
    EXPECT_THAT(Picture(lost).words(), HasSubstr("not finite"));
}

TEST(ErrorPicture, ReportsValuesThatAreNotFinite) {
    SurfaceError surface = squares({0, 1});
    surface.positions[1][0] = kInfinity;
    surface.errors[6] = kNan;
    const Picture picture(surface);
    EXPECT_THAT(picture.words(), HasSubstr("1 face is not drawn"));
    EXPECT_THAT(picture.words(), HasSubstr("1 error is not finite"));
    const ErrorScale scale(compare::Bounds{}.position);
    ASSERT_THAT(picture.colours(), SizeIs(1));
    EXPECT_TRUE(isShadeOf(picture.colours()[0], scale.colour(1)));
    EXPECT_THAT(compare::errorPicture(surface), testing::Not(HasSubstr("\"nan")));
    // The lines of text have their own room: 18 px each.
    for (const auto& corner : picture.corners()) EXPECT_GE(corner[1], 2 * 18);
}

/// The largest double is 1.8e308: the difference of two corners would overflow.
TEST(ErrorPicture, DrawsShapesOfAnySize) {
    const SurfaceError surface = graph(2, [](Index i, Index j) { return i == j ? 1.0 : -1.0; });
    const auto corners = Picture(surface).corners();
    for (const double scale : {1e-300, 1e300}) {
        SurfaceError scaled = surface;
        for (Point3& p : scaled.positions)
            for (double& x : p) x *= scale;
        EXPECT_EQ(Picture(scaled).corners(), corners) << scale;
    }
    SurfaceError largest = surface;
    for (Point3& p : largest.positions)
        for (double& x : p) x *= std::numeric_limits<double>::max();
    EXPECT_EQ(Picture(largest).corners(), corners);
}

TEST(ErrorPicture, DrawsALine) {
    SurfaceError line = squares({0});
    for (Point3& p : line.positions) p[1] = p[2] = 0;
    EXPECT_THAT(Picture(line).corners(), SizeIs(4));
}

TEST(ErrorPicture, RefusesInvalidSurfaces) {
    const auto refusal = [](const SurfaceError& surface) {
        return messageOf([&] { compare::errorPicture(surface); });
    };
    SurfaceError surface = squares({0});
    surface.errors.pop_back();
    EXPECT_EQ(refusal(surface), "picture: 3 errors for 4 positions");
    surface = squares({0, 1});
    surface.faces[1][2] = 8;
    EXPECT_EQ(refusal(surface), "picture: face 1 names position 8 of 8");
    surface.faces[1][2] = -1;
    EXPECT_EQ(refusal(surface), "picture: face 1 names position -1 of 8");
}

}  // namespace
}  // namespace espalier::test

// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/topology_error.h>
#include <espalier/shapes/extrude.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/solids.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "lattice_checks.h"

namespace espalier::shapes {
namespace {

using namespace espalier::test;

/// The default options with one field set.
template <class Options, class Member, class Value>
Options with(Member Options::*field, Value value) {
    Options options;
    options.*field = value;
    return options;
}

struct Case {
    std::function<void()> call;
    std::string message;
};

TEST(Parameters, areRefusedByNameValueAndRange) {
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const std::string positive = "; allowed: finite numbers above 0";
    const Case cases[] = {
        {[] {
             box({{1, 0, 1}});
         },
         "box: cells[1] is 0; allowed: 1 or more"},
        {[] {
             box({{1, 1, 1}, {0, 0, 0}, {1, 1, 0}});
         },
         "box: max[2] is 0; allowed: numbers above min[2], which is 0"},
        {[] {
             box({{1, 1, 1}, {0, 0, 0}, {kInfinity, 1, 1}});
         },
         "box: max[0] is inf; allowed: finite numbers"},
        {[] { cylinder(with(&CylinderOptions::sectors, 2)); },
         "cylinder: sectors is 2; allowed: 3 or more"},
        {[] { cylinder(with(&CylinderOptions::pattern, DiskPattern{0})); },
         "cylinder: rings is 0; allowed: 1 or more"},
        {[] { cylinder(with(&CylinderOptions::layers, -1)); },
         "cylinder: layers is -1; allowed: 1 or more"},
        {[] { cylinder(with(&CylinderOptions::radius, kNan)); },
         "cylinder: radius is nan" + positive},
        {[] {
             cylinder(with(&CylinderOptions::to, Point3{0, 0, 0}));
         },
         "cylinder: to is (0, 0, 0); allowed: points other than `from`"},
        {[] { torus(with(&TorusOptions::segments, 2)); },
         "torus: segments is 2; allowed: 3 or more"},
        {[] { torus(with(&TorusOptions::gridCells, 0)); },
         "torus: gridCells is 0; allowed: 1 or more"},
        {[] { torus(with(&TorusOptions::sides, 0)); }, "torus: sides is 0; allowed: 3 or more"},
        {[] { torus(with(&TorusOptions::minorRadius, 1.0)); },
         "torus: minorRadius is 1; allowed: numbers below majorRadius, which is 1"},
        {[] { torus(with(&TorusOptions::majorRadius, -2.5)); },
         "torus: majorRadius is -2.5" + positive},
        {[] { star(with(&StarOptions::points, 1)); }, "star: points is 1; allowed: 2 or more"},
        {[] { star(with(&StarOptions::innerRadius, 0.0)); }, "star: innerRadius is 0" + positive},
        {[] { star(with(&StarOptions::height, kInfinity)); }, "star: height is inf" + positive},
        {[] { barbell(with(&BarbellOptions::endSegments, 2)); },
         "barbell: endSegments is 2; allowed: 3 or more"},
        {[] { barbell(with(&BarbellOptions::barSegments, 0)); },
         "barbell: barSegments is 0; allowed: 1 or more"},
        {[] { barbell(with(&BarbellOptions::barAcross, 0)); },
         "barbell: barAcross is 0; allowed: 1 or more"},
        {[] { barbell(with(&BarbellOptions::barLength, 0.0)); },
         "barbell: barLength is 0" + positive},
        {[] { barbell(with(&BarbellOptions::roundness, 1.5)); },
         "barbell: roundness is 1.5; allowed: numbers from 0 to 1"},
        {[] { arm(with(&ArmOptions::segments, 0)); }, "arm: segments is 0; allowed: 1 or more"},
        {[] { arm(with(&ArmOptions::sides, 2)); }, "arm: sides is 2; allowed: 3 or more"},
        {[] {
             arm(with(&ArmOptions::joints,
                      std::vector<ArmJoint>{{{0, 0, 0}, 1, 0}, {{1, 0, 0}, 0, 0}}));
         },
         "arm: joints[1].radius is 0" + positive},
        {[] { icosahedron({-1}); }, "icosahedron: radius is -1" + positive},
        {[] { prism({2}); }, "prism: sides is 2; allowed: 3 or more"},
        {[] {
             bipyramid({3, 1, 0});
         },
         "bipyramid: height is 0" + positive},
        {[] {
             extrude(gridMesh(), {{0, 0, 1}, 0});
         },
         "extrude: layers is 0; allowed: 1 or more"},
        {[] {
             extrude(gridMesh(), {{0, 0, 0}, 1});
         },
         "extrude: direction is (0, 0, 0); allowed: non-zero vectors"},
        {[] {
             gridMesh({{1, -3}});
         },
         "grid: cells[1] is -3; allowed: 1 or more"},
        {[] {
             diskMesh(regularPolygon(4, 1), {0, 0, 0}, {0});
         },
         "disk: rings is 0; allowed: 1 or more"},
    };
    for (const Case& each : cases) EXPECT_EQ(errorOf(each.call), each.message);
}

TEST(Parameters, areRefusedWhereThereWouldBeTooManyEntities) {
    // Each asks for more than an Index counts, the last two by more than 64 bits count. None may
    // take memory for it first.
    constexpr int kMany = std::numeric_limits<int>::max();
    const std::function<void()> calls[] = {
        [] {
            box({{2000, 2000, 2000}});
        },
        [] {
            cylinder({kMany, {1}, 1});
        },
        [] {
            torus({1000, TorusSection::Grid, 10'000});
        },
        [] {
            star({1000, {1000}, 1000});
        },
        [] {
            extrude(gridMesh(), {{0, 0, 1}, kMany});
        },
        [] { arm(with(&ArmOptions::segments, kMany)); },
        [] { bipyramid({kMany}); },
        [] {
            gridMesh({{kMany, kMany}});
        },
        [] {
            cylinder({kMany, {kMany}, kMany});
        },
    };
    for (const auto& call : calls) EXPECT_EQ(causeOf(call), far::TopologyCause::TooManyEntities);
    EXPECT_EQ(errorOf([] {
                  box({{2000, 2000, 2000}});
              }),
              "box: would take 2000 x 2000 x 2000 x 24 entries; the most is 2147483647");
}

}  // namespace
}  // namespace espalier::shapes

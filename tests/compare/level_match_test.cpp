// SPDX-License-Identifier: Apache-2.0
#include "compare/level_match.h"
#include "compare/open_subdiv_refiner.h"

#include "compare/shapes.h"
#include "support/test.h"

namespace espalier::compare {
namespace {

/// A shape and its match with OpenSubdiv on levels 0 and 1.
struct MatchedShape {
    TopologyRefiner refiner;
    OpenSubdivRefiner openSubdiv;
    std::vector<LevelMatch> matches;

    explicit MatchedShape(const Lattice& shape)
        : refiner(refined(shape, 1)),
          openSubdiv(makeOpenSubdivRefiner(refiner, surfaceOf(shape.complex))) {
        matches.push_back(
            matchBase(shape.complex, surfaceOf(shape.complex), openSubdiv.refiner->GetLevel(0)));
        matches.push_back(matchChildren(shape.complex, matches[0], refiner.refinement(1),
                                        openSubdiv.refiner->GetLevel(0)));
    }

    std::string difference(int level) const {
        const auto openSubdivLevel = openSubdiv.refiner->GetLevel(level);
        const LevelMatch& match = matches[level];
        return describeDifference(refiner, level,
                                  comparedRegion(refiner, level, match, openSubdivLevel), match,
                                  openSubdivLevel);
    }
};

TEST(LevelMatch, EverythingOnASurfaceHasOneMatch) {
    for (const auto& [name, lattice] : zoo()) {
        const MatchedShape matched(lattice);
        EXPECT_EQ(matched.difference(0), "") << name;
        EXPECT_EQ(matched.difference(1), "") << name;
        const auto openSubdiv = matched.openSubdiv.refiner->GetLevel(1);
        const Surface surface = surfaceOf(matched.refiner.level(1).complex);
        EXPECT_EQ(countOpenSubdiv(Boundary::Sharp, openSubdiv),
                  (std::array{Index(surface.vertices.size()), Index(surface.edges.size()),
                              Index(surface.faces.size())}))
            << name;
    }
}

TEST(LevelMatch, DifferencesAreNamed) {
    const Lattice box = shapes::box({.cells = {2, 1, 1}});
    const auto planted = [&](auto plant) {
        MatchedShape matched(box);
        plant(matched.matches[1]);
        return matched.difference(1);
    };
    EXPECT_THAT(planted([](LevelMatch& m) { std::swap(m.numbers[0][0], m.numbers[0][1]); }),
                HasSubstr("has other vertices than in OpenSubdiv"));
    EXPECT_THAT(planted([](LevelMatch& m) { m.numbers[0][1] = m.numbers[0][0]; }),
                HasSubstr("vertex 1 has the same match"));
    EXPECT_THAT(planted([](LevelMatch& m) { m.numbers[0][2].reset(); }),
                HasSubstr("vertex 2 has no match"));
    EXPECT_THAT(
        planted([](LevelMatch& m) {
            // Exchange the first two faces on the surface.
            auto& faces = m.numbers[2];
            const auto first = std::find_if(faces.begin(), faces.end(), [](auto f) { return !!f; });
            std::swap(*first, *std::find_if(first + 1, faces.end(), [](auto f) { return !!f; }));
        }),
        HasSubstr("has other vertices than in OpenSubdiv"));
}

// Marks that OpenSubdiv did not get are reported as differences of features.
TEST(LevelMatch, FeaturesAreCompared) {
    Lattice mesh = cubeSurface();
    const MatchedShape plain(mesh);
    const auto ends = mesh.complex.relation(1, 0)[0];
    mesh.marks.edges = {{{ends[0], ends[1]}, 2.5}};
    const auto against = [&](const Lattice& marked) {
        MatchedShape matched(marked);
        matched.openSubdiv = makeOpenSubdivRefiner(plain.refiner, surfaceOf(mesh.complex));
        return matched.difference(1);
    };
    EXPECT_THAT(against(mesh), HasSubstr("sharpness 1.5"));
    mesh.marks = {.vertices = {{3, 1.5}}};
    EXPECT_THAT(against(mesh), HasSubstr("sharpness 0.5"));
    mesh.marks = {.holes = {2}};
    EXPECT_THAT(against(mesh), HasSubstr("is a hole; in OpenSubdiv it is not"));

    // The same without boundary control.
    Lattice open{gridMesh(5, 5), {}, {}, {}};
    open.tags.boundary = Boundary::Open;
    const MatchedShape solid(open);
    open.marks.holes = {12};
    MatchedShape pierced(open);
    EXPECT_EQ(pierced.difference(1), "");
    pierced.openSubdiv = makeOpenSubdivRefiner(solid.refiner, surfaceOf(open.complex));
    EXPECT_THAT(pierced.difference(1), HasSubstr("is a hole; in OpenSubdiv it is not"));
}

}  // namespace
}  // namespace espalier::compare

// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/complex_builder.h>

#include "far/surface_fans.h"
#include "support/complexes.h"
#include "support/test.h"

namespace espalier::far {
namespace {

using EdgeKind = SurfaceFans::EdgeKind;
using VertexKind = SurfaceFans::VertexKind;

/// A mesh, with all its faces as the surface.
struct Mesh {
    CellComplex complex;
    SurfaceFans fans;

    Mesh(Index vertexCount, const Loops& loops)
        : complex(buildMesh(vertexCount, loops)),
          fans(complex, std::vector<std::uint8_t>(loops.size(), 1)) {}

    EdgeKind edge(Index a, Index b) const {
        for (Index e = 0; e < complex.count(1); ++e) {
            const auto ends = complex.relation(1, 0)[e];
            if (std::minmax(ends[0], ends[1]) == std::minmax(a, b)) return fans.edge(e);
        }
        throw std::logic_error("no such edge");
    }
};

TEST(SurfaceFans, EdgesByTheirFaces) {
    const Mesh plane(6, {{0, 1, 4, 3}, {1, 2, 5, 4}});
    EXPECT_EQ(plane.edge(1, 4), EdgeKind::Manifold);
    EXPECT_EQ(plane.edge(0, 1), EdgeKind::Boundary);
    EXPECT_EQ(plane.fans.vertex(1), VertexKind::Fan);
    EXPECT_EQ(plane.fans.vertex(0), VertexKind::Fan);
    // The second face is wound in the opposite direction.
    EXPECT_EQ(Mesh(6, {{0, 1, 4, 3}, {4, 5, 2, 1}}).edge(1, 4), EdgeKind::NonManifold);
    // A third face.
    EXPECT_EQ(Mesh(7, {{0, 1, 4, 3}, {1, 2, 5, 4}, {1, 6, 4}}).edge(1, 4), EdgeKind::NonManifold);
}

TEST(SurfaceFans, VerticesByTheirFans) {
    // Two faces that share a vertex only.
    EXPECT_EQ(Mesh(5, {{0, 1, 2}, {0, 3, 4}}).fans.vertex(0), VertexKind::NonManifold);
    // A closed fan.
    EXPECT_EQ(Mesh(4, {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}}).fans.vertex(0), VertexKind::Fan);
    EXPECT_EQ(Mesh(2, {{0, 1, 0}}).fans.vertex(1), VertexKind::NonManifold);
    EXPECT_EQ(Mesh(4, {{0, 1, 2}}).fans.vertex(3), VertexKind::None);
}

/// Builds half-planes of two triangles each around the edges 1-0 and 0-2, through vertices 3, 4, 5
/// and so on. Each half-plane runs from 1 to 2 through a vertex of its own.
Loops halfPlanes(Index count) {
    Loops loops;
    for (Index i = 0; i < count; ++i) {
        loops.push_back({0, 1, 3 + i});
        loops.push_back({0, 3 + i, 2});
    }
    return loops;
}

// OpenSubdiv's non-manifold crease, as of release 3.6.1.
TEST(SurfaceFans, ThreeFansBetweenTheSameTwoEdgesAreACrease) {
    for (const Index count : {3, 4, 7})
        EXPECT_EQ(Mesh(3 + count, halfPlanes(count)).fans.vertex(0), VertexKind::Crease) << count;
    // Two fans that do not match: their edges are non-manifold by winding.
    EXPECT_EQ(Mesh(5, halfPlanes(2)).fans.vertex(0), VertexKind::NonManifold);
    // A cone that touches the crease.
    Loops touched = halfPlanes(3);
    for (const auto& loop : Loops{{0, 6, 7}, {0, 7, 8}, {0, 8, 6}}) touched.push_back(loop);
    EXPECT_EQ(Mesh(9, touched).fans.vertex(0), VertexKind::NonManifold);
    // A fourth fan that ends at the first edge and at a boundary.
    Loops fin = halfPlanes(3);
    fin.push_back({0, 1, 6});
    EXPECT_EQ(Mesh(7, fin).fans.vertex(0), VertexKind::NonManifold);
    // A fan from the first edge back to itself: one edge has three faces more than the other.
    Loops folded = halfPlanes(3);
    folded.push_back({0, 1, 6});
    folded.push_back({0, 6, 7});
    folded.push_back({0, 7, 1});
    EXPECT_EQ(Mesh(8, folded).fans.vertex(0), VertexKind::NonManifold);
}

// A face passes a vertex twice: each step is a separate edge, and non-manifold.
TEST(SurfaceFans, DegenerateFaces) {
    const Mesh pinched(5, {{0, 1, 2, 2}, {1, 0, 3, 4}});
    EXPECT_EQ(pinched.complex.count(1), 7);
    EXPECT_EQ(pinched.edge(2, 2), EdgeKind::NonManifold);
    EXPECT_EQ(pinched.edge(0, 1), EdgeKind::Manifold);
    EXPECT_EQ(pinched.fans.vertex(2), VertexKind::NonManifold);
    EXPECT_EQ(pinched.fans.vertex(0), VertexKind::Fan);

    const Mesh folded(5, {{0, 1, 0, 2}, {1, 0, 3, 4}});
    EXPECT_EQ(folded.complex.count(1), 7);
    EXPECT_EQ(folded.edge(0, 1), EdgeKind::NonManifold);
    EXPECT_EQ(folded.edge(0, 2), EdgeKind::NonManifold);

    EXPECT_EQ(Mesh(1, {{0, 0, 0, 0}}).complex.count(1), 4) << "four edges from a vertex to itself";
}

}  // namespace
}  // namespace espalier::far

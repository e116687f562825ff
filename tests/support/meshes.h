// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/shapes/inventory.h>
#include <espalier/shapes/solids.h>

#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "support/mesh_shapes.h"
#include "support/random_marks.h"
#include "support/zoo.h"

// Meshes with every feature that OpenSubdiv's meshes can have. addRandomSharpness() explains why
// some sharpness values are multiples of 1/4.
namespace espalier::test {

inline Lattice with(Lattice mesh, far::Marks marks, RefinementTags tags = {}) {
    mesh.marks = std::move(marks);
    mesh.tags = tags;
    return mesh;
}

/// Returns marks on the edges of a path, with these sharpness values in order.
inline std::vector<far::Marks::Edge> crease(const std::vector<Index>& path,
                                            const std::vector<double>& sharpness) {
    std::vector<far::Marks::Edge> marks;
    for (std::size_t i = 0; i + 1 < path.size(); ++i)
        marks.push_back({{path[i], path[i + 1]}, sharpness[i % sharpness.size()]});
    return marks;
}

/// Joins several creases to one list.
inline std::vector<far::Marks::Edge> creases(
    const std::vector<std::vector<far::Marks::Edge>>& parts) {
    std::vector<far::Marks::Edge> all;
    for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

class MeshZoo {
public:
    void add(const std::string& name, Lattice mesh) { all_.push_back({name, std::move(mesh)}); }

    /// Adds the mesh with both methods of creasing.
    void addCreased(const std::string& name, Lattice mesh) {
        mesh.tags.creasing = far::Creasing::Uniform;
        add(name + ", uniform", mesh);
        mesh.tags.creasing = far::Creasing::Chaikin;
        add(name + ", Chaikin", std::move(mesh));
    }

    std::vector<NamedLattice> take() { return std::move(all_); }

private:
    std::vector<NamedLattice> all_;
};

inline void addClosedMeshes(MeshZoo& zoo) {
    zoo.add("cube", cubeSurface());
    zoo.add("box", surfaceOf(shapes::box({.cells = {3, 2, 1}})));
    zoo.add("torus", surfaceOf(shapes::torus()));
    zoo.add("tetrahedron", surfaceOf(shapes::tetrahedron()));
    zoo.add("octahedron", surfaceOf(shapes::octahedron()));
    zoo.add("dodecahedron", surfaceOf(shapes::dodecahedron()));
    for (int sides = 3; sides <= 9; ++sides) {
        const std::string name = " of " + std::to_string(sides) + " sides";
        zoo.add("prism" + name, surfaceOf(shapes::prism({.sides = sides})));
        zoo.add("pyramid" + name, surfaceOf(shapes::pyramid({.sides = sides})));
    }
    zoo.add("mixed cells", surfaceOf(mixedLattice()));
    zoo.add("polygons of 3 to 9 sides", polygonDisk({3, 4, 5, 6, 7, 8, 9}, {8, 5, 7, 3, 9, 4, 6}));
    zoo.add("cube with a hole",
            with(cubeSurface(), {.edges = crease({4, 5, 6, 7, 4}, {10, 1.5}), .holes = {1}}));
    zoo.add("two pieces", together(cubeSurface(), patch(3), 2));
    // Vertices of valence 2 inside the surface.
    for (Index sides : {3, 4, 5})
        zoo.add("back to back, " + std::to_string(sides) + " sides", lens(sides));
    zoo.add("lens", polygonDisk({5, 4, 5}, {4, 6, 4}));
    zoo.addCreased("creased lens", with(lens(5), {.edges = crease({0, 1, 2, 3}, {2.5, 0.75, 10}),
                                                  .vertices = {{1, 1.25}}}));
    zoo.add("left-handed cube", turned(cubeSurface(), [](Index) { return true; }));
    zoo.addCreased("left-handed patch",
                   with(turned(patch(4), [](Index) { return true; }),
                        {.edges = crease({5, 6, 7, 12, 17}, {1.7, 10, 0.4}), .holes = {3}}));
}

inline std::vector<std::pair<std::string, far::Boundary>> boundaryModes() {
    return {{"edge and corner: ", far::Boundary::Sharp},
            {"edge only: ", far::Boundary::EdgeOnly},
            {"none: ", far::Boundary::Open}};
}

inline void addOpenMeshes(MeshZoo& zoo) {
    using far::Boundary;
    const auto none = [](Index, Index) { return false; };
    const auto all = [](Index, Index) { return true; };
    const auto some = [](Index i, Index j) { return (i + 2 * j) % 3 == 0; };
    for (const auto& [mode, boundary] : boundaryModes()) {
        const RefinementTags tags = {.boundary = boundary};
        zoo.add(mode + "patch", with(patch(6, none), {}, tags));
        zoo.add(mode + "octagon", with(octagonPatch(), {}, tags));
        zoo.add(mode + "triangles", with(patch(6, all), {}, tags));
        zoo.add(mode + "triangles and quads", with(patch(6, some), {}, tags));
        // Creases away from the boundary, which cross in (3, 3).
        zoo.addCreased(mode + "creases inside",
                       with(patch(6),
                            {.edges = creases({crease({15, 16, 17, 24, 25}, {10, 10, 10, 0.75}),
                                               crease({22, 23, 24, 31, 38}, {4.7, 2.5, 1.0, 9.9}),
                                               crease({8, 9, 16}, {2.5, 0.1})}),
                             .vertices = {{12, 1.4}, {26, 10}}},
                            tags));
        zoo.addCreased(mode + "closed crease",
                       with(patch(6),
                            {.edges = crease({16, 17, 18, 25, 32, 31, 30, 23, 16},
                                             {0.1, 0.7, 1.0, 2.5, 10, 4.7, 9.9, 2.5})},
                            tags));
        // Holes in a corner, two at the boundary, two inside along a crease.
        zoo.add(mode + "holes", with(patch(6),
                                     {.edges = crease({14, 15, 16, 17, 18}, {10, 10, 1.5, 2.5}),
                                      .holes = {0, 9, 14, 23, 33}},
                                     tags));
        zoo.add(
            mode + "octagon as a hole",
            with(octagonPatch(), {.edges = crease({16, 17, 18}, {2.5, 10}), .holes = {32}}, tags));
        if (boundary == Boundary::Open) continue;
        zoo.add(mode + "triangle", with(fans({{1, 2}}), {}, tags));
        zoo.add(mode + "quad", with(patch(1), {}, tags));
        zoo.add(mode + "polygons", with(polygonDisk({3, 4, 5, 6, 7, 8, 9}), {}, tags));
        // Creases that end at the boundary, and creases along it, where marks change nothing.
        zoo.addCreased(
            mode + "creases to the boundary",
            with(patch(6),
                 {.edges =
                      creases({crease({21, 22, 23, 24, 25, 26, 27}, {0.1, 0.7, 1.0, 2.5, 4.7, 9.9}),
                               crease({3, 10, 17}, {10}), crease({45, 38, 31}, {1.3}),
                               crease({0, 1, 2}, {0.5, 3})}),
                  .vertices = {{5, 1.3}, {14, 10}, {34, 0.6}}},
                 tags));
    }
    // Without boundary interpolation, a boundary that is marked sharp stays.
    std::vector<Index> side = {0, 1, 2, 3, 4, 5, 6};
    zoo.add("none: a sharp side",
            with(patch(6), {.edges = crease(side, {10})}, {.boundary = Boundary::Open}));
    zoo.addCreased("none: a sharp side and creases",
                   with(patch(6),
                        {.edges = creases({crease(side, {10}), crease({3, 10, 17}, {2.5, 0.7}),
                                           crease({1, 8, 15}, {10})}),
                         .vertices = {{5, 1.3}}},
                        {.boundary = Boundary::Open}));
    // In mode edge-only, only marked vertices are corners.
    zoo.add("edge only: corners", with(patch(3), {.vertices = {{0, 10}, {3, 0.7}, {12, 2.5}}},
                                       {.boundary = Boundary::EdgeOnly}));
    zoo.add(
        "edge only: triangle with corners",
        with(fans({{1, 2}}), {.vertices = {{0, 10}, {1, 1.0}}}, {.boundary = Boundary::EdgeOnly}));
}

inline void addCreasedMeshes(MeshZoo& zoo) {
    for (const double sharpness : {0.1, 0.7, 1.0, 2.5, 4.7, 9.9, 10.0}) {
        const std::string text = std::to_string(sharpness).substr(0, 4);
        zoo.addCreased("cube with a crease of " + text,
                       with(cubeSurface(), {.edges = crease({4, 5, 6, 7, 4}, {sharpness})}));
    }
    zoo.add(
        "cube with sharp vertices",
        with(cubeSurface(),
             {.vertices = {{0, 0.1}, {1, 0.7}, {2, 1.0}, {3, 2.5}, {4, 4.7}, {5, 9.9}, {6, 10}}}));
    const Lattice torus = surfaceOf(shapes::torus({.segments = 8}));
    zoo.addCreased("crease of many sharpnesses",
                   with(torus, {.edges = crease({0, 4, 8, 12, 16, 20, 24, 28, 0},
                                                {0.1, 0.7, 1.0, 2.5, 4.7, 9.9, 10, 0.3})}));
    // The crease (1, 1) to (3, 1) is infinite, (3, 3) to (4, 3) and (1, 5) to (3, 5) are
    // semi-sharp.
    zoo.addCreased(
        "darts",
        with(patch(6), {.edges = creases({crease({8, 9, 10}, {10}), crease({24, 25}, {0.7}),
                                          crease({36, 37, 38}, {2.5, 4.7})})}));
    // Corners become creases, and creases darts, at different levels.
    zoo.addCreased(
        "cube of creases",
        with(cubeSurface(), {.edges = creases({crease({0, 1, 2, 3, 0}, {0.25, 1.5, 2.75, 1.0}),
                                               crease({4, 5, 6, 7, 4}, {0.5, 2.0, 1.25, 0.75}),
                                               crease({0, 4}, {3.0}), crease({1, 5}, {2.5}),
                                               crease({2, 6}, {1.75}), crease({3, 7}, {2.25})})}));
    // The creases at (1, 1): two infinite and one that fades; at (4, 1): two that outlast the
    // third; at (1, 4): four of equal sharpness; at (4, 4): one infinite and two that fade.
    zoo.addCreased(
        "junctions",
        with(patch(6),
             {.edges = creases({crease({7, 8, 9}, {10}), crease({8, 15}, {0.7}),
                                crease({10, 11, 12}, {3.25, 2.5}), crease({11, 18}, {1}),
                                crease({28, 29, 30}, {1.5}), crease({22, 29, 36}, {1.5}),
                                crease({31, 32}, {10}), crease({25, 32, 39}, {0.3, 2.6})})}));
    zoo.add("four unlike creases, uniform",
            with(patch(4),
                 {.edges = creases(
                      {crease({11, 12, 13}, {0.5, 1.25}), crease({7, 12, 17}, {2.0, 3.75})})},
                 {.creasing = far::Creasing::Uniform}));
    zoo.addCreased(
        "five creases",
        with(surfaceOf(shapes::bipyramid({.sides = 5})),
             {.edges = creases({crease({0, 6, 1}, {0.25, 1.5}), crease({2, 6, 3}, {2.75, 1.0}),
                                crease({6, 4}, {2.0})})}));
    // Sharp vertices on creases stay sharp for more levels than the crease, for fewer, and for as
    // many.
    zoo.addCreased(
        "sharp vertices on creases",
        with(patch(6),
             {.edges = creases({crease({7, 8, 9, 10, 11, 12, 13}, {10}),
                                crease({22, 23, 24, 25, 26}, {4.7}),
                                crease({36, 37, 38, 39, 40}, {0.7})}),
              .vertices = {{9, 2.5}, {11, 0.7}, {23, 2.5}, {25, 9.9}, {37, 2.5}, {38, 0.7}}}));
    // The vertex changes from corner to crease, and later from crease to smooth or to dart.
    zoo.addCreased(
        "sharp vertices in junctions",
        with(patch(6),
             {.edges = creases({crease({23, 24, 25}, {2.5, 1.5}), crease({17, 24}, {0.75}),
                                crease({8, 9, 10}, {1.75}), crease({37, 38}, {1.75})}),
              .vertices = {{24, 3.5}, {9, 0.25}, {38, 0.25}}}));
}

inline void addSmoothTriangles(MeshZoo& zoo) {
    const RefinementTags smooth = {.triangles = far::TriangleSubdivision::Smooth};
    const auto all = [](Index, Index) { return true; };
    const auto some = [](Index i, Index j) { return (i + 2 * j) % 3 == 0; };
    zoo.add("smooth: tetrahedron", with(surfaceOf(shapes::tetrahedron()), {}, smooth));
    zoo.add("smooth: icosahedron", with(surfaceOf(shapes::icosahedron()), {}, smooth));
    zoo.add("smooth: pyramid", with(surfaceOf(shapes::pyramid({.sides = 6})), {}, smooth));
    zoo.add("smooth: mixed cells", with(surfaceOf(mixedLattice()), {}, smooth));
    zoo.add("smooth: fan", with(fans({{1, 2, 3, 4, 5, 6}}), {}, smooth));
    zoo.add("smooth: closed fan", with(fans({{1, 2, 3, 4, 5, 1}}), {}, smooth));
    zoo.add("smooth: triangle", with(fans({{1, 2}}), {}, smooth));
    zoo.add("smooth: two triangles back to back", with(lens(3), {}, smooth));
    zoo.add("smooth: pole", with(pole(12, false), {}, smooth));
    zoo.add("smooth: cube", with(cubeSurface(), {}, smooth));
    for (const auto& [mode, boundary] : boundaryModes()) {
        RefinementTags tags = smooth;
        tags.boundary = boundary;
        zoo.add("smooth, " + mode + "patch", with(patch(6, all), {}, tags));
        zoo.add("smooth, " + mode + "triangles and quads",
                with(patch(6, some), {.holes = {8}}, tags));
    }
    // Creases that fade, between triangles, and between a triangle and a quadrilateral.
    zoo.addCreased("smooth: creases",
                   with(patch(6, some),
                        {.edges = creases({crease({8, 16, 17, 24, 25}, {0.7, 1.0, 2.5, 10}),
                                           crease({37, 38, 39}, {0.1, 0.4})}),
                         .vertices = {{32, 1.5}}},
                        smooth));
    zoo.addCreased("smooth: random creases", [&] {
        Lattice mesh = randomCreases(patch(5, all), 31, far::Creasing::Chaikin);
        mesh.tags.triangles = smooth.triangles;
        return mesh;
    }());
}

/// Prefix of the names of meshes with a vertex that is a corner in Espalier and in OpenSubdiv since
/// 3.6.1, and was a crease before: the vertex has two non-manifold edges, and its faces are not
/// only fans between these two edges.
inline constexpr std::string_view kCornerSince361 = "corner since 3.6.1: ";

inline void addNonManifoldMeshes(MeshZoo& zoo) {
    zoo.add("three fins", fins({3}));
    zoo.add("four fins", fins({4}));
    zoo.add("chain of three fins", fins({3, 3, 3}));
    zoo.add("chain of four fins", fins({4, 4, 4}));
    zoo.add("fins of different counts", fins({3, 4, 3, 5}));
    zoo.add("edge only: fins", with(fins({3, 3, 4}), {}, {.boundary = far::Boundary::EdgeOnly}));
    zoo.addCreased("creases to fins",
                   with(fins({3, 3, 3}),
                        {.edges = creases({crease({1, 5}, {1.5}), crease({2, 10, 11}, {2.5, 0.7}),
                                           crease({0, 1}, {0.5})}),
                         .vertices = {{1, 0.7}}}));
    Lattice walled = surfaceOf(shapes::box({.cells = {2, 1, 1}}));
    Loops loops = loopsOf(walled);
    loops.push_back({1, 4, 10, 7});
    walled = mesh(walled.positions, loops);
    zoo.add("box with a wall", walled);
    zoo.add("random creases on a box with a wall",
            randomCreases(walled, 7, far::Creasing::Uniform));
    // Fans between edges (0, 1) and (0, 2): with a crease across; with a fan at (0, 1) alone; with
    // a closed or an open fan that touches only vertex 0.
    const Loops three = {{1, 3, 2}, {1, 4, 5, 2}, {1, 6, 2}};
    zoo.add("fans", fans(three));
    zoo.addCreased("fans with a crease", with(fans(three), {.edges = crease({3, 0, 6}, {1.5, 0.75}),
                                                            .vertices = {{0, 0.25}}}));
    const auto fansWith = [&](const Loops& more) {
        Loops paths = three;
        paths.insert(paths.end(), more.begin(), more.end());
        return fans(paths);
    };
    const std::string corner(kCornerSince361);
    zoo.add(corner + "fans that return", fans({{1, 3, 4, 1}, {1, 5, 2}, {2, 6, 7, 2}}));
    zoo.add(corner + "fans and a closed fan", fansWith({{7, 8, 9, 7}}));
    zoo.add("fans and an open fan", fansWith({{7, 8, 9}}));
    zoo.add("fans and one that ends", fansWith({{1, 7}, {1, 8, 9}}));
    // Non-manifold vertices.
    zoo.add("bow tie", fans({{1, 2}, {3, 4}}));
    zoo.add("bow tie of fans", fans({{1, 2, 3}, {4, 5, 6, 7}}));
    zoo.add("edge only: bow tie",
            with(fans({{1, 2}, {3, 4, 5}}), {}, {.boundary = far::Boundary::EdgeOnly}));
    zoo.add("cones", fans({{1, 2, 3, 4, 1}, {5, 6, 7, 5}}));
    zoo.addCreased("cone and fan with creases",
                   with(fans({{1, 2, 3, 4, 1}, {5, 6, 7}}),
                        {.edges = crease({1, 0, 3}, {1.5, 0.75}), .vertices = {{0, 0.5}}}));
    const auto carved = [](auto isThere) { return surfaceOf(carvedGrid({2, 2, 2}, isThere)); };
    zoo.add("cubes that touch in an edge",
            carved([](Index i, Index j, Index k) { return i == j && k == 0; }));
    zoo.add("cubes that touch in a vertex",
            carved([](Index i, Index j, Index k) { return i == j && j == k; }));
    // Adjacent faces that run along their common edge in the same direction.
    zoo.add("two faces wound differently", turned(patch(3), [](Index face) { return face == 0; }));
    zoo.add("a face inside wound differently",
            turned(patch(5), [](Index face) { return face == 12; }));
    zoo.add("halves wound differently", turned(patch(4), [](Index face) { return face >= 8; }));
    zoo.add("a cube's face wound differently",
            turned(cubeSurface(), [](Index face) { return face == 1; }));
    zoo.add("Moebius strip", moebiusStrip(6, 1));
    zoo.add("wide Moebius strip", moebiusStrip(5, 3));
    zoo.addCreased("Moebius strip with a crease",
                   with(moebiusStrip(6, 2), {.edges = crease({4, 7, 10, 13}, {2.5, 0.7, 10})}));
}

/// Adds meshes with faces that repeat a vertex, and with vertices in no face.
inline void addDegenerateMeshes(MeshZoo& zoo) {
    const auto round = [](Index count) {
        std::vector<Point3> positions;
        for (Index i = 0; i < count; ++i)
            positions.push_back({std::cos(2.0 * i), std::sin(2.0 * i), 0.1 * i});
        return positions;
    };
    const RefinementTags edgeOnly{.boundary = far::Boundary::EdgeOnly};
    for (const RefinementTags& tags : {RefinementTags(), edgeOnly}) {
        const std::string mode = tags.boundary ? "edge only: " : "edge and corner: ";
        const auto add = [&](const std::string& name, Index count, const Loops& loops,
                             const far::Marks& marks = {}) {
            zoo.add(mode + name, with(mesh(round(count), loops), marks, tags));
        };
        add("a vertex twice in a row", 5, {{0, 1, 2, 2}, {1, 0, 3, 4}});
        add("a vertex twice", 5, {{1, 2, 0, 4, 3, 0}});
        add("there and back", 5, {{0, 1, 0, 2}, {1, 0, 3, 4}});
        add("one vertex only", 4, {{0, 0, 0, 0}, {1, 2, 3}});
        add("vertices in no face", 8, {{1, 2, 4, 3}, {2, 6, 7, 4}},
            {.vertices = {{0, 10}, {4, 1.5}, {5, 2.5}}});
    }
}

inline void addPoles(MeshZoo& zoo) {
    // Vertices of many edges, whose long sums show rounding errors.
    for (const Index few : {24, 40, 48, 56, 64})
        zoo.add("pole of " + std::to_string(few), pole(few, false));
    const Index sides = 360;
    zoo.add("pole of 360 over a polygon", pole(sides, true));
    zoo.add("two poles of 360", pole(sides, false));
    // One pole is on a crease, and the other is a corner at first.
    zoo.addCreased("poles of 360 with creases",
                   with(pole(sides, false),
                        {.edges = creases({crease({0, 360, 100}, {10}), crease({200, 360}, {0.7}),
                                           crease({0, 361, 90}, {1.5}), crease({180, 361}, {0.75}),
                                           crease({10, 11, 12, 13}, {2.5, 10, 0.1})})}));
}

inline void addRandomCreases(MeshZoo& zoo) {
    const std::vector<std::pair<std::string, Lattice>> meshes = {
        {"torus", surfaceOf(shapes::torus({.segments = 6}))},
        {"box", surfaceOf(shapes::box({.cells = {3, 2, 2}}))},
        {"icosahedron", surfaceOf(shapes::icosahedron())},
        {"patch", patch(5)},
        {"octagon", octagonPatch()},
        {"polygons", polygonDisk({3, 4, 5, 6, 7, 8, 9}, {8, 5, 7, 3, 9, 4, 6})},
        {"mixed cells", surfaceOf(mixedLattice())},
        {"three fins", fins({3, 3, 3})}};
    unsigned seed = 0;
    for (const auto& [name, mesh] : meshes)
        for (const auto& [method, creasing] : {std::pair("uniform", far::Creasing::Uniform),
                                               std::pair("Chaikin", far::Creasing::Chaikin)}) {
            for (int repeat = 1; repeat <= 2; ++repeat)
                zoo.add("random creases on " + name + ", " + method + " " + std::to_string(repeat),
                        randomCreases(mesh, ++seed, creasing));
        }
}

/// Returns meshes that together have every feature of surfaces. All names are different.
inline std::vector<NamedLattice> meshZoo() {
    MeshZoo zoo;
    addClosedMeshes(zoo);
    addOpenMeshes(zoo);
    addCreasedMeshes(zoo);
    addSmoothTriangles(zoo);
    addNonManifoldMeshes(zoo);
    addDegenerateMeshes(zoo);
    addPoles(zoo);
    addRandomCreases(zoo);
    return someOf(zoo.take());
}

}  // namespace espalier::test

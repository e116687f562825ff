// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>
#include <espalier/far/complex_builder.h>
#include <espalier/shapes/section.h>
#include <espalier/shapes/solids.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "cell_loops.h"
#include "checks.h"

namespace espalier::shapes {
namespace {

/// Returns a lattice of one cell.
Lattice singleCell(std::vector<Point3> positions, const std::vector<Loop>& loops) {
    far::ComplexBuilder builder(3, static_cast<Index>(positions.size()));
    builder.addCell(loops);
    return {builder.build(), std::move(positions), {}, {}};
}

/// Returns the face of a regular solid with this normal: the vertices that are farthest in this
/// direction, anticlockwise seen from outside.
Loop faceTowards(const Point3& normal, const std::vector<Point3>& vertices) {
    double farthest = 0;
    for (const Point3& vertex : vertices) farthest = std::max(farthest, dot(normal, vertex));
    Loop loop;
    // In a regular solid, vertices that are not on the face are nearer by at least a tenth.
    for (std::size_t v = 0; v < vertices.size(); ++v)
        if (dot(normal, vertices[v]) > 0.99 * farthest) loop.push_back(static_cast<Index>(v));
    const Point3 x = vertices[loop.front()];
    const Point3 y = cross(normalised(normal), x);
    const auto angle = [&](Index v) {
        const Point3 arm =
            difference(vertices[v], scaled(normal, dot(vertices[v], normal) / dot(normal, normal)));
        return std::atan2(dot(arm, y), dot(arm, x));
    };
    std::sort(loop.begin(), loop.end(), [&](Index a, Index b) { return angle(a) < angle(b); });
    return loop;
}

/// Makes a regular solid from its vertices and the normals of its faces. The normals are the
/// vertices of the dual solid.
Lattice regularSolid(const char* name, const RegularSolidOptions& options,
                     std::vector<Point3> vertices, const std::vector<Point3>& normals) {
    requirePositive(name, "radius", options.radius);
    std::vector<Loop> loops;
    for (const Point3& normal : normals) loops.push_back(faceTowards(normal, vertices));
    for (Point3& vertex : vertices) vertex = scaled(normalised(vertex), options.radius);
    return singleCell(std::move(vertices), loops);
}

std::vector<Point3> tetrahedronVertices(double sign) {
    return {{sign, sign, sign}, {sign, -sign, -sign}, {-sign, sign, -sign}, {-sign, -sign, sign}};
}

std::vector<Point3> octahedronVertices() {
    return {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}, {0, 0, 1}};
}

/// Returns the vertices of a cube in the order of VTK's hexahedron.
std::vector<Point3> cubeVertices() {
    return {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
            {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
}

/// Appends (0, ±a, ±b) and its cyclic permutations.
void appendRectangles(double a, double b, std::vector<Point3>& points) {
    for (const double sa : {-a, a})
        for (const double sb : {-b, b}) {
            points.push_back({0, sa, sb});
            points.push_back({sa, sb, 0});
            points.push_back({sb, 0, sa});
        }
}

std::vector<Point3> icosahedronVertices() {
    std::vector<Point3> points;
    appendRectangles(1, std::numbers::phi, points);
    return points;
}

std::vector<Point3> dodecahedronVertices() {
    std::vector<Point3> points = cubeVertices();
    appendRectangles(std::numbers::phi, 1 / std::numbers::phi, points);
    return points;
}

/// Returns the polygon of a solid at height z.
std::vector<Point3> polygonAt(double z, const PolygonalSolidOptions& options) {
    std::vector<Point3> points = regularPolygon(options.sides, options.radius);
    for (Point3& point : points) point[2] = z;
    return points;
}

void check(const char* name, const PolygonalSolidOptions& options) {
    requireAtLeast(name, "sides", options.sides, 3);
    requirePositive(name, "radius", options.radius);
    requirePositive(name, "height", options.height);
    requireCountable(name, {options.sides, 6});
}

Loop polygonSeenFromBelow(Index sides) {
    Loop loop;
    for (Index side = sides; side > 0; --side) loop.push_back(side % sides);
    return loop;
}

}  // namespace

Lattice tetrahedron(const RegularSolidOptions& options) {
    return regularSolid("tetrahedron", options, tetrahedronVertices(1), tetrahedronVertices(-1));
}

Lattice cube(const RegularSolidOptions& options) {
    return regularSolid("cube", options, cubeVertices(), octahedronVertices());
}

Lattice octahedron(const RegularSolidOptions& options) {
    return regularSolid("octahedron", options, octahedronVertices(), cubeVertices());
}

Lattice dodecahedron(const RegularSolidOptions& options) {
    return regularSolid("dodecahedron", options, dodecahedronVertices(), icosahedronVertices());
}

Lattice icosahedron(const RegularSolidOptions& options) {
    return regularSolid("icosahedron", options, icosahedronVertices(), dodecahedronVertices());
}

Lattice prism(const PolygonalSolidOptions& options) {
    check("prism", options);
    const Index n = options.sides;
    std::vector<Point3> positions = polygonAt(-options.height / 2, options);
    const std::vector<Point3> top = polygonAt(options.height / 2, options);
    positions.insert(positions.end(), top.begin(), top.end());
    std::vector<Loop> loops = {polygonSeenFromBelow(n), {}};
    for (Index s = 0; s < n; ++s) {
        const Index next = (s + 1) % n;
        loops[1].push_back(n + s);
        loops.push_back({s, next, n + next, n + s});
    }
    return singleCell(std::move(positions), loops);
}

Lattice pyramid(const PolygonalSolidOptions& options) {
    check("pyramid", options);
    const Index n = options.sides;
    std::vector<Point3> positions = polygonAt(-options.height / 2, options);
    positions.push_back({0, 0, options.height / 2});
    std::vector<Loop> loops = {polygonSeenFromBelow(n)};
    for (Index s = 0; s < n; ++s) loops.push_back({s, (s + 1) % n, n});
    return singleCell(std::move(positions), loops);
}

Lattice bipyramid(const PolygonalSolidOptions& options) {
    check("bipyramid", options);
    const Index n = options.sides;
    std::vector<Point3> positions = polygonAt(0, options);
    positions.push_back({0, 0, -options.height / 2});
    positions.push_back({0, 0, options.height / 2});
    std::vector<Loop> loops;
    for (Index s = 0; s < n; ++s) {
        loops.push_back({s, (s + 1) % n, n + 1});
        loops.push_back({(s + 1) % n, s, n});
    }
    return singleCell(std::move(positions), loops);
}

}  // namespace espalier::shapes

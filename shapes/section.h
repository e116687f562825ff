// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/base/word.h>
#include <espalier/shapes/lattice.h>

#include <array>
#include <span>
#include <vector>

/// \file
/// Flat meshes (lattices of dimension 2) in the plane z = 0, wound anticlockwise seen from +z: the
/// cross-sections that sweep() and extrude() make lattices of.
namespace espalier::shapes {

/// What is in the middle of a disk.
enum class Core {
    Wedges,  ///< a vertex, surrounded by triangles: wedges once swept
    Polygon  ///< one face with as many sides as the outline: a prism once swept
};
inline constexpr Word<Core> kCoreWords[] = {{"wedges", Core::Wedges}, {"polygon", Core::Polygon}};

/// How a disk is divided.
struct DiskPattern {
    /// Rings of faces, 1 or more. The core counts as the first one; the others are quadrilaterals.
    int rings = 1;
    Core core = Core::Wedges;
};

/// A disk with the given outline, divided by smaller copies of it about its centre.
///
/// With n vertices in the outline: the centre first, under Core::Wedges; then ring by ring
/// outwards, n vertices each, in the order of the outline, which is the last ring. Faces likewise:
/// the core, then ring by ring, face s beside vertices s and s + 1.
///
/// \param outline at least 3 vertices, anticlockwise, all of them visible from the centre
/// \throws Error naming a field out of range
ESPALIER_API Lattice diskMesh(std::span<const Point3> outline, const Point3& centre,
                              const DiskPattern& pattern = {});

/// The vertices of a regular polygon about the origin, anticlockwise from the +x axis.
/// \param sides 3 or more
/// \param radius of the circle through the vertices, above 0
ESPALIER_API std::vector<Point3> regularPolygon(int sides, double radius);

struct GridOptions {
    std::array<int, 2> cells = {1, 1};  ///< along x and y: 1 or more each
    std::array<double, 2> min = {0, 0};
    std::array<double, 2> max = {1, 1};  ///< above min in both
};

/// A rectangle divided into rectangles. Vertices and faces are in rows along x, from min y to max.
/// \throws Error naming a field out of range
ESPALIER_API Lattice gridMesh(const GridOptions& options = {});

}  // namespace espalier::shapes

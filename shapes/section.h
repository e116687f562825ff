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
/// Makes flat meshes (dimension 2) in the plane z = 0, wound anticlockwise seen from +z. They are
/// cross-sections for sweep() and extrude().
namespace espalier::shapes {

/// The faces in the middle of a disk.
enum class Core {
    Wedges,  ///< a vertex, surrounded by triangles: wedges once swept
    Polygon  ///< one face with as many sides as the outline: a prism once swept
};
inline constexpr Word<Core> kCoreWords[] = {{"wedges", Core::Wedges}, {"polygon", Core::Polygon}};

/// The division of a disk into faces.
struct DiskPattern {
    /// Rings of faces, 1 or more. The core counts as the first one; the others are quadrilaterals.
    int rings = 1;
    Core core = Core::Wedges;
};

/// Makes a disk with the given outline. Smaller copies of the outline about the centre divide it
/// into rings.
///
/// For an outline of n vertices, the vertices are: the centre (for Core::Wedges), then n vertices
/// per ring, ring by ring outwards. Each ring has the order of the outline; the last ring is the
/// outline itself. The faces are: the core, then ring by ring, face s between vertices s and s + 1.
///
/// \param outline at least 3 vertices, anticlockwise, each visible from the centre
/// \throws ArgumentError for a field out of range
ESPALIER_API Lattice diskMesh(std::span<const Point3> outline, const Point3& centre,
                              const DiskPattern& pattern = {});

/// Returns the vertices of a regular polygon about the origin, anticlockwise from the +x axis.
/// \param sides 3 or more
/// \param radius radius of the circle through the vertices, above 0
ESPALIER_API std::vector<Point3> regularPolygon(int sides, double radius);

/// Options of gridMesh().
struct GridOptions {
    std::array<int, 2> cells = {1, 1};  ///< along x and y: 1 or more each
    std::array<double, 2> min = {0, 0};
    std::array<double, 2> max = {1, 1};  ///< above min in both
};

/// Makes a rectangle that is divided into rectangles. Vertices and faces are ordered in rows along
/// x, from the smallest y to the largest.
/// \throws ArgumentError for a field out of range
ESPALIER_API Lattice gridMesh(const GridOptions& options = {});

}  // namespace espalier::shapes

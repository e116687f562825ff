// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/far/topology_refiner.h>

#include <array>
#include <memory>
#include <span>
#include <vector>

// Splits the limit volume of a lattice into tricubic patches and blended cells.
namespace espalier::limit {

/// Highest level to which LimitParts refines irregular features.
inline constexpr int kMaxLevelOfParts = 15;

/// A part of the limit volume of a lattice: the limit of one cell of one level.
struct LimitPart {
    Index baseCell = 0;  ///< base cell that `cell` descends from
    int level = 0;
    Index cell = 0;
};

/// Positions of the vertices of all levels, for given positions of the base vertices.
struct LimitPositions {
    std::vector<std::vector<Point3>> levels;

    /// Positions of the vertices of the last level; vertices of blended cells are at their limits.
    std::vector<Point3> limits;
};

/// A tricubic polynomial in Bernstein form.
struct BezierPatch {
    /// Point i + 4j + 16k belongs to Bᵢ(u) Bⱼ(v) Bₖ(w), of degree 3; u, v and w are the axes of
    /// far::hexahedronVertices().
    std::array<Point3, 64> points;

    /// Largest absolute coordinate of the control points that `points` are averages of, including
    /// phantoms (tricubic_patch.h).
    double largestCoordinate = 0;
};

/// Splits the whole limit volume of a lattice into parts. A cell that is regular, on the first
/// level where it is, becomes a tricubic patch. The cells that are irregular on the last level are
/// blended: a blended cell is interpolated in the way a level interpolates its cells
/// (embed/cell_place.h), but between the limits of its vertices. Only irregular cells are refined.
///
/// Immutable and cheap to copy; any number of threads may use one at once.
/// \cite MacCracken & Joy 1996, sections 2.2 and 3
class ESPALIER_API LimitParts {
public:
    /// \param base a lattice; its level 0 is refined anew, locally
    /// \param level level to which irregular features are refined, 1 to kMaxLevelOfParts. Each
    ///        level halves the width of the blended region around a feature
    /// \throws Error if `base` is not a lattice; ArgumentError if `level` is out of range;
    ///         TopologyError and MemoryError as TopologyRefiner::refineUniform()
    /// \cost O(parts). Each level multiplies the number of parts at a feature: by 4 at a surface,
    ///       such as an open boundary, by 2 at an edge, by 1 at a vertex
    LimitParts(const far::TopologyRefiner& base, int level);

    const far::CellComplex& base() const;

    /// Patches in order of level, then blended cells; within a level in order of cells. Under
    /// Boundary::Open, cells that shrink away are not among them.
    std::span<const LimitPart> parts() const;
    std::size_t patchCount() const;

    /// The level of the blended cells. It may contain cells that are not parts.
    const far::CellComplex& lastLevel() const;

    /// Computes the positions of all vertices that the parts need.
    /// \param positions one for each vertex of the base
    /// \throws Error if the number of positions differs from the number of vertices
    /// \cost O(vertices of all levels)
    LimitPositions place(std::span<const Point3> positions) const;

    /// Returns a patch in Bernstein form.
    /// \param patch below patchCount()
    BezierPatch bezierPatch(std::size_t patch, const LimitPositions& positions) const;

private:
    struct Refined;
    std::shared_ptr<const Refined> refined_;
};

}  // namespace espalier::limit

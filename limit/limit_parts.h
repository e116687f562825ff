// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/far/topology_refiner.h>

#include <array>
#include <memory>
#include <span>
#include <vector>

namespace espalier::limit {

/// The most levels to which LimitParts refines irregular features.
inline constexpr int kMaxLevelOfParts = 15;

/// One of the parts that the limit volume of a lattice is made of: the limit of a cell of a level.
struct LimitPart {
    Index baseCell = 0;  ///< that it descends from
    int level = 0;
    Index cell = 0;
};

/// Where the vertices of all levels are, for some positions of those of the base.
struct LimitPositions {
    std::vector<std::vector<Point3>> levels;

    /// Those of the last level; but the vertices of blends are where they go in the limit.
    std::vector<Point3> limits;
};

/// A tricubic polynomial in Bernstein form.
struct BezierPatch {
    /// Point i + 4j + 16k belongs to Bᵢ(u) Bⱼ(v) Bₖ(w), of degree 3; u, v and w are the axes of
    /// far::hexahedronVertices().
    std::array<Point3, 64> points;

    /// Of the vertices that these points are means of, and of phantoms (tricubic_patch.h).
    double largestCoordinate = 0;
};

/// The limit volume of a lattice, all of it: the cells that are regular on the level where they
/// become so, each a tricubic patch, and on the last level what is left around irregular features.
/// There, a cell is blended: taken as one of a level is (embed/cell_place.h), but between the
/// limits of its vertices. Cells are refined there only.
///
/// Immutable and cheap to copy; any number of threads may ask.
/// \cite MacCracken & Joy 1996, sections 2.2 and 3
class ESPALIER_API LimitParts {
public:
    /// \param base a lattice; its level 0 is refined anew, locally
    /// \param level how far irregular features are refined, 1 to kMaxLevelOfParts: what is blended
    ///        around them halves in width with each
    /// \throws Error for what is no lattice, a level out of range;
    ///         TopologyError and MemoryError as TopologyRefiner::refineUniform()
    /// \cost O(parts): at a feature that is a surface, such as an open boundary, 4 times as many as
    ///       on the level before, at an edge twice as many, at a vertex as many
    LimitParts(const far::TopologyRefiner& base, int level);

    const far::CellComplex& base() const;

    /// Patches, by level, and behind them blends, each in order of cells. Under Boundary::Open
    /// without those that shrink away.
    std::span<const LimitPart> parts() const;
    std::size_t patchCount() const;

    /// That of the blends; it may hold more cells.
    const far::CellComplex& lastLevel() const;

    /// \param positions one a vertex of the base
    /// \throws Error if their number is another
    /// \cost O(vertices of all levels)
    LimitPositions place(std::span<const Point3> positions) const;

    /// \param patch below patchCount()
    BezierPatch bezierPatch(std::size_t patch, const LimitPositions& positions) const;

private:
    struct Refined;
    std::shared_ptr<const Refined> refined_;
};

}  // namespace espalier::limit

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/stencils/stencil_table.h>

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

// A barrier that keeps the cells of a lattice from folding; not installed.
namespace espalier::solve {

/// An energy of poses that is 0 unless a cell is nearly folded, and grows without bound as a cell
/// folds.
///
/// It is the sum of c V (h/J − 1)² over the tetrahedra with J < h, and infinite if a tetrahedron
/// has J ≤ 0. J is the volume of a tetrahedron in the pose over its volume at rest, h = kActive, c
/// = kStrength, and V the volume at rest, times 8 for each level after the first. The tetrahedra
/// are spanned by the edges at corners of refined cells:
///
/// - all corners of the cells of level 1;
/// - of the cells of level 2, the corners at vertices of level 1: one corner each;
/// - all corners of the cells of level 3 at base vertices. Around these, cells change their shape
///   from level to level, and coarser levels do not show all folds.
///
/// At a vertex where n > 3 edges of a cell meet, two neighbouring edges and the diagonal to the
/// opposite vertex span a tetrahedron. Tetrahedra that are nearly flat at rest are left
/// out, and so are tetrahedra that only vertices move that stay.
///
/// Immutable. Results do not depend on the number of threads.
class FoldBarrier {
public:
    using Columns = Eigen::MatrixX3d;

    static constexpr double kActive = 0.25;

    /// No tetrahedra.
    FoldBarrier() = default;

    /// \param base its level 0 is used; not with Boundary::Open, under which base vertices vanish
    /// \param rest positions of its vertices, finite
    /// \param isFixed for each vertex whether it stays
    /// \cost refinement to level 2, and of an eighth of the cells to level 3
    FoldBarrier(const far::TopologyRefiner& base, std::span<const Point3> rest,
                std::span<const char> isFixed);

    /// Returns the energy of a pose.
    /// \param moved displacements, one row for each vertex
    /// \param gradient if given, and the energy is finite, the derivatives of the energy are added
    /// \cost O(entries of the rows of the tetrahedra), in parallel
    double energy(const Columns& moved, Columns* gradient = nullptr) const;

private:
    /// Points of a level, and the tetrahedra between them.
    struct Part {
        stencils::StencilTable<double> table;  ///< rows of the points
        std::vector<Point3> rest;
        std::vector<std::array<Index, 4>> tetrahedra;  ///< the corner, and the ends of three edges
        std::vector<double> volumes;                   ///< at rest, six times, with sign
        double scale = 1;  ///< volume of a cell of level 1 over the volume of one of the level
    };

    static void keepUsedRows(Part& part);
    double energy(const Part& part, const Columns& moved, Columns* gradient) const;

    std::vector<Part> parts_;
};

}  // namespace espalier::solve

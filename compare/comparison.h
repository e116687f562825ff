// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/compare/agreement.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace espalier::compare {

/// Refines a mesh, or the boundary of a lattice, with OpenSubdiv, and compares the result with our
/// own refinement.
///
/// All arithmetic is in double precision, except OpenSubdiv's evaluators, which use single
/// precision.
///
/// The whole surface is compared. Under Boundary::Open only the faces that OpenSubdiv keeps are
/// compared, with their edges and vertices: its boundary mode "none" turns the other faces into
/// holes, while our level still has them.
class ESPALIER_API Comparison {
public:
    /// Refines the surface of a refiner's level 0 with OpenSubdiv, up to the refiner's maxLevel().
    ///
    /// \param refiner of a mesh, or of a lattice under boundary control; must outlive this
    /// \throws Error for a curve, for a lattice under Boundary::Open (the rest of its boundary is
    ///         not a subdivision surface), and if OpenSubdiv refuses the surface; MemoryError
    ///         before memory beyond a MemoryLimit is taken
    explicit Comparison(const far::TopologyRefiner& refiner);
    ~Comparison();

    /// Our vertices in the compared part of a level, ascending.
    /// \param level 0 to the maxLevel() that the refiner had at construction
    /// \throws Error if the level is out of range
    const std::vector<Index>& vertices(int level) const;

    /// Returns OpenSubdiv's stencils of these vertices, in this order, over our base vertices.
    /// \param level 1 or more
    /// \throws Error if a vertex has no match
    stencils::StencilTable<double> openSubdivTable(int level) const;

    /// Returns OpenSubdiv's points of these vertices, refined level by level from our base
    /// positions.
    /// \throws Error unless there is one position for each base vertex, or if a vertex has no match
    std::vector<Point3> openSubdivPoints(int level, std::span<const Point3> positions) const;

    /// Compares a level with OpenSubdiv's, with `table` as our table.
    /// \param table stencils of vertices(level) over our base vertices
    /// \throws Error if the table has a different number of rows or columns
    LevelAgreement compare(int level, const stencils::StencilTable<double>& table) const;

    /// Compares all levels from 1 on, with tables that it builds.
    /// \param positions positions of the base vertices, for the picture
    /// \throws Error if under Boundary::Open no face is left to compare; for Rules::Mlca and
    ///         Rules::Rats, which OpenSubdiv does not have
    Agreement compareAll(std::span<const Point3> positions) const;

    /// Number of non-manifold vertices that this release of OpenSubdiv misjudges. Releases before
    /// 3.6.1 treat some vertices as creases that do not form one (pull request 1338); these were
    /// marked as corners for OpenSubdiv.
    Index correctedCorners() const;

private:
    std::vector<std::array<float, 3>> evaluateOpenSubdivTable(
        int level, std::span<const std::array<float, 3>> positions) const;
    std::string noteOn(const Agreement& agreement) const;

    struct Data;
    std::unique_ptr<const Data> data_;
};

}  // namespace espalier::compare

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

/// A mesh, or the boundary of a lattice, refined by OpenSubdiv next to our own refinement.
///
/// Doubles throughout, but for the evaluators, which take single precision in OpenSubdiv.
///
/// What is compared is the whole surface. Under Boundary::Open it is the faces that OpenSubdiv
/// keeps (its boundary mode "none" makes holes of the others) with their edges and vertices; ours
/// has faces beyond them.
class ESPALIER_API Comparison {
public:
    /// Refines the surface of a refiner's level 0 with OpenSubdiv, to the refiner's maxLevel().
    ///
    /// \param refiner of a mesh, or of a lattice under boundary control; must outlive this
    /// \throws Error for a curve, for a lattice under Boundary::Open (what is left of its boundary
    ///         is no subdivision surface), and if OpenSubdiv refuses the surface; MemoryError
    ///         before memory beyond a MemoryLimit is taken
    explicit Comparison(const far::TopologyRefiner& refiner);
    ~Comparison();

    /// Our vertices in the compared part of a level, ascending.
    /// \param level 0 to the refiner's maxLevel() of then
    /// \throws Error if it is none of these
    const std::vector<Index>& vertices(int level) const;

    /// OpenSubdiv's stencils of these vertices, in their order, over our base vertices.
    /// \param level 1 or more
    /// \throws Error if a vertex has no match
    stencils::StencilTable<double> openSubdivTable(int level) const;

    /// OpenSubdiv's points of these vertices from our base positions, refined level by level.
    /// \throws Error if there is not one position a base vertex, or a vertex has no match
    std::vector<Point3> openSubdivPoints(int level, std::span<const Point3> positions) const;

    /// Compares a level, with `table` as ours.
    /// \param table the stencils of vertices(level) over our base vertices
    /// \throws Error if it has other numbers of rows or columns
    LevelAgreement compare(int level, const stencils::StencilTable<double>& table) const;

    /// Compares all levels from 1 on, with our own tables.
    /// \param positions of the base vertices, for the picture
    /// \throws Error if under Boundary::Open no face is left to compare, and for Rules::Mlca and
    ///         Rules::Rats, which OpenSubdiv does not have
    Agreement compareAll(std::span<const Point3> positions) const;

    /// How many non-manifold vertices this release of OpenSubdiv misjudges: releases before 3.6.1
    /// take some for creases that do not form one (pull request 1338). They were marked as corners
    /// for it.
    Index correctedCorners() const;

private:
    std::vector<std::array<float, 3>> evaluateTheirTable(
        int level, std::span<const std::array<float, 3>> positions) const;
    std::string noteOn(const Agreement& agreement) const;

    struct Data;
    std::unique_ptr<const Data> data_;
};

}  // namespace espalier::compare

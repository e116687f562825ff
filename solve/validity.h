// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/far/cell_complex.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/limit/limit_parts.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace espalier::solve {

/// A number and the cell that has it.
struct CellValue {
    Index cell = 0;
    double value = 0;
};

/// What a pose does to the cells of a lattice.
struct PoseValidity {
    /// Of each cell: a lower bound of its least volume ratio (see ValidityCheck), not positive if
    /// and only if the cell is among the inverted. Below the least ratio by 0.1 % of it at most, or
    /// by 1e-6; by more only in cells that come within rounding of flat, or are so twisted that
    /// 2,000 halvings do not tell. Always finite: a ratio beyond ±the largest double counts
    /// as that. Nothing for cells that are bad at rest, or shrink away.
    std::vector<std::optional<double>> ratios;

    std::vector<Index> inverted;  ///< ascending; none that is bad at rest

    /// The least of the ratios, of the lowest such cell; nothing if no cell has one.
    std::optional<CellValue> smallest;
};

/// How far a lattice can go towards a pose.
struct LargestStep {
    /// Up to here, all cells have been proved to stay valid, those apart that are bad at rest. As a
    /// part of the way from rest to pose.
    double length = 0;

    /// A cell that could not be proved to further on. Nothing where the length is the most.
    std::optional<Index> limitingCell;

    /// Whether that cell does not stay valid by a millionth of the length further on, or 1e-12 of
    /// the most that was asked for. If not, it is so twisted that 2,000 halvings did not tell what
    /// becomes of it: it may stay valid.
    bool isTight = true;
};

class CheckedVolume;

/// Tells where poses of a lattice turn its volume inside out: that of the cells of a level, or the
/// limit of the cells of the base.
///
/// A pose carries a point in a cell of the rest lattice to the same place in the cell of the posed
/// one (embed/cell_place.h). By what factor volumes grow there is the quotient of the Jacobian
/// determinants of the two maps: the volume ratio, the determinant of the deformation gradient. It
/// is 1 where nothing changes, whatever the shape of the cells, 0 where something is flattened, and
/// below 0 where the lattice is turned inside out. A cell is inverted if its ratio is not positive
/// all over it: in a hexahedron everywhere in the cell, not at its corners alone; in a type-n cell
/// in each of its 4n tetrahedra. As it is a quotient, the orientation is that of the rest: a
/// lattice may be left-handed.
///
/// In the limit the maps are those of limit::LimitParts: tricubic patches, which are exact and
/// whose determinants are of degree (8, 8, 8), and blends around irregular features. What is said
/// there is said of the blends, which come closer to the limit with the level to which features are
/// refined: those of limit::bindLimit() are finer. A cell of the base is inverted if anything is
/// that descends from it.
///
/// "Valid" is proved, by Bernstein coefficients of determinants (bernstein.h). A cell that
/// cannot be proved valid counts as inverted, and as the end of a step. That errs by little:
/// determinants count as 0 below what rounding may amount to, which is 6e-14 of the product of the
/// longest edges along the three axes (or the cube of the size, for cells of type 4 and above; for
/// a patch the largest derivatives), and what 4e-15 of the largest coordinate does to it (for a
/// patch 4e-14); twice that on the way to a pose; and where the least ratio is not at a corner,
/// below about 1e-6 of the largest. On the way to a pose and beyond, rounding grows with the way,
/// so near its end check() may prove what largestStep() does not.
///
/// Immutable; any number of threads may ask. The answers do not depend on how many work.
class ESPALIER_API ValidityCheck {
public:
    /// \param complex a refined lattice, of level 1 or above (or of hexahedra); kept (a cheap copy)
    /// \param rest where its vertices are at rest; copied
    /// \throws Error if `complex` is not a lattice of quadrilaterals, `rest` does not fit it, or a
    ///         coordinate is not finite or beyond ±1e90, so that its cube would not be
    /// \cost O(cells), in parallel: 1 µs a cell
    ValidityCheck(const far::CellComplex& complex, std::span<const Point3> rest);

    /// \param limit of a lattice, in parts; kept (a cheap copy). What shrinks away is neither good
    ///        nor bad
    /// \param rest where the vertices of the base are at rest; copied
    /// \throws Error as above, but for the faces
    /// \cost O(parts), in parallel: 30 µs a patch, 1 µs a blend
    ValidityCheck(const limit::LimitParts& limit, std::span<const Point3> rest);

    /// The cells that are flat, folded or inside out at rest: turned against most of the cells that
    /// they are joined to by faces, directly or by way of others. They do not count in what
    /// follows. Ascending.
    const std::vector<Index>& badAtRest() const { return badAtRest_; }

    /// \param pose where the vertices are now
    /// \throws Error as the constructor
    /// \cost O(cells), in parallel: 2 µs a cell; 2 ms for one that is as twisted as can be. In the
    ///       limit 0.1 to 0.5 ms a patch; 25 ms
    PoseValidity check(std::span<const Point3> pose) const;

    /// The largest t up to `most` such that no cell is inverted at rest + s (pose − rest), for all
    /// s from 0 to t. Refinement is linear: the same step of the base lattice does that.
    ///
    /// \param most above 0, up to a million
    /// \throws Error as the constructor; if `most` is out of range
    /// \cost O(cells), in parallel: 1 to 3 µs a cell; 4 ms for one as twisted as can be. In the
    ///       limit 0.15 ms a patch; 50 ms
    LargestStep largestStep(std::span<const Point3> pose, double most = 1) const;

private:
    ValidityCheck(CheckedVolume volume, std::span<const Point3> rest);

    std::shared_ptr<const CheckedVolume> volume_;
    limit::LimitPositions rest_;
    std::vector<std::int8_t> orientation_;  ///< of each cell at rest: ±1; 0 if it is bad
    std::vector<Index> badAtRest_;
};

/// The base cell that a cell of a level descends from.
/// \throws Error if the level is not there
/// \cost O(levels · log cells)
ESPALIER_API Index baseCellOf(const far::TopologyRefiner& refiner, int level, Index cell);

}  // namespace espalier::solve

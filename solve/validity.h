// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/far/cell_complex.h>
#include <espalier/far/surface_mesh.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/far/volume_mesh.h>
#include <espalier/limit/limit_parts.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

// Finds the cells that a pose turns inside out, and how far a lattice may move before the first
// such cell.
namespace espalier::solve {

/// A cell and its value.
struct CellValue {
    Index cell = 0;
    double value = 0;
};

/// The effect of a pose on the cells of a lattice.
struct PoseValidity {
    /// For each cell, a lower bound of its smallest volume ratio (see ValidityCheck); positive if
    /// and only if the cell is not in `inverted`. The bound is below the smallest ratio by at most
    /// 0.1 % of it or 1e-6, except in cells that are flat within rounding, or so twisted that 2,000
    /// halvings do not decide. Always finite: clamped to ±the largest double. Empty for cells that
    /// are bad at rest or shrink away.
    std::vector<std::optional<double>> ratios;

    std::vector<Index> inverted;  ///< ascending; without cells that are bad at rest

    /// True if the faces of a surface are compared with their neighbours alone
    /// (ValidityCheck(SurfaceMesh)).
    bool comparesNeighbours = false;

    /// The smallest of the ratios, with the lowest-numbered cell that has it; empty if no cell has
    /// a ratio.
    std::optional<CellValue> smallest;
};

/// How far a lattice can move towards a pose.
struct LargestStep {
    /// Up to this length, all cells are proved to stay valid, except those that are bad at rest. As
    /// a fraction of the way from rest to pose.
    double length = 0;

    /// A cell that could not be proved valid further on. Empty if `length` is the maximum.
    std::optional<Index> limitingCell;

    /// True if that cell is invalid shortly after `length`: by a millionth of it, or 1e-12 of the
    /// requested maximum. False if the cell is so twisted that 2,000 halvings did not decide; it
    /// may then stay valid. False, too, if the faces of a surface are compared with their
    /// neighbours.
    bool isTight = true;
};

class CheckedVolume;

/// Finds where poses of a lattice turn its volume inside out: in the cells of a level, or in the
/// limit of the base cells.
///
/// A pose moves a point in a cell of the rest lattice to the same place in the posed cell
/// (embed/cell_place.h). Volumes grow there by the *volume ratio*: the quotient of the Jacobian
/// determinants of the two maps, which is the determinant of the deformation gradient. It is 1
/// where nothing changes, whatever the shape of the cells; 0 where something is flattened; negative
/// where the lattice is turned inside out. A cell is inverted unless its ratio is positive
/// everywhere in it: in a hexahedron not only at the corners; in a type-n cell in each of its 4n
/// tetrahedra. Because the ratio is a quotient, the orientation at rest cancels: a lattice may be
/// left-handed.
///
/// In the limit, the maps are the parts of limit::LimitParts: tricubic patches, which are exact and
/// have determinants of degree (8, 8, 8), and blends around irregular features. Results around
/// irregular features hold for the blends. The blends approach the limit as the features are
/// refined to higher levels; limit::bindLimit() uses finer blends. A base cell is inverted if any
/// of its descendants is.
///
/// Validity is proved, by Bernstein coefficients of determinants (bernstein.h). A cell that cannot
/// be proved valid counts as inverted, and as the end of a step. The error of this is small. A
/// determinant counts as 0 if it is below the sum of
///
/// - 6e-14 of the product of the longest edges along the three axes (for cells of type 4 and above,
///   of the cube of the size; for a patch, of the largest derivatives);
/// - its change when coordinates change by 4e-15 of the largest coordinate (for a patch 4e-14,
///   for a cell of second order 3e-13).
///
/// On the way to a pose, both are doubled. Where the smallest ratio is not at a corner, ratios
/// below about 1e-6 of the largest count as 0, too. Rounding grows with the length of the way, also
/// beyond the pose; so near the end check() may prove what largestStep() does not.
///
/// Immutable; any number of threads may use one at once. Results do not depend on the number of
/// threads.
class ESPALIER_API ValidityCheck {
public:
    /// Prepares to check the cells of a level.
    /// \param complex a refined lattice, of level 1 or above (or of hexahedra); kept (a cheap copy)
    /// \param rest positions of its vertices at rest; copied
    /// \throws Error if `complex` is not a lattice of quadrilaterals, `rest` does not fit it, or a
    ///         coordinate is not finite or beyond ±1e90, whose cube would overflow
    /// \cost O(cells), in parallel: 1 µs per cell
    ValidityCheck(const far::CellComplex& complex, std::span<const Point3> rest);

    /// Prepares to check the limit of the base cells.
    /// \param limit parts of the limit of a lattice; kept (a cheap copy). Cells that shrink away
    ///        are neither good nor bad
    /// \param rest positions of the base vertices at rest; copied
    /// \throws Error if `rest` does not fit, or a coordinate is not finite or beyond ±1e90
    /// \cost O(parts), in parallel: 30 µs per patch, 1 µs per blended cell
    ValidityCheck(const limit::LimitParts& limit, std::span<const Point3> rest);

    /// Prepares to check the cells of a volume mesh. All straight-edged maps are checked all over:
    /// a pyramid is the trilinear map whose top shrinks to the apex (without the apex), a wedge is
    /// linear over its triangle and along its axis, and a polyhedron consists of tetrahedra that
    /// join its centre, the centre of a face and an edge of that face. The centres are those that
    /// OpenFOAM computes at rest (its decomposition FACE_CENTRE_TRIS), as means of the points of
    /// the cell with fixed weights: so they move linearly with the points, and each determinant is
    /// a cubic polynomial on the way to a pose. Cells of second order are checked all over, too: as
    /// triquadratic maps of a cube, of which a side or an edge is collapsed (30 µs per cell).
    ///
    /// \param mesh kept (a cheap copy)
    /// \param rest positions of its points at rest; copied
    /// \throws Error if `rest` does not fit, or a coordinate is not finite or beyond ±1e90
    /// \cost O(points of cells), in parallel
    ValidityCheck(const far::VolumeMesh& mesh, std::span<const Point3> rest);

    /// Prepares to check the faces of a surface, which are its cells in all results. Volumes are
    /// areas along a normal here, all over the face.
    ///
    /// - If the mesh is planar at rest, within a millionth of its size, and in the pose, within a
    ///   hundredth, and the two planes differ by less than 30 degrees, this is the normal of the
    ///   plane, with the sign that gives the face a positive area at rest.
    /// - Otherwise it is the normal of the face at rest, turned by the rotation that moves the face
    ///   and its neighbours best. A surface in space may turn as a whole; a face is inverted if it
    ///   turns over against its neighbours. largestStep() is then not proved, but found by halving:
    ///   shorter steps may invert faces.
    ///
    /// \param mesh kept (a copy)
    /// \param rest positions of its points at rest; copied
    /// \throws Error if `rest` does not fit, or a coordinate is not finite or beyond ±1e90
    /// \cost O(points of faces), in parallel
    ValidityCheck(const far::SurfaceMesh& mesh, std::span<const Point3> rest);

    /// The number of faces of a surface that share no point with other faces. Where faces are
    /// compared with their neighbours, these are never inverted.
    Index isolatedFaces() const;

    /// The cells that are flat, folded or inside out at rest, ascending. A cell is inside out if
    /// its orientation differs from that of most cells in its connected component (joined by
    /// faces), or in a volume mesh of most cells of its kind. These cells are left out of all
    /// further results.
    const std::vector<Index>& badAtRest() const { return badAtRest_; }

    /// Computes the volume ratios of a pose.
    /// \param pose positions of the vertices in the pose
    /// \throws Error if `pose` does not fit, or a coordinate is not finite or beyond ±1e90
    /// \cost O(cells), in parallel: 2 µs per cell; at most 2 ms for an extremely twisted one. In
    ///       the limit 0.1 to 0.5 ms per patch; at most 25 ms
    PoseValidity check(std::span<const Point3> pose) const;

    /// Finds the largest t up to `maxStep` such that no cell is inverted at rest + s (pose −
    /// rest), for all s from 0 to t. Refinement is linear, so the same step of the base lattice has
    /// this effect.
    ///
    /// \param maxStep above 0, up to a million
    /// \throws Error if `pose` does not fit, or a coordinate is not finite or beyond ±1e90;
    ///         ArgumentError if `maxStep` is out of range
    /// \cost O(cells), in parallel: 1 to 3 µs per cell; at most 4 ms for an extremely twisted one.
    ///       In the limit 0.15 ms per patch; at most 50 ms
    LargestStep largestStep(std::span<const Point3> pose, double maxStep = 1) const;

private:
    ValidityCheck(CheckedVolume volume, std::span<const Point3> rest);
    LargestStep stepByHalving(std::span<const Point3> end, double maxStep) const;

    std::shared_ptr<const CheckedVolume> volume_;
    limit::LimitPositions rest_;
    std::vector<std::int8_t> orientation_;  ///< sign of each cell at rest: ±1; 0 if it is bad
    std::vector<Index> badAtRest_;
};

/// Returns the cells of a lattice that are bad at rest after one refinement, ascending: base cells
/// with a cell of level 1 in ValidityCheck::badAtRest(). There the place of a point is not unique,
/// and a pose of the lattice moves near points in opposite directions.
/// Empty if refinement leaves no cell, as it may under far::Boundary::Open.
/// \param base a lattice that has not been refined
/// \throws Error if `rest` does not fit or is not finite, and as TopologyRefiner::refineUniform()
/// \cost O(cells), in parallel: about 8 µs per hexahedron
ESPALIER_API std::vector<Index> cellsBadAtRest(const far::TopologyRefiner& base,
                                               std::span<const Point3> rest);

/// Returns the base cell that a cell of a level descends from.
/// \throws Error if the level does not exist
/// \cost O(levels · log cells)
ESPALIER_API Index baseCellOf(const far::TopologyRefiner& refiner, int level, Index cell);

}  // namespace espalier::solve

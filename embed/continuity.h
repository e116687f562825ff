// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/base/word.h>
#include <espalier/embed/local_binding.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/stencils/stencil_table.h>

#include <span>
#include <vector>

/// \file
/// Finds the vertices of a lattice to freeze so that a part of the model stays as it is and joins
/// the moving part without a gap, a crease, or a jump in curvature. DesignVariables::freeze() and
/// solve::FitOptions::frozen take the result.
///
/// Consider a point at distance h from a held face. The displacement of a vertex moves the point by
/// a weight times the displacement. For small h this weight is proportional to 1 (the vertex moves
/// the face itself), to h (the vertex is in the layer next to the face), or to h³; it is never
/// proportional to h². In the cells that touch the face, the points of a level depend only on the
/// points of the level before in such cells. So the first layer of vertices determines the weights
/// there, and farther vertices enter with factors of 1/8 per level. Therefore vertices that keep
/// the first derivatives keep the second ones too. On a boundary, refinement is as with a phantom
/// layer 2P₀ − P₁ outside, so the second derivatives across it are 0 anyway. All this holds where
/// the lattice is regular, and the limit is the cubic B-spline. Elsewhere second derivatives may
/// not exist, but the weights of all vertices that are not frozen still fall at least as fast as
/// h².
namespace espalier::embed {

/// How smoothly the held part joins the moving part.
enum class Continuity {
    C0,  ///< positions are held
    C1,  ///< and tangent planes
    C2   ///< and curvatures: by the same vertices as C1, for the reason given above
};
inline constexpr Word<Continuity> kContinuityWords[] = {
    {"c0", Continuity::C0}, {"c1", Continuity::C1}, {"c2", Continuity::C2}};

/// Returns the vertices to freeze, ascending, so that given faces of a lattice do not move. For
/// example, the faces may be the side where a model leaves the lattice, so that the part inside
/// continues to fit the part outside.
///
/// In a box, C0 of a side freezes the vertices of that side; C1 and C2 freeze the next layer too.
///
/// \param base a lattice at level 0
/// \param faces of the lattice, in any order, on its boundary or inside
/// \throws Error if the base has been refined or is not a lattice; under Boundary::Open, where a
///         level does not cover the faces; if there are no faces, or a face does not exist
/// \cost O(base + cells around the faces, refined twice)
/// \cite MacCracken & Joy 1996, sections 2.2 and 3
ESPALIER_API std::vector<Index> verticesHoldingFaces(const far::TopologyRefiner& base,
                                                     std::span<const Index> faces,
                                                     Continuity continuity);

/// Returns the vertices to freeze, ascending, so that points that have been bound stay in their
/// places (C0): all vertices that move one of the points by more than 1e-11 of their own
/// displacement.
/// \param deformation D: one row per point; an empty row needs no vertex
/// \cost O(entries)
ESPALIER_API std::vector<Index> verticesHoldingRows(
    const stencils::StencilTable<double>& deformation);

/// Returns the vertices to freeze, ascending, so that some points of a model stay in their places.
///
/// C0 gives the same vertices as verticesHoldingRows(). For C1 and C2, no vertex of the level moves
/// in the cells that contain the points, nor in the cells around them. So nothing moves in the
/// cells that contain the points, neither in the level nor in the limit. There, displacements of
/// the other vertices change first and second derivatives by the place in a base cell by at most
/// about 1e-10 of the displacements.
///
/// For a point outside the lattice, OutsidePolicy::Nearest freezes the vertices that move the
/// nearest cell; OutsidePolicy::Keep freezes none.
///
/// \param options the options that the model is bound with
/// \throws Error if there are no points, or a point is not finite; and as bindPoints()
/// \cost as bindPoints()
/// \cite MacCracken & Joy 1996, sections 2.2, 3 and 5
ESPALIER_API std::vector<Index> verticesHoldingPoints(const RestLattice& lattice,
                                                      std::span<const Point3> points,
                                                      Continuity continuity,
                                                      const BindingOptions& options = {});

}  // namespace espalier::embed

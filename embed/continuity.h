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
/// Which vertices of a lattice to freeze, so that a part of what it deforms stays as it is, and
/// meets what moves without a gap, a crease, or a jump of its curvature. What is returned is what
/// DesignVariables::freeze() and solve::FitOptions::frozen take.
///
/// Near a face, a vertex's weight grows with the distance h from the face as 1 (its displacement is
/// felt on the face), h (just beside it) or h³. It never grows as h²: level by level, the points of
/// the cells that touch the face depend on those of the level before alone, so that weights there
/// are made by the first layer, and what lies beyond comes in by eighths. So what keeps the first
/// derivatives keeps the second ones as well; on a boundary, where a layer 2P₀ − P₁ may be thought
/// outside (DESIGN, section 3), the second ones across are 0 anyway. It is so where the lattice is
/// regular, of which this is the cubic B-spline; where it is not, there may be no second
/// derivatives to speak of, but still no weight grows slower than h².
namespace espalier::embed {

/// How what is held meets what moves.
enum class Continuity {
    C0,  ///< in its place
    C1,  ///< and with its tangent planes
    C2   ///< and with its curvatures: by the same vertices as C1, as said above
};
inline constexpr Word<Continuity> kContinuityWords[] = {
    {"c0", Continuity::C0}, {"c1", Continuity::C1}, {"c2", Continuity::C2}};

/// The vertices to freeze, ascending, to hold faces of a lattice: the side where a model leaves it,
/// say, so that what is inside fits on what stays outside.
///
/// In a box, C0 of a side are the vertices of the side; C1 and C2 are these and the next layer.
///
/// \param base a lattice at level 0
/// \param faces of it, in any order, on its boundary or inside
/// \throws Error for a base of other levels or no lattice; under Boundary::Open, where a level
///         covers less than the faces; if there are no faces, or one is not there
/// \cost O(base + the cells around the faces, twice refined)
/// \cite MacCracken & Joy 1996, sections 2.2 and 3
ESPALIER_API std::vector<Index> verticesHoldingFaces(const far::TopologyRefiner& base,
                                                     std::span<const Index> faces,
                                                     Continuity continuity);

/// The vertices to freeze, ascending, to hold points in their places (C0) that have been bound:
/// those that move one of them by more than 1e-11 of their own displacement.
/// \param deformation D: a row for each of the points; an empty one asks for no vertex
/// \cost O(entries)
ESPALIER_API std::vector<Index> verticesHoldingRows(
    const stencils::StencilTable<double>& deformation);

/// The vertices to freeze, ascending, to hold points: a part of a model.
///
/// C0 are those of verticesHoldingRows(). For C1 and C2, no vertex of the level moves in the cells
/// that carry the points, and in those around, so that nothing in the former moves, in the level or
/// in the limit. There, first and second derivatives by the place in a base cell change by some
/// 1e-10 of the displacements of the other vertices at most.
///
/// A point outside of the lattice asks for what carries it: under OutsidePolicy::Nearest the
/// nearest cell, under OutsidePolicy::Keep nothing.
///
/// \param options that the model is bound with
/// \throws Error if there are no points; naming one that is not finite; as bindPoints()
/// \cost as bindPoints()
/// \cite MacCracken & Joy 1996, sections 2.2, 3 and 5
ESPALIER_API std::vector<Index> verticesHoldingPoints(const RestLattice& lattice,
                                                      std::span<const Point3> points,
                                                      Continuity continuity,
                                                      const BindingOptions& options = {});

}  // namespace espalier::embed

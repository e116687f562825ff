// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <span>
#include <vector>

/// \file
/// Measures of a shape with their derivatives, for the constraints of an optimiser: distances,
/// thicknesses, volume, area, curvature and planarity.
///
/// Each function takes the points of a shape, such as the points of a model after a pose, or the
/// vertices of the lattice itself. Let G be the derivatives of m measures: m × 3 · points, where
/// column 3i + c belongs to coordinate c of point i. With the deformation matrix D, G (D ⊗ I₃) are
/// the derivatives by the vertices of the lattice (byVertices()), and G J those by the design
/// variables (byVariables(); J is of buildJacobian()).
///
/// All functions throw Error naming the first point that does not exist or that is not finite.

namespace espalier::solve {

/// Some measures of a shape.
struct Measures {
    std::vector<double> values;
    stencils::StencilTable<double> derivatives;  ///< one row for each value
};

// All measures throw Error if a value is not finite, as for points whose products overflow.

/// Measures the distance of each pair of points.
/// \throws Error naming a pair of points at the same place, where the distance has no derivative
ESPALIER_API Measures measureDistances(std::span<const Point3> points,
                                       std::span<const std::array<Index, 2>> pairs);

/// A line through a shape: a point between the two sides of the shape, and a direction of any
/// length.
struct Line {
    Point3 point, direction;
};

/// Finds where lines cross a surface, for measureThicknesses(). Each line is followed from its
/// point in both directions, up to the first triangle.
///
/// \return rows 2k and 2k + 1 hold the weights of the points in the place where line k first meets
///         the surface: in the direction of the line, and in the opposite direction. The weights
///         belong to the corners of one triangle and sum to 1, so that the places follow the
///         surface when its points move
/// \throws ArgumentError for a direction of 0; Error naming a line that does not meet the surface
///         in both directions, or whose point is on a triangle
///         that the line is not parallel to
/// \cost O(lines · triangles), in parallel
ESPALIER_API stencils::StencilTable<double> findCrossings(
    std::span<const Point3> points, std::span<const std::array<Index, 3>> triangles,
    std::span<const Line> lines);

/// Measures the thickness of a shape along each line: the distance between its two crossings, which
/// have moved with the surface.
/// \param crossings of findCrossings(), for the shape at rest
/// \throws Error naming a line whose crossings are at the same place; unless the number of rows is
///         even, and that of columns is the number of points
ESPALIER_API Measures measureThicknesses(std::span<const Point3> points,
                                         const stencils::StencilTable<double>& crossings);

/// Measures the volume within a closed surface: one value, above 0 if the triangles run
/// anticlockwise seen from outside.
/// \throws Error naming an edge that two triangles do not share in opposite directions: the surface
///         is then not closed, and the volume would depend on the origin
/// \cost O(triangles · log triangles)
ESPALIER_API Measures measureVolume(std::span<const Point3> points,
                                    std::span<const std::array<Index, 3>> triangles);

/// Measures the area of a surface: one value. A triangle without area, where the area has no
/// derivative, adds 0 to the derivatives.
ESPALIER_API Measures measureArea(std::span<const Point3> points,
                                  std::span<const std::array<Index, 3>> triangles);

/// Measures the curvature of a line of points, such as a leading edge, at each point between its
/// ends: 1 / radius of the circle through the point and its two neighbours. Where the three points
/// are on a straight line, the curvature is 0 and has no derivative; the derivatives are 0 there.
///
/// \param line two ends and one point or more between them
/// \throws Error naming two neighbours, or the neighbours of a point, that are at the same place
/// \cite Menger 1930, Untersuchungen über allgemeine Metrik
ESPALIER_API Measures measureCurvatures(std::span<const Point3> points,
                                        std::span<const Index> line);

/// Measures how far points are from a plane: one value, the mean of the squared distances from the
/// plane that fits them best. It is 0 if they are in one plane, with the derivatives 0; as a
/// constraint, keep it below the square of a tolerance. If several planes fit equally well, the
/// derivatives are of one of them.
///
/// \param some numbers of the points: three or more
ESPALIER_API Measures measurePlanarity(std::span<const Point3> points, std::span<const Index> some);

/// Returns the derivatives of measures of deformed points by the vertices of the lattice, G (D ⊗
/// I₃): column 3v + c belongs to coordinate c of vertex v.
///
/// \param derivatives G, measures × 3 · points
/// \param deformation D, points × vertices
/// \throws Error unless G has three columns for each row of D
ESPALIER_API stencils::StencilTable<double> byVertices(
    const stencils::StencilTable<double>& derivatives,
    const stencils::StencilTable<double>& deformation);

/// Returns the derivatives of measures by the design variables, G J.
///
/// \param derivatives G, measures × 3 · points
/// \param jacobian J, 3 · points × variables
/// \throws Error unless G has one column for each row of J
ESPALIER_API stencils::StencilTable<double> byVariables(
    const stencils::StencilTable<double>& derivatives,
    const stencils::StencilTable<double>& jacobian);

}  // namespace espalier::solve

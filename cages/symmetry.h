// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/cages/cage.h>

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "model_surface.h"

namespace espalier::cages {

/// Planes across the coordinate axes: the coordinate of the plane across each axis, if there is
/// one.
using MirrorPlanes = std::array<std::optional<double>, 3>;

/// Measures how far a model is from being symmetric about a plane across each axis: the middle of
/// the box around the model, or 0 if that is as good.
///
/// A model is symmetric within a tolerance if each point has a point of the model that near to its
/// mirror image, and the faces of both sides have about the same area at the same places.
///
/// \param tolerance as a fraction of the diagonal
/// \return the plane across each axis; none is used yet
/// \cost O(points) in a grid
std::array<ModelSymmetry::Plane, 3> measureSymmetry(const ModelSurface& surface, double tolerance);

/// The mirror images of the vertices of a lattice.
struct VertexMirror {
    int axis = 0;
    double at = 0;              ///< coordinate of the plane
    double unit = 0;            ///< coordinates along the axis are multiples of it; 0: any numbers
    std::vector<Index> images;  ///< the image of each vertex; itself on the plane
};

/// Returns a power of two such that all coordinates near a model, on both sides of a plane, are
/// exact sums of the coordinate of the plane and a multiple of the unit; 0 for a plane at 0.
/// \param diagonal of the model
double unitOfMirror(double at, double diagonal);

/// Moves vertices by rounding, so that the coordinates of the image of each vertex are exactly the
/// mirrored ones, and vertices on a plane are exactly on it.
void makeSymmetric(std::span<const VertexMirror> mirrors, std::span<Point3> positions);

/// Replaces the gradient by its symmetric part.
void makeGradientSymmetric(std::span<const VertexMirror> mirrors, std::span<Point3> gradient);

}  // namespace espalier::cages

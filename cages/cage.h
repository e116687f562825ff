// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/shapes/lattice.h>

#include <cstddef>
#include <span>

namespace espalier::cages {

/// The surface of a model: any polygons.
struct SurfaceModel {
    std::span<const Point3> points;
    std::span<const Index> corners;     ///< of all faces, one face after the other
    std::span<const std::size_t> ends;  ///< per face: end of its corners
};

struct CageOptions {
    /// Number of vertices of the lattice, 8 or more. The result has between 0.8 and 1.2 times as
    /// many. Not used if `cellSize` is set.
    Index vertices = 200;

    /// Edge of the cells before they are fitted, in the units of the model, above 0; 0: not set.
    double cellSize = 0;

    /// Least distance between the model and the boundary of the lattice, as a fraction of the
    /// diagonal of the smallest box with sides along the axes that holds the model: 0 or more.
    double margin = 0;

    /// Above 0: the lattice is made around the surface only, at least this thick, in the units of
    /// the model. 0: around the solid.
    double shell = 0;

    /// Whether parts of the model that are close to each other stay separate.
    bool keepApart = false;
};

ESPALIER_API Lattice cage(const SurfaceModel& model, const CageOptions& options = {});

}  // namespace espalier::cages

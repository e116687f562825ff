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

}  // namespace espalier::cages

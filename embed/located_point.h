// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/embed/cell_place.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace espalier::embed {

/// Where a point is. It does not depend on the policy for points outside.
enum class PointStatus : std::uint8_t {
    Inside,  ///< the point is in a cell, in a gap between two cells, or within the tolerance of the
             ///< lattice
    Outside,       ///< outside the region that the cells fill
    NotConverged,  ///< no place reproduces the point: its cell is degenerate, or a coordinate is
                   ///< not finite
    NotBound       ///< the weight of the point is 0, or the point is beyond the falloff
                   ///< (bind::BindOptions)
};

/// The result of locating a point in a lattice. Place is CellPlace or TensorPlace.
template <class Place>
struct Located {
    PointStatus status = PointStatus::NotConverged;

    /// The place whose position is the point; nothing if it was not sought (Outside) or not found
    /// (NotConverged).
    std::optional<Place> place;

    /// Distance from the region of the lattice; 0 for points in it. Not computed for a point
    /// outside if no place was sought.
    double distance = 0;

    /// Distance between the point and the position of the place; 0 without a place.
    double residual = 0;

    /// The vector from the nearest place to the point, if the point is carried (Outside, with a
    /// place).
    Point3 away = {};
};

/// A point outside that the nearest cell carries.
struct CarriedPoint {
    Index point = 0;
    Point3 away = {};  ///< the vector from the nearest place in the lattice at rest to the point
    friend bool operator==(const CarriedPoint&, const CarriedPoint&) = default;
};

/// Appends the points of some that are carried. Their numbers are their positions in `points`.
template <class Points>
void addCarried(const Points& points, std::vector<CarriedPoint>& carried) {
    Index number = 0;
    for (const auto& point : points) {
        if (point.status == PointStatus::Outside && point.place)
            carried.push_back({number, point.away});
        ++number;
    }
}

/// The result of locating a point in a refined lattice.
///
/// The residual is the rounding error of the solution. It is at most 1e-12 of the size of the
/// lattice, or of the point's distance from the origin if that distance is larger. A point more
/// than a few thousand cells away has large weights, and the residual is 1e-15 of their size. A
/// point within the tolerance gets the place nearest to it if the way along the tangent is longer
/// than the cell, or the cell is too flat to solve for: the residual is then the distance to that
/// place.
using LocatedPoint = Located<CellPlace>;

}  // namespace espalier::embed

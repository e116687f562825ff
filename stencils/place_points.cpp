// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/stencils/place_points.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

namespace espalier::stencils {

void checkPositions(const far::CellComplex& complex, std::span<const Point3> positions) {
    if (positions.size() != static_cast<std::size_t>(complex.count(0)))
        throw Error("got " + std::to_string(positions.size()) + " positions for " +
                    std::to_string(complex.count(0)) + " vertices");
    for (std::size_t vertex = 0; vertex < positions.size(); ++vertex) {
        const Point3& position = positions[vertex];
        if (!std::all_of(position.begin(), position.end(),
                         [](double coordinate) { return std::isfinite(coordinate); }))
            throw Error("the position of lattice vertex " + std::to_string(vertex) +
                        " is not finite");
    }
}

double checkedTolerance(double tolerance) {
    if (std::isfinite(tolerance) && tolerance >= 0) return tolerance;
    throw Error("the tolerance is " + std::to_string(tolerance) + "; expected 0 or more");
}

void checkPointCount(std::span<const Point3> points) {
    if (points.size() > static_cast<std::size_t>(far::kMaxIndex))
        throw Error("got " + std::to_string(points.size()) + " points; the most is " +
                    std::to_string(far::kMaxIndex));
}

void checkVertexCount(Index placedIn, Index vertexCount) {
    if (placedIn != vertexCount)
        throw Error("the points were embedded in a lattice of " + std::to_string(placedIn) +
                    " vertices, not of " + std::to_string(vertexCount) + ": another level?");
}

void refusePoint(Offset index, const Point3& point, PointStatus status) {
    std::ostringstream message;
    message << "point " << index << " at (" << point[0] << ", " << point[1] << ", " << point[2]
            << ") "
            << (status == PointStatus::Outside
                    ? "is outside the lattice"
                    : "has no place in the lattice: its cell is degenerate, or it is not finite");
    throw Error(message.str());
}

}  // namespace espalier::stencils

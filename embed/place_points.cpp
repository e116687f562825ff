// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/argument_error.h>
#include <espalier/embed/place_points.h>
#include <espalier/embed/space_curve.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

namespace espalier::embed {

void checkPositions(const far::CellComplex& complex, std::span<const Point3> positions) {
    if (std::ssize(positions) != complex.count(0))
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

void checkRest(const RestLattice& lattice, int level) {
    const far::TopologyRefiner& base = lattice.base;
    if (base.dimension() != 3)
        throw Error("points can be bound to a lattice only, not to a complex of dimension " +
                    std::to_string(base.dimension()));
    if (base.maxLevel() != 0)
        throw Error(
            "points can be bound only with a refiner that has not been refined; this one has been "
            "refined to level " +
            std::to_string(base.maxLevel()));
    if (level < 1 || level > kMaxLevelOfPoints)
        throw ArgumentError("", "level", std::to_string(level),
                            concat("1 to ", kMaxLevelOfPoints, " to bind points"));
    const far::Level& level0 = base.level(0);
    checkPositions(level0.complex, lattice.positions);
    // Under Boundary::Open there may be no next level: refineUniform() throws and says why.
    bool isLeft = false;
    for (Index vertex = 0; vertex < level0.complex.count(0); ++vertex)
        isLeft = isLeft || !level0.strata.isOpen({0, vertex});
    if (!isLeft) far::TopologyRefiner(base).refineUniform(1);
}

double checkedTolerance(double tolerance) {
    if (std::isfinite(tolerance) && tolerance >= 0) return tolerance;
    throw ArgumentError("", "tolerance", textOf(tolerance), "a finite number of 0 or more");
}

std::vector<Point3> chosenPoints(std::span<const Point3> points, std::span<const Index> numbers) {
    std::vector<Point3> chosen;
    chosen.reserve(numbers.size());
    for (const Index i : numbers) chosen.push_back(points[i]);
    return chosen;
}

std::vector<Index> alongCurve(std::span<const Point3> points) {
    Eigen::AlignedBox3d box;
    for (const Point3& point : points)
        if (const Eigen::Vector3d position(point.data()); position.allFinite())
            box.extend(position);
    const MortonCurve curve(box);
    Array<CurveItem> places(points.size());
    parallelFor(static_cast<Offset>(points.size()), 4096, [&](Offset first, Offset last) {
        for (Offset i = first; i < last; ++i) {
            places[i] = {curve.key(Eigen::Vector3d(points[i].data())), static_cast<Index>(i)};
        }
    });
    // 32 bits are more than 2¹⁰ parts along each axis, which is fine enough.
    sortAlongCurve(places, 32);
    std::vector<Index> order;
    order.reserve(places.size());
    for (const CurveItem& place : places) order.push_back(place.item);
    return order;
}

void checkPointCount(std::span<const Point3> points) {
    if (std::ssize(points) > kMaxIndex)
        throw Error("got " + std::to_string(points.size()) + " points; the most is " +
                    std::to_string(kMaxIndex));
}

void checkVertexCount(Index placedIn, Index vertexCount) {
    if (placedIn != vertexCount)
        throw Error("the points were embedded in a lattice of " + std::to_string(placedIn) +
                    " vertices, but this one has " + std::to_string(vertexCount) +
                    "; it may be another level");
}

void checkAllInside(std::span<const Point3> points, std::span<const PointStatus> statuses) {
    for (std::size_t i = 0; i < points.size(); ++i)
        if (statuses[i] != PointStatus::Inside)
            refusePoint(static_cast<Offset>(i), points[i], statuses[i]);
}

void refusePoint(Offset index, const Point3& point, PointStatus status) {
    std::ostringstream message;
    message << "point " << index << " at (" << point[0] << ", " << point[1] << ", " << point[2]
            << ") "
            << (status == PointStatus::Outside
                    ? "is outside the lattice"
                    : "cannot be placed in the lattice: its cell is degenerate, or a coordinate is "
                      "not finite");
    throw Error(message.str());
}

}  // namespace espalier::embed

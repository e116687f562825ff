// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/base/vector3.h>
#include <espalier/solve/sliding_points.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "patch_pieces.h"
#include "piece.h"
#include "rotation_fit.h"
#include "slide_fit.h"

namespace espalier::solve {
namespace {

using Kind = SlideShape::Kind;

/// Points at rest are on a shape within this share of the size of their piece, or of its largest
/// coordinate. Files of single precision keep 6e-8 of each coordinate, and files of six digits
/// 5e-7.
constexpr double kOnShape = 1e-6;

/// The box around the points of a piece.
struct Box {
    Point3 low, high;

    Box(std::span<const Index> points, std::span<const Point3> places)
        : low(places[points[0]]), high(low) {
        for (const Index point : points)
            for (std::size_t c = 0; c < 3; ++c) {
                low[c] = std::min(low[c], places[point][c]);
                high[c] = std::max(high[c], places[point][c]);
            }
    }

    double tolerance() const {
        return kOnShape * std::max({length(difference(high, low)), largestCoordinate(low),
                                    largestCoordinate(high)});
    }

    bool contains(const Point3& place, double tolerance) const {
        for (std::size_t c = 0; c < 3; ++c)
            if (!(place[c] >= low[c] - tolerance && place[c] <= high[c] + tolerance)) return false;
        return true;
    }
};

/// Returns the shape of a piece.
/// \throws Error naming the best shape if the points are not on it
SlideShape shapeOfPiece(const far::MeshPatch& patch, const PatchPiece& piece,
                        std::span<const Point3> rest, double tolerance) {
    const std::span<const Index> points = piece.points;
    constexpr std::size_t kEnds = 2, kOfPlane = 3, kOfCylinder = 6;
    const auto refuse = [&](const std::string& why) {
        return Error(concat("the points of the patch ", inQuotes(patch.name),
                            " cannot slide: ", why, ". To keep them still, hold the patch"));
    };
    const std::string count = concat(points.size(), points.size() == 1 ? " point" : " points");
    if (points.size() < (piece.isOfLines ? kEnds : kOfPlane))
        throw refuse(concat(count, " of it determine no ", piece.isOfLines ? "line" : "plane"));
    const FittedShape line = fitLine(points, rest);
    if (line.distance <= tolerance) return line.shape;
    FittedShape best = line;
    const auto take = [&](const FittedShape& fitted) {
        if (fitted.distance < best.distance) best = fitted;
    };
    if (piece.isOfLines) {
        take(fitCircle(points, rest));
    } else {
        take(fitPlane(points, rest));
        if (best.distance > tolerance && points.size() >= kOfCylinder)
            take(fitCylinder(points, rest));
    }
    if (best.distance <= tolerance) return best.shape;
    const auto farthest = std::ranges::max_element(
        points, {}, [&](Index point) { return distanceFrom(best.shape, rest[point]); });
    throw refuse(concat(count, " of it are on no ",
                        piece.isOfLines ? "line and no circle" : "plane and no cylinder",
                        "; the best ", nameOf(best.shape.kind), " is ", best.distance,
                        " away from point ", *farthest, ", where ", tolerance, " is allowed"));
}

/// Returns true if all points of a piece of the kind `kind` are on a shape of the same kind.
bool areOn(const SlideShape& shape, Kind kind, std::span<const Index> points,
           std::span<const Point3> rest, double tolerance) {
    return shape.kind == kind && std::ranges::none_of(points, [&](Index point) {
               return !(distanceFrom(shape, rest[point]) <= tolerance);
           });
}

/// Adds the directions in which a point leaves a shape, each of length 1, and how far it has left.
/// \param radius of the point at rest from the axis
template <class Add>
void addDirections(const SlideShape& shape, const Point3& rest, const Point3& place, Add add) {
    const Point3 moved = difference(place, rest);
    if (shape.kind == Kind::Plane || shape.kind == Kind::Circle)
        add(toEigen(shape.direction), dot(moved, shape.direction));
    if (shape.kind == Kind::Line) {
        const Eigen::Vector3d direction = toEigen(shape.direction);
        const Eigen::Vector3d first = direction.unitOrthogonal(), second = direction.cross(first);
        for (const Eigen::Vector3d& across : {first, second})
            add(across, across.dot(toEigen(moved)));
    }
    if (shape.kind == Kind::Cylinder || shape.kind == Kind::Circle) {
        const Eigen::Vector3d radial = toEigen(fromAxis(shape, place));
        add(radial.normalized(), radial.norm() - length(fromAxis(shape, rest)));
    }
}

/// Directions within this angle are one direction: a cylinder that touches a plane is tangent to it
/// within the tolerance of points on shapes. The directions of planes are more precise.
constexpr double kSameDirection = 5e-3, kSameNormal = 1e-4;

/// The directions in which a point leaves its shapes, one in each row.
using Directions = Eigen::Matrix<double, Eigen::Dynamic, 3>;

Directions directionsOf(std::span<const Eigen::Vector3d> rows) {
    Directions directions(static_cast<Eigen::Index>(rows.size()), 3);
    for (std::size_t row = 0; row < rows.size(); ++row)
        directions.row(static_cast<Eigen::Index>(row)) = rows[row].transpose();
    return directions;
}

bool isCurved(const SlideShape& shape) {
    return shape.kind == Kind::Cylinder || shape.kind == Kind::Circle;
}

}  // namespace

std::string_view nameOf(SlideShape::Kind kind) {
    switch (kind) {
        case Kind::Plane:
            return "plane";
        case Kind::Cylinder:
            return "cylinder";
        case Kind::Line:
            return "line";
        case Kind::Circle:
            return "circle";
    }
    return "";
}

SlidingPoints::SlidingPoints(std::span<const far::MeshPatch> patches, std::span<const Point3> rest)
    : restCount_(rest.size()) {
    std::vector<std::vector<std::size_t>> ofPoints(rest.size());
    std::vector<std::size_t> firstPatch(rest.size(), patches.size());
    for (std::size_t number = 0; number < patches.size(); ++number) {
        const far::MeshPatch& patch = patches[number];
        if (patch.dimension == 3)
            throw Error(concat("the points of the patch ", inQuotes(patch.name),
                               " cannot slide: it is a group of cells, and has no plane, cylinder, "
                               "line or circle"));
        for (const std::span<const Index> numbers :
             {std::span<const Index>(patch.points), std::span<const Index>(patch.faces.values),
              std::span<const Index>(patch.lines.values)})
            for (const Index point : numbers)
                if (point < 0 || std::cmp_greater_equal(point, rest.size()))
                    throw Error(concat("the patch ", inQuotes(patch.name), " has point ", point,
                                       ", but there are ", rest.size(), " points"));
        addShapes(patch, rest, ofPoints);
        for (const Index point : patch.points)
            firstPatch[point] = std::min(firstPatch[point], number);
    }
    for (std::size_t i = 0; i < rest.size(); ++i) {
        if (ofPoints[i].empty()) continue;
        points_.push_back({static_cast<Index>(i), firstPatch[i], rest[i], std::move(ofPoints[i])});
        if (points_.back().shapes.size() > 1) intersect(points_.back());
    }
}

void SlidingPoints::addShapes(const far::MeshPatch& patch, std::span<const Point3> rest,
                              std::vector<std::vector<std::size_t>>& ofPoints) {
    Patch& result = patches_.emplace_back(Patch{patch.name, {}});
    if (patch.points.empty()) return;
    const std::vector<PatchPiece> pieces = piecesOf(patch, rest);
    std::vector<std::size_t> shapesOfPieces;
    std::vector<Box> boxes;
    for (const PatchPiece& piece : pieces) {
        checkCancelledEvery(boxes.size(), 8);
        const Box& box = boxes.emplace_back(piece.points, rest);
        const double tolerance = box.tolerance();
        // A piece of a shape that a larger piece has determines it less well. A plane that has
        // been found is tried first; then a piece that is flat must not lie on a cylinder.
        const auto findShape = [&](Kind kind) {
            return std::ranges::find_if(shapes_, [&](const SlideShape& shape) {
                return areOn(shape, kind, piece.points, rest, tolerance);
            });
        };
        auto found = findShape(piece.isOfLines ? Kind::Line : Kind::Plane);
        if (found == shapes_.end()) {
            const SlideShape shape = shapeOfPiece(patch, piece, rest, tolerance);
            found = findShape(shape.kind);
            if (found == shapes_.end()) found = shapes_.insert(found, shape);
        }
        shapesOfPieces.push_back(std::size_t(found - shapes_.begin()));
    }
    std::vector<std::size_t> own = shapesOfPieces;
    std::ranges::sort(own);
    own.erase(std::unique(own.begin(), own.end()), own.end());
    for (const std::size_t shape : own) result.shapes.push_back(shapes_[shape]);

    std::vector<bool> isInPiece(rest.size());
    const auto add = [&](Index point, std::size_t shape) {
        auto& list = ofPoints[point];
        if (std::ranges::find(list, shape) == list.end()) list.push_back(shape);
        isInPiece[point] = true;
    };
    for (std::size_t i = 0; i < pieces.size(); ++i)
        for (const Index point : pieces[i].points) add(point, shapesOfPieces[i]);
    // Points in the middle of edges and faces of second order.
    for (const Index point : patch.points) {
        if (isInPiece[point]) continue;
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < pieces.size(); ++i) {
            const double tolerance = boxes[i].tolerance();
            const double distance = distanceFrom(shapes_[shapesOfPieces[i]], rest[point]);
            least = std::min(least, distance);
            // The box, because another plane of the patch may go through the point.
            if (distance <= tolerance && boxes[i].contains(rest[point], tolerance))
                add(point, shapesOfPieces[i]);
        }
        if (!isInPiece[point])
            throw Error(concat("the points of the patch ", inQuotes(patch.name),
                               " cannot slide: point ", point,
                               ", in the middle of an edge or a face, is ", least,
                               " away from the shapes of their corners. To keep them still, hold "
                               "the patch"));
    }
}

/// Finds where a point of several shapes may slide.
void SlidingPoints::intersect(Point& point) {
    // Where a cylinder touches a plane or another cylinder, the point stays on their common line.
    for (std::size_t i = 0; i < point.shapes.size(); ++i)
        for (std::size_t j = 0; j < i && !point.isFixed; ++j) {
            const SlideShape &a = shapes_[point.shapes[i]], &b = shapes_[point.shapes[j]];
            const bool isTube = a.kind == Kind::Cylinder, isOtherTube = b.kind == Kind::Cylinder;
            if (!(isTube || isOtherTube) || !(isTube || a.kind == Kind::Plane) ||
                !(isOtherTube || b.kind == Kind::Plane))
                continue;
            std::vector<Eigen::Vector3d> rows;
            for (const SlideShape* shape : {&a, &b})
                addDirections(*shape, point.rest, point.rest,
                              [&](const Eigen::Vector3d& row, double) { rows.push_back(row); });
            if (rows[0].cross(rows[1]).norm() > kSameDirection) continue;
            const Point3 axis = isTube ? a.direction : b.direction;
            if (isTube && isOtherTube && length(cross(axis, b.direction)) > kSameDirection) {
                point.isFixed = true;
                break;
            }
            auto line = std::ranges::find_if(shapes_, [&](const SlideShape& shape) {
                return shape.kind == Kind::Line && shape.direction == axis;
            });
            if (line == shapes_.end()) line = shapes_.insert(line, {Kind::Line, point.rest, axis});
            point.shapes[j] = std::size_t(line - shapes_.begin());
            point.shapes.erase(point.shapes.begin() + std::ptrdiff_t(i--));
            break;
        }
    std::vector<Eigen::Vector3d> rows;
    double same = kSameNormal;
    for (const std::size_t number : point.shapes) {
        if (isCurved(shapes_[number])) same = kSameDirection;
        addDirections(shapes_[number], point.rest, point.rest,
                      [&](const Eigen::Vector3d& row, double) { rows.push_back(row); });
    }
    Eigen::JacobiSVD<Directions> svd(directionsOf(rows), Eigen::ComputeThinU | Eigen::ComputeThinV);
    svd.setThreshold(same);
    if (svd.rank() >= 3) point.isFixed = true;
}

std::optional<std::size_t> SlidingPoints::curvedPatch() const {
    const auto found = std::ranges::find_if(
        patches_, [](const Patch& patch) { return std::ranges::any_of(patch.shapes, isCurved); });
    if (found == patches_.end()) return std::nullopt;
    return std::size_t(found - patches_.begin());
}

Point3 SlidingPoints::onShape(const Point& point, const SlideShape& shape,
                              const Point3& place) const {
    const Point3 moved = difference(place, point.rest);
    const double along = dot(moved, shape.direction);
    if (shape.kind == Kind::Plane) return difference(place, scaled(shape.direction, along));
    if (shape.kind == Kind::Line) return sum(point.rest, scaled(shape.direction, along));
    const Point3 radial = fromAxis(shape, place);
    const double radius = length(fromAxis(shape, point.rest)), now = length(radial);
    if (!(now > std::numeric_limits<double>::epsilon() * radius))
        throw Error(concat("point ", point.number, " of the patch ",
                           inQuotes(patches_[point.patch].name), " is moved to the axis of its ",
                           nameOf(shape.kind), ", where no place of the ", nameOf(shape.kind),
                           " is nearest"));
    const Point3 onCylinder = sum(place, scaled(radial, radius / now - 1));
    if (shape.kind == Kind::Cylinder) return onCylinder;
    return difference(onCylinder, scaled(shape.direction, along));
}

Point3 SlidingPoints::onShapes(const Point& point, const Point3& place) const {
    if (point.isFixed || place == point.rest) return point.rest;
    if (point.shapes.size() == 1) return onShape(point, shapes_[point.shapes[0]], place);
    // Newton's method: the shortest step that brings the point to all shapes, as if they were flat.
    // It ends where a step gains nothing more, which rounding decides.
    constexpr int kMaxSteps = 100;
    Eigen::Vector3d now = toEigen(place);
    Eigen::Vector3d best = now;
    double least = std::numeric_limits<double>::infinity(), size = 0;
    for (int step = 0; step < kMaxSteps; ++step) {
        std::vector<Eigen::Vector3d> rows;
        std::vector<double> distances;
        double same = kSameNormal;
        for (const std::size_t number : point.shapes) {
            const SlideShape& shape = shapes_[number];
            if (isCurved(shape)) same = kSameDirection;
            addDirections(shape, point.rest, {now[0], now[1], now[2]},
                          [&](const Eigen::Vector3d& row, double distance) {
                              rows.push_back(row);
                              distances.push_back(distance);
                          });
            size = std::max({size, largestCoordinate(point.rest), shape.radius});
        }
        const Eigen::Map<const Eigen::VectorXd> off(distances.data(),
                                                    static_cast<Eigen::Index>(distances.size()));
        const double largest = off.cwiseAbs().maxCoeff();
        if (!(largest < least)) break;
        least = largest;
        best = now;
        if (largest == 0) break;
        Eigen::JacobiSVD<Directions> svd(directionsOf(rows),
                                         Eigen::ComputeThinU | Eigen::ComputeThinV);
        svd.setThreshold(same);
        now -= svd.solve(off);
    }
    constexpr double kRounding = 64 * std::numeric_limits<double>::epsilon();
    if (!(least <= kRounding * std::max(size, best.cwiseAbs().maxCoeff())))
        throw Error(concat("point ", point.number, " of the patch ",
                           inQuotes(patches_[point.patch].name),
                           " finds no place that is on all of its ", point.shapes.size(),
                           " shapes: the pose moves it too far"));
    return {best[0], best[1], best[2]};
}

SlidingPoints::Correction SlidingPoints::slide(std::span<Point3> points) const {
    if (points.size() != restCount_)
        throw Error(concat("got ", points.size(), " positions for ", restCount_, " points"));
    Correction correction;
    for (const Point& point : points_) {
        Point3& place = points[point.number];
        const Point3 slid = onShapes(point, place);
        const double distance = length(difference(slid, place));
        if (distance > correction.distance) correction = {distance, point.number};
        place = slid;
    }
    return correction;
}

}  // namespace espalier::solve

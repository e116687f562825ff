// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/far/parallel.h>
#include <espalier/far/standard_cells.h>
#include <espalier/stencils/place_points.h>
#include <espalier/stencils/point_location.h>
#include <espalier/stencils/simplex.h>
#include <espalier/stencils/trilinear.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <string>

namespace espalier::stencils {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using far::CellId;
using far::Index;

namespace {

/// How far beyond 0 and 1 a coordinate of a point on a face may come out: Newton's result is off by
/// the rounding of the point (1e-16 of its size) over the size and thinness of the cell, for which
/// this allows six orders of magnitude.
constexpr double kOnFace = 1e-10;

/// Boxes are widened by this part of the bounding box, so that a point on a face lies in the boxes
/// of both cells whatever way its coordinates were rounded.
constexpr double kBoxSlack = 1e-12;

/// A place must give its point back within this part of the lattice's size, or of how far off the
/// point lies: what the project promises of the rest pose.
constexpr double kResidual = 1e-12;

BoxTree::Box boundingBox(std::span<const Point3> positions) {
    BoxTree::Box box;
    for (const Point3& position : positions) box.extend(Vector3d(position.data()));
    return box;
}

std::vector<BoxTree::Box> cellBoxes(const far::CellComplex& complex,
                                    std::span<const Point3> positions, double margin) {
    std::vector<BoxTree::Box> boxes(static_cast<std::size_t>(complex.count(3)));
    for (Index cell = 0; cell < complex.count(3); ++cell) {
        BoxTree::Box& box = boxes[static_cast<std::size_t>(cell)];
        for (const Index vertex : complex.relation(3, 0)[cell])
            box.extend(Vector3d(positions[static_cast<std::size_t>(vertex)].data()));
        box.min().array() -= margin;
        box.max().array() += margin;
    }
    return boxes;
}

const far::CellComplex& checked(const far::CellComplex& complex,
                                std::span<const Point3> positions) {
    checkPositions(complex, positions);
    if (complex.dimension() != 3)
        throw Error("points can be embedded in a lattice only, not in a complex of dimension " +
                    std::to_string(complex.dimension()));
    for (Index face = 0; face < complex.count(2); ++face)
        if (complex.relation(2, 0)[face].size() != 4)
            throw Error("face " + std::to_string(face) +
                        " is not a quadrilateral: embedding needs a lattice refined at least once");
    return complex;
}

std::vector<std::optional<std::array<Index, 8>>> hexahedra(const far::CellComplex& complex) {
    std::vector<std::optional<std::array<Index, 8>>> corners(
        static_cast<std::size_t>(complex.count(3)));
    far::parallelFor(complex.count(3), 4096, [&](far::Offset first, far::Offset last) {
        for (far::Offset cell = first; cell < last; ++cell)
            corners[static_cast<std::size_t>(cell)] =
                far::hexahedronVertices(complex, CellId(static_cast<Index>(cell)));
    });
    return corners;
}

/// The corners of a hexahedron, seen from a point.
Trilinear mapAround(const std::array<Index, 8>& corners, std::span<const Point3> positions,
                    const Vector3d& point) {
    Trilinear::Corners offsets;
    for (std::size_t i = 0; i < 8; ++i)
        offsets[i] = Vector3d(positions[static_cast<std::size_t>(corners[i])].data()) - point;
    return Trilinear(offsets);
}

}  // namespace

PointLocator::PointLocator(const far::CellComplex& complex, std::span<const Point3> positions,
                           double tolerance)
    : complex_(checked(complex, positions)),
      positions_(positions.begin(), positions.end()),
      corners_(hexahedra(complex)),
      size_(boundingBox(positions).diagonal().stableNorm()),
      tolerance_(checkedTolerance(tolerance) * size_),
      tree_(cellBoxes(complex, positions, tolerance_ + kBoxSlack * size_)) {}

Vector3d PointLocator::positionOf(const CellPlace& place) const {
    Vector3d sum = Vector3d::Zero();
    for (const auto& [vertex, weight] : placeWeights(complex_, place))
        sum += weight * positionOf(vertex);
    return sum;
}

Vector3d PointLocator::centreOf(CellId cell) const {
    const auto vertices = complex_.relation(3, 0)[cell.value];
    Vector3d sum = Vector3d::Zero();
    for (const Index vertex : vertices) sum += positionOf(vertex);
    return sum / static_cast<double>(vertices.size());
}

std::optional<CellPlace> PointLocator::findInside(CellId cell, const Vector3d& point,
                                                  bool thoroughly) const {
    if (const auto& corners = cornersOf(cell)) {
        const Trilinear map = mapAround(*corners, positions_, point);
        const auto uvw = thoroughly ? map.findOriginInside(kOnFace) : map.findOrigin();
        if (!uvw || !isInUnitCube(*uvw, kOnFace)) return std::nullopt;
        return CellPlace{cell, 0, toArray(*uvw), {}};
    }
    if (thoroughly) return std::nullopt;  // The tetrahedra were solved exactly the first time.
    const Vector3d centre = centreOf(cell);
    for (Index t = 0; t < tetrahedronCount(complex_, cell); ++t) {
        Matrix3d edges;
        const auto base = tetrahedronBase(complex_, cell, t);
        for (Eigen::Index i = 0; i < 3; ++i)
            edges.col(i) = positionOf(base[static_cast<std::size_t>(i)]) - centre;
        const Vector3d uvw = edges.partialPivLu().solve(point - centre);
        if (uvw.allFinite() && uvw.minCoeff() >= -kOnFace && uvw.sum() <= 1 + kOnFace)
            return CellPlace{cell, t, toArray(uvw), {}};
    }
    return std::nullopt;
}

CellPlace PointLocator::nearestPlace(CellId cell, const Vector3d& point) const {
    if (const auto& corners = cornersOf(cell)) {
        const Trilinear map = mapAround(*corners, positions_, point);
        return {cell, 0, toArray(map.nearestToOrigin()), {}};
    }
    CellPlace best{cell, 0, {}, {}};
    double bestSquared = std::numeric_limits<double>::infinity();
    for (Index t = 0; t < tetrahedronCount(complex_, cell); ++t) {
        Triangle triangle;
        const auto base = tetrahedronBase(complex_, cell, t);
        for (std::size_t i = 0; i < 3; ++i) triangle[i] = positionOf(base[i]) - point;
        const Vector3d uvw = nearestToOrigin(triangle);
        const double squared =
            (uvw[0] * triangle[0] + uvw[1] * triangle[1] + uvw[2] * triangle[2]).squaredNorm();
        if (squared >= bestSquared) continue;
        bestSquared = squared;
        best.tetrahedron = t;
        best.uvw = toArray(uvw);
    }
    return best;
}

/// Sets the offset that leads from a place to a point along the tangent of the cell's map.
/// \return false if the map is singular there
bool PointLocator::continueTo(const Vector3d& point, CellPlace& place) const {
    Matrix3d jacobian;
    Vector3d from;
    if (const auto& corners = cornersOf(place.cell)) {
        const Trilinear map = mapAround(*corners, positions_, point);
        jacobian = map.jacobian(Vector3d(place.uvw.data()));
        from = map.position(Vector3d(place.uvw.data()));
    } else {
        const Vector3d centre = centreOf(place.cell);
        const auto base = tetrahedronBase(complex_, place.cell, place.tetrahedron);
        for (Eigen::Index i = 0; i < 3; ++i)
            jacobian.col(i) = positionOf(base[static_cast<std::size_t>(i)]) - centre;
        from = centre - point + jacobian * Vector3d(place.uvw.data());
    }
    const Vector3d offset = jacobian.fullPivLu().solve(-from);
    if (!offset.allFinite()) return false;
    place.offset = toArray(offset);
    return true;
}

/// The vertices of the face, edge or vertex of its cell that a place on the cell's surface lies on.
std::vector<Index> PointLocator::supportOf(const CellPlace& place) const {
    std::vector<Index> support;
    if (const auto& corners = cornersOf(place.cell)) {
        const auto weights = Trilinear::weights(Vector3d(place.uvw.data()));
        for (std::size_t i = 0; i < 8; ++i)
            if (weights[i] > 0) support.push_back((*corners)[i]);
        return support;
    }
    // On the base of its tetrahedron: the weight of the apex is 0, but for rounding.
    const auto base = tetrahedronBase(complex_, place.cell, place.tetrahedron);
    for (std::size_t i = 0; i < 3; ++i)
        if (place.uvw[i] > 0) support.push_back(base[i]);
    return support;
}

/// Whether a place on the surface of its cell lies on the boundary of the lattice.
bool PointLocator::isOnBoundary(const CellPlace& place) const {
    const std::vector<Index> support = supportOf(place);
    const auto faces = complex_.relation(0, 2)[support.front()];
    return std::any_of(faces.begin(), faces.end(), [&](Index face) {
        if (complex_.relation(2, 3)[face].size() == 2) return false;
        const auto loop = complex_.relation(2, 0)[face];
        return std::all_of(support.begin(), support.end(),
                           [&](Index vertex) { return far::contains(loop, vertex); });
    });
}

LocatedPoint PointLocator::locate(const Point3& position, bool seekNearest) const {
    const Vector3d point(position.data());
    LocatedPoint result;
    if (!point.allFinite()) return result;

    std::vector<Index> candidates;
    tree_.findContaining(point, candidates);
    std::sort(candidates.begin(), candidates.end());
    for (const bool thoroughly : {false, true})
        for (const Index cell : candidates) {
            const auto place = findInside(CellId(cell), point, thoroughly);
            if (place && settle(point, *place, result)) return result;
        }
    // A gap lies in the hull of the face it is at, and so in the boxes of the cells beside it: a
    // point in no box is outside.
    if (candidates.empty() && !seekNearest) {
        result.status = PointStatus::Outside;
        return result;
    }
    const auto nearest = tree_.findNearest(point, [&](Index cell) {
        return (positionOf(nearestPlace(CellId(cell), point)) - point).norm();
    });
    CellPlace place = nearestPlace(CellId(nearest.index), point);
    result.distance = nearest.distance;
    const bool isInside = nearest.distance <= tolerance_ || !isOnBoundary(place);
    if (!isInside && !seekNearest) {
        result.status = PointStatus::Outside;
        return result;
    }
    // A point within the tolerance may be taken for its nearest place, if nothing better can be
    // had.
    if (!(continueTo(point, place) && settle(point, place, result)) &&
        nearest.distance <= tolerance_) {
        place.offset = {};
        result.place = place;
        result.residual = nearest.distance;
        result.status = PointStatus::Inside;
    }
    if (result.place && !isInside) result.status = PointStatus::Outside;
    return result;
}

/// Takes a place for a point, if it gives the point back.
bool PointLocator::settle(const Vector3d& point, const CellPlace& place,
                          LocatedPoint& result) const {
    const double residual = (positionOf(place) - point).norm();
    if (!(residual <= kResidual * std::max(size_, point.norm()))) return false;
    result.place = place;
    result.residual = residual;
    result.status = PointStatus::Inside;
    return true;
}

}  // namespace espalier::stencils

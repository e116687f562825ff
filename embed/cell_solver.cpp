// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/parallel.h>
#include <espalier/embed/cell_solver.h>
#include <espalier/embed/continuation.h>
#include <espalier/embed/place_points.h>
#include <espalier/embed/rounded_product.h>
#include <espalier/embed/solve3.h>
#include <espalier/embed/trilinear.h>
#include <espalier/far/standard_cells.h>

#include <algorithm>
#include <limits>
#include <string>

#include <espalier/embed/simplex.h>

namespace espalier::embed {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// How far beyond 0 and 1 the coordinate of a point on a face may be. Newton's result is off by the
/// rounding of the point (1e-16 of its size) divided by the size and thinness of the cell; this
/// value allows six orders of magnitude for that.
constexpr double kOnFace = 1e-10;

/// Margin of boxes, as a fraction of the bounding box: a point on a face must be in the boxes of
/// both cells however its coordinates were rounded.
constexpr double kBoxSlack = 1e-12;

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

Array<std::optional<std::array<Index, 8>>> hexahedra(const far::CellComplex& complex) {
    Array<std::optional<std::array<Index, 8>>> corners(complex.count(3));
    parallelFor(complex.count(3), 4096, [&](Offset first, Offset last) {
        for (Offset cell = first; cell < last; ++cell)
            corners[cell] = far::hexahedronVertices(complex, CellId(static_cast<Index>(cell)));
    });
    return corners;
}

/// Returns the map of a hexahedron with the origin moved to a point.
Trilinear mapAround(const std::array<Index, 8>& corners, std::span<const Point3> positions,
                    const Vector3d& point) {
    Trilinear::Corners offsets;
    for (std::size_t i = 0; i < 8; ++i) offsets[i] = Vector3d(positions[corners[i]].data()) - point;
    return Trilinear(offsets);
}

}  // namespace

CellSolver::Scale CellSolver::scaleOf(std::span<const Point3> positions, double tolerance) {
    Eigen::AlignedBox3d box;
    for (const Point3& position : positions) box.extend(Vector3d(position.data()));
    const double size = box.diagonal().stableNorm();
    return {size, checkedTolerance(tolerance) * size};
}

CellSolver::CellSolver(const far::CellComplex& complex, std::span<const Point3> positions,
                       Scale scale)
    : complex_(checked(complex, positions)),
      positions_(positions.begin(), positions.end()),
      corners_(hexahedra(complex)),
      scale_(scale) {}

std::optional<LocatedPoint> CellSolver::resultIfUnreachable(const Vector3d& point,
                                                            const Point3& vertex, double size) {
    // Weights that sum to 1 and reproduce the point sum to at least distance / size in absolute
    // value, since no vertex is farther from another than the size. From very far away, all cells
    // would be equally near up to rounding, and all would be searched.
    constexpr double kFarthest = 100;
    static_assert(kFarthest > 10 * kMaxRowSum);
    if (!point.allFinite()) return LocatedPoint{PointStatus::NotConverged, {}, 0, 0};
    if ((point - Vector3d(vertex.data())).stableNorm() <= kFarthest * size) return std::nullopt;
    return LocatedPoint{PointStatus::Outside, {}, 0, 0};
}

Eigen::AlignedBox3d CellSolver::boxOf(CellId cell) const {
    Eigen::AlignedBox3d box;
    if (const auto& corners = cornersOf(cell))
        for (const Index corner : *corners) box.extend(positionOf(corner));
    else
        for (const Index vertex : complex_.relation(3, 0)[cell.value])
            box.extend(positionOf(vertex));
    const double margin = scale_.tolerance + kBoxSlack * scale_.size;
    box.min().array() -= margin;
    box.max().array() += margin;
    return box;
}

Vector3d CellSolver::positionOf(const CellPlace& place) const {
    Vector3d sum = Vector3d::Zero();
    for (const auto& [vertex, weight] : placeWeights(complex_, place))
        sum += weight * positionOf(vertex);
    return sum;
}

Vector3d CellSolver::centreOf(CellId cell) const {
    const auto vertices = complex_.relation(3, 0)[cell.value];
    Vector3d sum = Vector3d::Zero();
    for (const Index vertex : vertices) sum += positionOf(vertex);
    return sum / static_cast<double>(vertices.size());
}

CellSolver::Tetrahedron CellSolver::tetrahedron(CellId cell, Index number,
                                                const Vector3d& centre) const {
    Tetrahedron result{centre, {}};
    const auto base = tetrahedronBase(complex_, cell, number);
    for (Eigen::Index i = 0; i < 3; ++i) result.edges.col(i) = positionOf(base[i]) - centre;
    return result;
}

std::optional<LocatedPoint> CellSolver::locateIn(const Vector3d& point,
                                                 std::span<const Index> cells) const {
    for (const bool thoroughly : {false, true})
        for (const Index cell : cells)
            if (auto found = findIn(CellId(cell), point, thoroughly)) return found;
    return std::nullopt;
}

std::optional<LocatedPoint> CellSolver::findIn(CellId cell, const Vector3d& point,
                                               bool thoroughly) const {
    const auto found = [&](const CellPlace& place, double residual) {
        return residual <= kResidual * std::max(scale_.size, point.norm())
                   ? std::optional(LocatedPoint{PointStatus::Inside, place, 0, residual})
                   : std::nullopt;
    };
    if (const auto& corners = cornersOf(cell)) {
        const Trilinear map = mapAround(*corners, positions_, point);
        const auto uvw = thoroughly ? map.findOriginInside(kOnFace) : map.findOrigin();
        if (!uvw || !isInUnitCube(*uvw, kOnFace)) return std::nullopt;
        return found({cell, 0, toArray(*uvw), {}}, map.position(*uvw).norm());
    }
    if (thoroughly) return std::nullopt;  // The first pass solved the tetrahedra exactly.
    const Vector3d centre = centreOf(cell);
    for (Index t = 0; t < tetrahedronCount(complex_, cell); ++t) {
        const Matrix3d edges = tetrahedron(cell, t, centre).edges;
        const Vector3d uvw = solve3(edges, point - centre);
        if (uvw.allFinite() && uvw.minCoeff() >= -kOnFace && uvw.sum() <= 1 + kOnFace)
            return found({cell, t, toArray(uvw), {}},
                         (roundedProduct(edges, uvw) - (point - centre)).norm());
    }
    return std::nullopt;
}

CellPlace CellSolver::nearestPlace(CellId cell, const Vector3d& point) const {
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

/// Returns the Jacobian of a cell's map at a place.
Matrix3d CellSolver::jacobianAt(const CellPlace& place) const {
    if (const auto& corners = cornersOf(place.cell)) {
        // Puts the origin into the cell: relative to a point far away, the edges would lose digits.
        const Vector3d origin = positionOf(corners->front());
        return mapAround(*corners, positions_, origin).jacobian(Vector3d(place.uvw.data()));
    }
    return tetrahedron(place.cell, place.tetrahedron, centreOf(place.cell)).edges;
}

/// Returns the vertices of the face, edge or vertex that a place on the surface of its cell belongs
/// to.
std::vector<Index> CellSolver::supportOf(const CellPlace& place) const {
    std::vector<Index> support;
    if (const auto& corners = cornersOf(place.cell)) {
        const auto weights = Trilinear::weights(Vector3d(place.uvw.data()));
        for (std::size_t i = 0; i < 8; ++i)
            if (weights[i] > 0) support.push_back((*corners)[i]);
        return support;
    }
    // The place is on the base of its tetrahedron: the weight of the apex is 0 up to rounding.
    const auto base = tetrahedronBase(complex_, place.cell, place.tetrahedron);
    for (std::size_t i = 0; i < 3; ++i)
        if (place.uvw[i] > 0) support.push_back(base[i]);
    return support;
}

/// Returns true if a place on the surface of its cell is on the boundary of the lattice.
bool CellSolver::isOnBoundary(const CellPlace& place) const {
    const std::vector<Index> support = supportOf(place);
    const auto faces = complex_.relation(0, 2)[support.front()];
    return std::any_of(faces.begin(), faces.end(), [&](Index face) {
        if (complex_.relation(2, 3)[face].size() == 2) return false;
        const auto loop = complex_.relation(2, 0)[face];
        return std::all_of(support.begin(), support.end(),
                           [&](Index vertex) { return far::contains(loop, vertex); });
    });
}

CellSolver::NearestPlace CellSolver::nearestIn(CellId cell, const Vector3d& point) const {
    const CellPlace place = nearestPlace(cell, point);
    return {place, (positionOf(place) - point).norm()};
}

/// Continues the map along its tangent, up to a point. Returns nothing if the cell is flat.
std::optional<LocatedPoint> CellSolver::continued(const Vector3d& point,
                                                  const NearestPlace& nearest) const {
    LocatedPoint result{PointStatus::Outside, nearest.place, nearest.distance, 0};
    CellPlace& place = *result.place;
    const auto continuation =
        continueTo(point, jacobianAt(place), scale_.size, [&](const Vector3d& offset) {
            place.offset = toArray(offset);
            // Computes the position from the weights, as the deformation does.
            return weightedSum(placeWeights(complex_, place),
                               [&](Index vertex) { return positionOf(vertex); });
        });
    if (!continuation || !isSettled(continuation->position, point, scale_.size))
        return std::nullopt;
    place.offset = toArray(continuation->offset);
    result.residual = (continuation->position.sum - point).norm();
    result.away = toArray(point - positionOf(nearest.place));
    return result;
}

LocatedPoint CellSolver::settle(const Vector3d& point, const NearestPlace& nearest,
                                double tolerance) const {
    if (auto there = continued(point, nearest)) {
        if (isWithin(there->place->offset, kMaxGap)) {
            there->status = PointStatus::Inside;
            return *there;
        }
    }
    if (nearest.distance <= tolerance)
        return {PointStatus::Inside, nearest.place, nearest.distance, nearest.distance};
    return {PointStatus::Outside, {}, nearest.distance, 0};
}

LocatedPoint CellSolver::locateInGap(const Vector3d& point, CellId nearest) const {
    const NearestPlace there = nearestIn(nearest, point);
    if (there.distance > scale_.tolerance && isOnBoundary(there.place))
        return {PointStatus::Outside, {}, there.distance, 0};
    return settle(point, there, scale_.tolerance);
}

LocatedPoint CellSolver::carry(const Vector3d& point, CellId nearest) const {
    const NearestPlace there = nearestIn(nearest, point);
    return continued(point, there)
        .value_or(LocatedPoint{PointStatus::Outside, {}, there.distance, 0});
}

}  // namespace espalier::embed

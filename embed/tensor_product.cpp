// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/memory.h>
#include <espalier/base/parallel.h>
#include <espalier/embed/bind_groups.h>
#include <espalier/embed/box_least_squares.h>
#include <espalier/embed/gradient_rows.h>
#include <espalier/embed/length_unit.h>
#include <espalier/embed/place_points.h>
#include <espalier/embed/rounded_product.h>
#include <espalier/embed/row_bound.h>
#include <espalier/embed/tensor_product.h>
#include <espalier/stencils/table_builder.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <sstream>
#include <string>

namespace espalier::embed {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// How far a vertex may be from its place in the affine grid, as a fraction of the lattice's
/// diagonal. Files with six digits, as printf and iostreams write by default, have an error of 5e-6
/// in each coordinate, so a vertex is off by up to √3 · 5e-6 = 8.7e-6. If a vertex was moved by
/// hand, it is off by far more.
constexpr double kAffine = 1e-5;

/// The same as a fraction of the largest coordinate, for lattices far from the origin: √3 times
/// 6e-8, the rounding error of files in single precision.
constexpr double kSingle = 1.1e-7;

/// Smallest volume of a parallelepiped with sides of length 1: in a flatter one, local coordinates
/// would have under half the digits of a double.
constexpr double kMinVolume = 1e-8;

/// How far outside the region, in cells, rounding may put a point on its boundary: 1e-16 of its
/// coordinates divided by the size and thinness of a cell, as in CellSolver.
constexpr double kOnBoundary = 1e-10;

/// Calls body(point, vertex) for each grid point.
template <class Body>
void forEachVertex(const far::BoxGrid& grid, Body body) {
    std::size_t next = 0;
    for (Index k = 0; k <= grid.cells[2]; ++k)
        for (Index j = 0; j <= grid.cells[1]; ++j)
            for (Index i = 0; i <= grid.cells[0]; ++i)
                body(Vector3d(i, j, k), grid.vertices[next++]);
}

void checkCells(Basis basis, const std::array<Index, 3>& cells) {
    for (const Index count : cells)
        if (axisRange(basis, count).low >= axisRange(basis, count).high)
            throw Error("a B-spline lattice needs 3 cells along each axis or more: this one has " +
                        std::to_string(cells[0]) + " × " + std::to_string(cells[1]) + " × " +
                        std::to_string(cells[2]));
}

}  // namespace

TensorLattice::TensorLattice(const far::CellComplex& complex, std::span<const Point3> rest,
                             Basis basis)
    : complex_(complex),
      rest_(rest.begin(), rest.end()),
      basis_(basis),
      grid_(far::asBoxGrid(complex)),
      isAscending_(std::is_sorted(grid_.vertices.begin(), grid_.vertices.end())) {
    checkCells(basis, grid_.cells);
    checkPositions(complex, rest);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const AxisRange range = axisRange(basis, grid_.cells[axis]);
        low_[static_cast<Eigen::Index>(axis)] = range.low;
        high_[static_cast<Eigen::Index>(axis)] = range.high;
    }
    Eigen::AlignedBox3d box;
    for (const Point3& position : rest) box.extend(Vector3d(position.data()));
    size_ = box.diagonal().stableNorm();
    fitAxes();
    invertAxes();
    checkFit();
}

/// Fits the origin and the axes by least squares. All vertices count equally, so the result does
/// not depend on their numbering. On a grid, each axis has its own sum, and no system of equations
/// is needed.
void TensorLattice::fitAxes() {
    const Vector3d middle = Vector3d(grid_.cells[0], grid_.cells[1], grid_.cells[2]) / 2;
    Vector3d mean = Vector3d::Zero(), squares = Vector3d::Zero();
    forEachVertex(grid_, [&](const Vector3d&, Index vertex) { mean += restAt(vertex); });
    mean /= static_cast<double>(rest_.size());
    axes_.setZero();
    forEachVertex(grid_, [&](const Vector3d& point, Index vertex) {
        const Vector3d steps = point - middle;
        axes_ += (restAt(vertex) - mean) * steps.transpose();
        squares += steps.cwiseAbs2();
    });
    axes_ *= squares.cwiseInverse().asDiagonal();
    origin_ = mean - roundedProduct(axes_, middle);
}

/// Divides the axes by their lengths before inverting: the determinant of tiny or huge axes would
/// underflow or overflow.
void TensorLattice::invertAxes() {
    const Vector3d lengths(axes_.col(0).stableNorm(), axes_.col(1).stableNorm(),
                           axes_.col(2).stableNorm());
    const Matrix3d units = axes_ * lengths.cwiseInverse().asDiagonal();
    if (!(std::abs(units.determinant()) > kMinVolume))
        throw Error("the rest positions have no volume: they are not a parallelepiped");
    toCells_ = lengths.cwiseInverse().asDiagonal() * units.inverse();
}

void TensorLattice::checkFit() const {
    Index farthest = 0;
    double distance = 0;
    forEachVertex(grid_, [&](const Vector3d& point, Index vertex) {
        const double off = (positionAt(point) - restAt(vertex)).stableNorm();
        if (off > distance) {
            distance = off;
            farthest = vertex;
        }
    });
    double largest = 0;
    for (const Point3& position : rest_)
        for (const double coordinate : position) largest = std::max(largest, std::abs(coordinate));
    if (distance <= kAffine * size_ + kSingle * largest) return;
    std::ostringstream message;
    message << "the rest positions are not an evenly divided parallelepiped: vertex " << farthest
            << " is " << distance << " from its place in the nearest one";
    throw Error(message.str());
}

/// Returns the nearest place of the region, in cells. Clamping would be right only if the axes are
/// perpendicular.
Vector3d TensorLattice::nearestInRegion(const Vector3d& point) const {
    return nearestInBox(axes_, point - origin_, low_, high_);
}

Located<TensorPlace> TensorLattice::locate(const Point3& point, double tolerance,
                                           bool seekNearest) const {
    Row row;
    return locate(point, tolerance, seekNearest, row);
}

Located<TensorPlace> TensorLattice::locate(const Point3& position, double tolerance,
                                           bool seekNearest, Row& row) const {
    const Vector3d point(position.data());
    Located<TensorPlace> result;
    const Vector3d local = roundedProduct(toCells_, point - origin_);
    // Local coordinates of a finite point may overflow.
    if (!local.allFinite()) return result;
    Vector3d at = local.cwiseMax(low_).cwiseMin(high_);
    if ((local - at).lpNorm<Eigen::Infinity>() > kOnBoundary) {
        at = nearestInRegion(point);
        result.distance = (positionAt(at) - point).stableNorm();
    }
    const bool isInside = result.distance <= tolerance * size_;
    result.status = isInside ? PointStatus::Inside : PointStatus::Outside;
    if (!isInside && !seekNearest) return result;
    result.place = TensorPlace{toArray(at), toArray(local - at)};
    if (!isInside) result.away = toArray(point - positionAt(at));
    Vector3d back = Vector3d::Zero();
    setWeights(*result.place, row);
    for (const auto& [vertex, weight] : row.weights) back += weight * restAt(vertex);
    result.residual = (back - point).stableNorm();
    return result;
}

std::vector<VertexWeight> TensorLattice::weights(const TensorPlace& place) const {
    Row row;
    setWeights(place, row);
    return std::move(row.weights);
}

void TensorLattice::setWeights(const TensorPlace& place, Row& row) const {
    for (std::size_t axis = 0; axis < 3; ++axis)
        axisFunctions(basis_, grid_.cells[axis], place.at[axis], row.axes[axis]);
    const auto& [x, y, z] = row.axes;
    const auto& [du, dv, dw] = place.offset;
    std::vector<VertexWeight>& result = row.weights;
    result.clear();
    result.reserve(x.values.size() * y.values.size() * z.values.size());
    for (std::size_t k = 0; k < z.values.size(); ++k)
        for (std::size_t j = 0; j < y.values.size(); ++j) {
            // `factor` multiplies the derivative of x; `value` multiplies x.
            const double factor = y.values[j] * z.values[k];
            const double value =
                factor + dv * y.derivatives[j] * z.values[k] + dw * y.values[j] * z.derivatives[k];
            for (std::size_t i = 0; i < x.values.size(); ++i) {
                const double weight = x.values[i] * value + du * x.derivatives[i] * factor;
                if (weight == 0) continue;
                const Index vertex = grid_.vertexAt({x.first + static_cast<Index>(i),
                                                     y.first + static_cast<Index>(j),
                                                     z.first + static_cast<Index>(k)});
                result.push_back({vertex, weight});
            }
        }
    if (!isAscending_)
        std::sort(result.begin(), result.end(),
                  [](const VertexWeight& a, const VertexWeight& b) { return a.vertex < b.vertex; });
}

TensorEmbedding embedPoints(const TensorLattice& lattice, std::span<const Point3> points,
                            const EmbeddingOptions& options,
                            const std::function<void(Offset)>& progress) {
    const double tolerance = checkedTolerance(options.tolerance);
    return locatePoints<TensorPlace>(
        points, lattice.complex().count(0), options.outside, progress,
        [&, row = TensorLattice::Row()](const Point3& point, bool seekNearest) mutable {
            return lattice.locate(point, tolerance, seekNearest, row);
        });
}

stencils::StencilTable<double> buildDeformationTable(const TensorLattice& lattice,
                                                     const TensorEmbedding& embedding) {
    checkVertexCount(embedding.vertexCount, lattice.complex().count(0));
    // All rows are equally long; a row of a Bézier lattice contains every vertex.
    const auto& points = embedding.points;
    const bool isCarried = std::ranges::any_of(points, [](const auto& point) {
        return point.status == PointStatus::Outside && point.place;
    });
    const auto first = std::find_if(points.begin(), points.end(),
                                    [](const auto& point) { return point.place.has_value(); });
    if (first != points.end())
        requireMemory(points.size() * lattice.weights(*first->place).size() *
                          (sizeof(Index) + sizeof(double)),
                      "a table of " + std::to_string(points.size()) + " rows");
    auto table =
        stencils::buildTableInPlace(static_cast<Index>(points.size()), lattice.complex().count(0),
                                    [&](Offset from, Offset to, stencils::RowList& rows) {
                                        TensorLattice::Row row;
                                        for (Offset i = from; i < to; ++i) {
                                            row.weights.clear();
                                            if (points[i].place)
                                                lattice.setWeights(*points[i].place, row);
                                            rows.appendRow(row.weights);
                                        }
                                    });
    // Weights of the bases are between 0 and 1 in the region.
    if (isCarried) return boundRows(std::move(table));
    return table;
}

Gradients buildGradients(const TensorLattice& lattice, const TensorEmbedding& embedding) {
    checkVertexCount(embedding.vertexCount, lattice.complex().count(0));
    const far::BoxGrid& grid = lattice.grid();
    const Index vertexCount = lattice.complex().count(0);
    Gradients gradients{stencils::buildTable(vertexCount, vertexCount,
                                             [&](Index row, stencils::RowAccumulator& accumulator) {
                                                 accumulator.add(grid.vertices[row], 1);
                                             })};
    BasisPlaces& basis = gradients.basis;
    basis.basis = lattice.basis();
    basis.cells = grid.cells;
    for (std::size_t i = 0; i < embedding.points.size(); ++i)
        if (const auto& place = embedding.points[i].place)
            basis.places.push_back({static_cast<Index>(i), place->at});
    return gradients;
}

BoundRows<> bindPoints(const TensorLattice& lattice, std::span<const Point3> points,
                       const BindingOptions& options) {
    const TensorEmbedding embedding =
        embedPoints(lattice, points, options.embedding, options.progress);
    BoundRows<> result;
    result.table = buildDeformationTable(lattice, embedding);
    if (options.gradients) {
        result.gradients =
            withoutPoints(buildGradients(lattice, embedding), result.table.emptyRows());
    }
    result.largestResidual = embedding.largestResidual(result.table);
    addCarried(embedding.points, result.carried);
    result.statuses.reserve(points.size());
    for (const auto& point : embedding.points) result.statuses.push_back(point.status);
    return result;
}

void bindInGroups(const TensorLattice& lattice, std::span<const Point3> points,
                  const BindingOptions& options, RowSink sink) {
    // A row of a B-spline lattice takes 0.8 kB; a row of a Bézier lattice has every vertex.
    constexpr Offset kPointsAtOnce = 1 << 10;
    checkedTolerance(options.embedding.tolerance);
    checkPointCount(points);
    const BindingOptions ofGroup = {1, withoutRefusal(options.embedding), options.gradients};
    std::atomic<Offset> done = 0;
    parallelFor(std::ssize(points), kPointsAtOnce, [&](Offset first, Offset last) {
        std::vector<Index> numbers(last - first);
        std::iota(numbers.begin(), numbers.end(), static_cast<Index>(first));
        sink(numbers, bindPoints(lattice, points.subspan(first, last - first), ofGroup));
        if (options.progress) options.progress(done += last - first);
    });
}

}  // namespace espalier::embed

// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/parallel.h>
#include <espalier/embed/gradient_rows.h>
#include <espalier/stencils/table_builder.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

namespace espalier::embed {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Returns (T X)⁻¹ for the directions T of one point, rows `first` to first + 2, and the rest X.
Matrix3d inverseAtRest(const stencils::StencilTable<double>& directions, Index first,
                       std::span<const Point3> rest) {
    Matrix3d atRest = Matrix3d::Zero();
    Vector3d sizes = Vector3d::Zero();
    for (Index row = 0; row < 3; ++row) {
        const auto columns = directions.columns(first + row);
        const auto weights = directions.weights(first + row);
        if (columns.empty()) continue;
        // Rows sum to 0, so that the origin may be a nearby vertex: coordinates are then small.
        const Vector3d origin(rest[columns.front()].data());
        for (std::size_t k = 0; k < columns.size(); ++k) {
            const Vector3d term = weights[k] * (Vector3d(rest[columns[k]].data()) - origin);
            atRest.row(row) += term.transpose();
            sizes[row] += term.norm();
        }
    }
    return inverseOf(atRest, sizes);
}

/// Returns the numbers of the rows of points.
std::vector<Index> tripled(std::span<const Index> points) {
    std::vector<Index> rows;
    rows.reserve(3 * points.size());
    for (const Index point : points)
        for (Index axis = 0; axis < 3; ++axis) rows.push_back(3 * point + axis);
    return rows;
}

/// Sorts the points with rows.
void sortPoints(Gradients& gradients) {
    std::vector<Index>& points = gradients.points;
    if (std::is_sorted(points.begin(), points.end())) return;
    std::vector<Index> order(points.size());
    std::iota(order.begin(), order.end(), Index{0});
    std::sort(order.begin(), order.end(), [&](Index a, Index b) { return points[a] < points[b]; });
    gradients.rows = stencils::selectRows(gradients.rows, tripled(order));
    std::sort(points.begin(), points.end());
}

/// Sorts places by their points.
/// \tparam Place CellPlaces::Place or SplinePlaces::Place
template <class Place>
void sortPlaces(std::vector<Place>& places) {
    const auto isBefore = [](const Place& a, const Place& b) { return a.point < b.point; };
    if (!std::is_sorted(places.begin(), places.end(), isBefore))
        std::sort(places.begin(), places.end(), isBefore);
}

/// Appends cells and the places in them, or patches and the places in them.
/// \param shift is added to the numbers of vertices
/// \param numberOf returns the number in a place of its cell or patch
template <class Shape, class Place, class NumberOf>
void appendPlaces(const std::vector<Shape>& shapes, const std::vector<Place>& places, Index shift,
                  NumberOf numberOf, std::vector<Shape>& allShapes, std::vector<Place>& allPlaces) {
    const auto before = static_cast<Index>(allShapes.size());
    for (Shape shape : shapes) {
        for (Index& vertex : shape)
            if (vertex != kMaxIndex) vertex += shift;
        allShapes.push_back(shape);
    }
    for (Place place : places) {
        numberOf(place) += before;
        allPlaces.push_back(place);
    }
}

/// Rows of several tables, one table after the other.
class StackedRows {
public:
    Offset rowCount() const { return std::ssize(offsets_) - 1; }

    /// \param shift is added to the columns
    void append(const stencils::StencilTable<double>& table, Index shift) {
        const Offset before = offsets_.back();
        for (Index row = 0; row < table.rowCount(); ++row)
            offsets_.push_back(before + table.offsets()[row + 1]);
        for (const Index column : table.columns()) columns_.push_back(column + shift);
        weights_.insert(weights_.end(), table.weights().begin(), table.weights().end());
    }

    stencils::StencilTable<double> take(Index columnCount) {
        return {stencils::Trusted{}, columnCount, std::move(offsets_), std::move(columns_),
                std::move(weights_)};
    }

private:
    Array<Offset> offsets_ = {0};
    Array<Index> columns_;
    Array<double> weights_;
};

}  // namespace

Matrix3d inverseOf(const Matrix3d& directions, const Vector3d& sizes) {
    // The rounding of T X is about 1e-16 of the sum of the sizes of its terms. Where T X is flatter
    // than this, F would have at most six correct digits.
    constexpr double kFlat = 1e-10;
    // Scale each direction to unit length: derivatives of deep levels are very small.
    const Matrix3d unit = sizes.cwiseInverse().asDiagonal() * directions;
    if (!(std::abs(unit.determinant()) > kFlat))
        return Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN());
    return unit.inverse() * sizes.cwiseInverse().asDiagonal();
}

bool areFlat(const Matrix3d& directions) {
    return !inverseOf(directions, directions.rowwise().norm()).allFinite();
}

stencils::StencilTable<double> gradientRows(const stencils::StencilTable<double>& directions,
                                            std::span<const Point3> rest, double scale) {
    const Index pointCount = directions.rowCount() / 3;
    std::vector<Matrix3d> inverses(pointCount);
    parallelFor(pointCount, 1024, [&](Offset first, Offset last) {
        for (Offset i = first; i < last; ++i)
            inverses[i] = scale * inverseAtRest(directions, static_cast<Index>(3 * i), rest);
    });
    return stencils::buildTable(directions.rowCount(), directions.columnCount(),
                                [&](Index row, stencils::RowAccumulator& accumulator) {
                                    const Index point = row / 3;
                                    const Matrix3d& inverse = inverses[point];
                                    if (!inverse.allFinite()) return;
                                    for (Index by = 0; by < 3; ++by) {
                                        const double factor = inverse(row % 3, by);
                                        const auto columns = directions.columns(3 * point + by);
                                        const auto weights = directions.weights(3 * point + by);
                                        for (std::size_t k = 0; k < columns.size(); ++k)
                                            accumulator.add(columns[k], factor * weights[k]);
                                    }
                                    accumulator.makeSumZero();
                                });
}

stencils::StencilTable<double> baseVertexRows(Index columnCount) {
    return stencils::buildTable(
        columnCount, columnCount,
        [](Index row, stencils::RowAccumulator& accumulator) { accumulator.add(row, 1); });
}

Gradients gradientsOfRows(const stencils::StencilTable<double>& rows) {
    Gradients gradients{baseVertexRows(rows.columnCount())};
    for (Index point = 0; 3 * point < rows.rowCount(); ++point)
        if (rows.offsets()[3 * point] != rows.offsets()[3 * point + 3])
            gradients.points.push_back(point);
    gradients.rows = stencils::selectRows(rows, tripled(gradients.points));
    return gradients;
}

Gradients withoutPoints(Gradients gradients, std::span<const Index> points) {
    if (points.empty()) return gradients;
    const auto isOne = [&](Index point) { return std::ranges::binary_search(points, point); };
    auto& [vertices, own, rows, cells, splines, basis] = gradients;
    std::vector<Index> left, numbers;
    for (std::size_t i = 0; i < own.size(); ++i)
        if (!isOne(own[i])) {
            left.push_back(static_cast<Index>(i));
            numbers.push_back(own[i]);
        }
    if (left.size() < own.size()) {
        rows = stencils::selectRows(rows, tripled(left));
        own = std::move(numbers);
    }
    const auto isGone = [&](const auto& place) { return isOne(place.point); };
    std::erase_if(cells.places, isGone);
    std::erase_if(splines.places, isGone);
    std::erase_if(basis.places, isGone);
    return gradients;
}

Gradients renumbered(Gradients gradients, std::span<const Index> numbers) {
    auto& [vertices, points, rows, cells, splines, basis] = gradients;
    for (Index& point : points) point = numbers[point];
    sortPoints(gradients);
    const auto renumber = [&](auto& places) {
        for (auto& place : places) place.point = numbers[place.point];
        sortPlaces(places);
    };
    renumber(cells.places);
    renumber(splines.places);
    renumber(basis.places);
    return gradients;
}

Gradients merged(std::vector<Gradients>& parts, Index columnCount) {
    Offset vertexCount = 0;
    for (const Gradients& part : parts) vertexCount += part.vertices.rowCount();
    if (vertexCount > kMaxIndex)
        throw Error("the gradients would have " + std::to_string(vertexCount) +
                    " vertices, more than an index can count; bind fewer points at once");
    Gradients all;
    StackedRows vertices, rows;
    for (Gradients& part : parts) {
        const auto vertexShift = static_cast<Index>(vertices.rowCount());
        vertices.append(part.vertices, 0);
        rows.append(part.rows, vertexShift);
        all.points.insert(all.points.end(), part.points.begin(), part.points.end());
        appendPlaces(
            part.cells.cells, part.cells.places, vertexShift,
            [](CellPlaces::Place& place) -> Index& { return place.cell; }, all.cells.cells,
            all.cells.places);
        appendPlaces(
            part.splines.patches, part.splines.places, vertexShift,
            [](SplinePlaces::Place& place) -> Index& { return place.patch; }, all.splines.patches,
            all.splines.places);
        if (!part.splines.places.empty()) all.splines.spacing = part.splines.spacing;
        part = {};
    }
    all.rows = rows.take(static_cast<Index>(vertices.rowCount()));
    all.vertices = vertices.take(columnCount);
    sortPoints(all);
    sortPlaces(all.cells.places);
    sortPlaces(all.splines.places);
    return all;
}

}  // namespace espalier::embed

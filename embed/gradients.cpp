// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/parallel.h>
#include <espalier/embed/gradients.h>
#include <espalier/embed/length_unit.h>
#include <espalier/embed/tricubic_patch.h>
#include <espalier/stencils/table_builder.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace espalier::embed {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Returns the inverse of T X; NaN where T X spans no volume.
/// \param sizes for each row, the sum of the sizes of its terms
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

/// The vertices of a patch in two sets of positions, as columns: at rest, and their displacements.
/// Both relative to one vertex, so that differences of large coordinates do not round, and in
/// units, so that products do not underflow.
using PatchPositions = Eigen::Matrix<double, 6, 64>;

PatchPositions positionsOf(const SplinePlaces::Patch& patch, const LengthUnit& unit,
                           std::span<const Point3> rest, std::span<const Point3> displacements) {
    const Index origin = patch[TricubicPatch::kCorner];
    PatchPositions result = PatchPositions::Zero();  // Vertices that do not exist have no weight.
    for (Eigen::Index k = 0; k < 64; ++k) {
        const Index vertex = patch[static_cast<std::size_t>(k)];
        if (vertex == kMaxIndex) continue;
        for (std::size_t c = 0; c < 3; ++c) {
            const auto row = static_cast<Eigen::Index>(c);
            result(row, k) = unit.toUnits(rest[vertex][c] - rest[origin][c]);
            result(row + 3, k) = unit.toUnits(displacements[vertex][c] - displacements[origin][c]);
        }
    }
    return result;
}

/// Values and first derivatives of the weights along each axis.
struct PlaceWeights {
    TricubicPatch::AxisWeights values, slopes;
};

/// At a place, the derivatives of both sets of positions by u, v and w, and their values, as
/// columns.
using PatchValues = Eigen::Matrix<double, 6, 4>;

PatchValues valuesAt(const PatchPositions& positions, const PlaceWeights& at) {
    using Vector = Eigen::Matrix<double, 6, 1>;
    PatchValues result = PatchValues::Zero();
    for (std::size_t k = 0; k < 4; ++k) {
        Vector alongU = Vector::Zero(), alongV = Vector::Zero(), value = Vector::Zero();
        for (std::size_t j = 0; j < 4; ++j) {
            const auto line = positions.middleCols<4>(static_cast<Eigen::Index>(4 * j + 16 * k));
            const Vector sum = line * Eigen::Vector4d(at.values[0].data());
            alongU += at.values[1][j] * (line * Eigen::Vector4d(at.slopes[0].data()));
            alongV += at.slopes[1][j] * sum;
            value += at.values[1][j] * sum;
        }
        result.col(0) += at.values[2][k] * alongU;
        result.col(1) += at.values[2][k] * alongV;
        result.col(2) += at.slopes[2][k] * value;
        result.col(3) += at.values[2][k] * value;
    }
    return result;
}

/// The points that have a place, patch by patch.
struct PointsOfPatches {
    std::vector<Offset> offsets;
    std::vector<Index> points;

    explicit PointsOfPatches(const SplinePlaces& splines) : offsets(splines.patches.size() + 1) {
        for (const auto& place : splines.places)
            if (place.patch != kMaxIndex) ++offsets[place.patch + 1];
        std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
        points.resize(offsets.back());
        std::vector<Offset> next(offsets.begin(), offsets.end() - 1);
        for (std::size_t i = 0; i < splines.places.size(); ++i)
            if (const Index patch = splines.places[i].patch; patch != kMaxIndex)
                points[next[patch]++] = static_cast<Index>(i);
    }
};

/// Calls use(point, values) for each point that has a place, from several threads.
template <class Use>
void forEachPlace(const SplinePlaces& splines, std::span<const Point3> rest,
                  std::span<const Point3> displacements, Use use) {
    const PointsOfPatches of(splines);
    const LengthUnit unit(rest);
    const std::array<int, 3> values = {0, 0, 0};
    parallelFor(std::ssize(splines.patches), 16, [&](Offset first, Offset last) {
        for (Offset p = first; p < last; ++p) {
            const TricubicPatch patch(splines.patches[p]);
            const PatchPositions positions =
                positionsOf(splines.patches[p], unit, rest, displacements);
            for (Offset i = of.offsets[p]; i < of.offsets[p + 1]; ++i) {
                const Index point = of.points[i];
                const Vector3d uvw(splines.places[point].uvw.data());
                const PlaceWeights weights{patch.axisWeights(uvw, splines.spacing, values),
                                           patch.axisWeights(uvw, splines.spacing, {1, 1, 1})};
                use(point, valuesAt(positions, weights));
            }
        }
    });
}

/// Returns the inverse of the derivatives at rest; NaN where they span no volume.
Matrix3d inverseAtRest(const PatchValues& values) {
    const Matrix3d atRest = values.topLeftCorner<3, 3>().transpose();
    return inverseOf(atRest, atRest.rowwise().norm());
}

}  // namespace

Index Gradients::identityCount() const {
    Index count = 0;
    for (const Index point : tables[0].emptyRows())
        count += splines.places.empty() || splines.places[point].patch == kMaxIndex;
    return count;
}

void Gradients::check() const {
    for (const auto& table : tables)
        if (table.rowCount() != rowCount() || table.columnCount() != columnCount())
            throw Error("the three tables of the gradients have different shapes");
    const auto& [spacing, patches, places, weights] = splines;
    if (!(spacing >= 0 && spacing <= 1))
        throw Error(concat("a spacing of ", spacing, " in the gradients; expected 0 to 1"));
    if (!places.empty() && std::ssize(places) != rowCount())
        throw Error(concat("gradients of ", rowCount(), " points have ", places.size(), " places"));
    for (std::size_t i = 0; i < places.size(); ++i) {
        const auto& [uvw, patch] = places[i];
        if (patch == kMaxIndex) continue;
        if (patch < 0 || patch >= std::ssize(patches))
            throw Error(concat("the gradient of point ", i, " is in patch ", patch, " of ",
                               patches.size()));
        for (const double coordinate : uvw)
            if (!std::isfinite(coordinate))
                throw Error(concat("the place of point ", i, " in its patch is not finite"));
    }
    for (const auto& patch : patches) TricubicPatch::checkVertices(patch, columnCount());
    if (!weights.empty() && weights.size() != places.size())
        throw Error(
            concat(places.size(), " places in the gradients have ", weights.size(), " weights"));
    for (std::size_t i = 0; i < weights.size(); ++i) {
        const auto& [value, slope] = weights[i];
        if (!(value >= 0 && value <= 1) || !Vector3d(slope.data()).allFinite())
            throw Error(concat("the weight of point ", i, " is ", value, " with the slope ",
                               slope[0], " ", slope[1], " ", slope[2],
                               "; expected 0 to 1, and finite numbers"));
    }
}

void addSplineGradients(const SplinePlaces& splines, std::span<const Point3> rest,
                        std::span<const Point3> displacements,
                        std::span<DeformationGradient> sums) {
    const LengthUnit unit(rest);
    forEachPlace(splines, rest, displacements, [&](Index point, const PatchValues& values) {
        const Matrix3d inverse = inverseAtRest(values);
        if (!inverse.allFinite()) return;
        // Fᵀ − 1 = (T X)⁻¹ T (x − X)
        Matrix3d added = inverse * values.bottomLeftCorner<3, 3>().transpose();
        if (!splines.weights.empty()) {
            // The displacement d is relative to the vertex of positionsOf().
            const auto& patch = splines.patches[splines.places[point].patch];
            const auto& [weight, slope] = splines.weights[point];
            Vector3d d(displacements[patch[TricubicPatch::kCorner]].data());
            for (Eigen::Index c = 0; c < 3; ++c) d[c] += unit.fromUnits(values(3 + c, 3));
            added = weight * added + Vector3d(slope.data()) * d.transpose();
        }
        for (Eigen::Index i = 0; i < 3; ++i)
            for (Eigen::Index j = 0; j < 3; ++j)
                sums[point][static_cast<std::size_t>(3 * i + j)] += added(j, i);
    });
}

GradientTables gradientTables(const Gradients& gradients, std::span<const Point3> rest) {
    const SplinePlaces& splines = gradients.splines;
    if (splines.places.empty()) return gradients.tables;
    const std::vector<Point3> none(rest.size());
    const double perLength = LengthUnit(rest).toUnits(1.0);  // Derivatives are in units.
    std::vector<Matrix3d> inverses(splines.places.size());
    forEachPlace(splines, rest, none, [&](Index point, const PatchValues& values) {
        inverses[point] = perLength * inverseAtRest(values);
    });
    std::vector<TricubicPatch> patches(splines.patches.begin(), splines.patches.end());
    GradientTables result;
    for (std::size_t axis = 0; axis < 3; ++axis)
        result[axis] = stencils::buildTable(
            gradients.rowCount(), gradients.columnCount(),
            [&](Index point, stencils::RowAccumulator& accumulator) {
                const SplinePlaces::Place& place = splines.places[point];
                if (place.patch == kMaxIndex) {
                    const auto columns = gradients.tables[axis].columns(point);
                    const auto weights = gradients.tables[axis].weights(point);
                    for (std::size_t k = 0; k < columns.size(); ++k)
                        accumulator.add(columns[k], weights[k]);
                    return;
                }
                if (!inverses[point].allFinite()) return;
                const PointWeight follows =
                    splines.weights.empty() ? PointWeight{} : splines.weights[point];
                const auto add = [&](const std::array<int, 3>& orders, double factor) {
                    const auto along = patches[place.patch].axisWeights(Vector3d(place.uvw.data()),
                                                                        splines.spacing, orders);
                    std::array<Index, 64> vertices;
                    std::array<double, 64> weights;
                    patches[place.patch].writeRow(along, vertices.data(), weights.data());
                    const Index length = TricubicPatch::rowLength(along);
                    for (Index k = 0; k < length; ++k)
                        accumulator.add(vertices[k], factor * weights[k]);
                };
                for (std::size_t by = 0; by < 3; ++by) {
                    std::array<int, 3> orders = {};
                    orders[by] = 1;
                    add(orders, follows.value * inverses[point](static_cast<Eigen::Index>(axis),
                                                                static_cast<Eigen::Index>(by)));
                }
                accumulator.makeSumZero();
                if (follows.slope[axis] != 0) add({}, follows.slope[axis]);
            });
    return result;
}

GradientTables gradientsOf(const stencils::StencilTable<double>& directions,
                           std::span<const Point3> rest, double scale) {
    const Index pointCount = directions.rowCount() / 3;
    std::vector<Matrix3d> inverses(pointCount);
    parallelFor(pointCount, 1024, [&](Offset first, Offset last) {
        for (Offset i = first; i < last; ++i)
            inverses[i] = scale * inverseAtRest(directions, static_cast<Index>(3 * i), rest);
    });
    GradientTables gradients;
    for (std::size_t axis = 0; axis < 3; ++axis)
        gradients[axis] = stencils::buildTable(
            pointCount, directions.columnCount(),
            [&](Index point, stencils::RowAccumulator& accumulator) {
                const Matrix3d& inverse = inverses[point];
                if (!inverse.allFinite()) return;
                for (Index row = 0; row < 3; ++row) {
                    const double factor = inverse(static_cast<Eigen::Index>(axis), row);
                    const auto columns = directions.columns(3 * point + row);
                    const auto weights = directions.weights(3 * point + row);
                    for (std::size_t k = 0; k < columns.size(); ++k)
                        accumulator.add(columns[k], factor * weights[k]);
                }
                accumulator.makeSumZero();
            });
    return gradients;
}

}  // namespace espalier::embed

// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/parallel.h>
#include <espalier/embed/gradient_rows.h>
#include <espalier/embed/gradients.h>
#include <espalier/embed/length_unit.h>
#include <espalier/embed/tricubic_patch.h>
#include <espalier/embed/trilinear.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/table_builder.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace espalier::embed {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

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

/// The derivatives of both sets of positions by u, v and w, as columns.
using PatchDerivatives = Eigen::Matrix<double, 6, 3>;

PatchDerivatives derivativesAt(const PatchPositions& positions, const PlaceWeights& at) {
    using Vector = Eigen::Matrix<double, 6, 1>;
    PatchDerivatives result = PatchDerivatives::Zero();
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

/// Calls use(point, derivatives) for each point that has a place, from several threads.
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
                use(point, derivativesAt(positions, weights));
            }
        }
    });
}

/// Returns the inverse of the derivatives at rest; NaN where they span no volume.
Matrix3d inverseAtRest(const PatchDerivatives& derivatives) {
    const Matrix3d atRest = derivatives.topRows<3>().transpose();
    return inverseOf(atRest, atRest.rowwise().norm());
}

/// The inverses and derivatives of the maps of cells at the places of points, for one pose.
class CellMaps {
public:
    /// \param displacements may be empty, if only inverses are needed
    CellMaps(const Gradients& gradients, std::span<const Point3> rest,
             std::span<const Point3> displacements)
        : cells_(gradients.cells) {
        if (cells_.places.empty()) return;
        const LengthUnit unit(rest);
        // Rows sum to 1, so that the origin may be a vertex of the lattice: differences of large
        // coordinates do not round then.
        const auto ofVertices = [&](std::span<const Point3> of) {
            std::vector<Point3> relative(of.size());
            for (std::size_t v = 0; v < of.size(); ++v)
                for (std::size_t c = 0; c < 3; ++c)
                    relative[v][c] = unit.toUnits(of[v][c] - of.front()[c]);
            return stencils::applyLevelTable(gradients.vertices, relative);
        };
        rest_ = ofVertices(rest);
        if (!displacements.empty()) displaced_ = ofVertices(displacements);
    }

    /// Returns the weights of the corners in the derivatives by u, v and w.
    static std::array<Trilinear::Weights, 3> weightsAt(const CellPlaces::Place& place) {
        return Trilinear::weightDerivatives(Vector3d(place.uvw.data()));
    }

    /// Returns the inverse of the derivatives at rest, which are rows; NaN if the cell is flat.
    Matrix3d inverse(const CellPlaces::Place& place,
                     const std::array<Trilinear::Weights, 3>& weights) const {
        const Matrix3d atRest = derivatives(place, weights, rest_);
        return inverseOf(atRest, atRest.rowwise().norm());
    }

    /// Returns the derivatives of the displacements, as rows.
    Matrix3d displaced(const CellPlaces::Place& place,
                       const std::array<Trilinear::Weights, 3>& weights) const {
        return derivatives(place, weights, displaced_);
    }

private:
    Matrix3d derivatives(const CellPlaces::Place& place,
                         const std::array<Trilinear::Weights, 3>& weights,
                         const std::vector<Point3>& positions) const {
        Matrix3d result = Matrix3d::Zero();
        for (std::size_t corner = 0; corner < 8; ++corner) {
            const Eigen::RowVector3d at(positions[cells_.cells[place.cell][corner]].data());
            for (std::size_t axis = 0; axis < 3; ++axis)
                result.row(static_cast<Eigen::Index>(axis)) += weights[axis][corner] * at;
        }
        return result;
    }

    const CellPlaces& cells_;
    std::vector<Point3> rest_, displaced_;  ///< of the vertices, in units
};

/// Adds a matrix, given as its transpose.
void addTransposed(const Matrix3d& added, DeformationGradient& sum) {
    for (Eigen::Index i = 0; i < 3; ++i)
        for (Eigen::Index j = 0; j < 3; ++j)
            sum[static_cast<std::size_t>(3 * i + j)] += added(j, i);
}

/// Returns rows for the points with rows, and for those in cells: three for each of all points.
stencils::StencilTable<double> rowsOverVertices(const Gradients& gradients,
                                                std::span<const Point3> rest, Index pointCount) {
    const auto& [vertices, points, rows, cells, splines] = gradients;
    constexpr Index kNone = -1;
    std::vector<Index> rowOf(pointCount, kNone), placeOf(pointCount, kNone);
    for (std::size_t i = 0; i < points.size(); ++i) rowOf[points[i]] = static_cast<Index>(i);
    for (std::size_t i = 0; i < cells.places.size(); ++i)
        placeOf[cells.places[i].point] = static_cast<Index>(i);
    const double perLength = LengthUnit(rest).toUnits(1.0);  // Derivatives are in units.
    const CellMaps maps(gradients, rest, {});
    const auto& ofPoints = rows;  // clang 14 captures no structured binding
    const auto& ofCells = cells;
    return stencils::buildTable(
        3 * pointCount, vertices.rowCount(), [&](Index row, stencils::RowAccumulator& accumulator) {
            const Index point = row / 3;
            if (rowOf[point] != kNone) {
                const Index own = 3 * rowOf[point] + row % 3;
                for (std::size_t k = 0; k < ofPoints.columns(own).size(); ++k)
                    accumulator.add(ofPoints.columns(own)[k], ofPoints.weights(own)[k]);
            }
            if (placeOf[point] == kNone) return;
            const CellPlaces::Place& place = ofCells.places[placeOf[point]];
            const auto weights = CellMaps::weightsAt(place);
            const Matrix3d inverse = perLength * maps.inverse(place, weights);
            if (!inverse.allFinite()) return;
            for (std::size_t by = 0; by < 3; ++by)
                for (std::size_t corner = 0; corner < 8; ++corner)
                    accumulator.add(
                        ofCells.cells[place.cell][corner],
                        inverse(row % 3, static_cast<Eigen::Index>(by)) * weights[by][corner]);
            accumulator.makeSumZero();
        });
}

}  // namespace

Index Gradients::identityCount(Index pointCount) const {
    const auto ofSplines = std::ranges::count_if(
        splines.places, [](const auto& place) { return place.patch != kMaxIndex; });
    return static_cast<Index>(pointCount - std::ssize(points) - std::ssize(cells.places) -
                              ofSplines);
}

void Gradients::check(Index pointCount) const {
    if (rows.rowCount() != 3 * std::ssize(points) ||
        (!points.empty() && rows.columnCount() != vertices.rowCount()))
        throw Error(concat("gradients of ", points.size(), " points have ", rows.rowCount(),
                           " rows over ", rows.columnCount(), " vertices, and ",
                           vertices.rowCount(), " rows of vertices"));
    std::vector<bool> isKnown(pointCount);
    const auto take = [&](Index point) {
        if (point < 0 || point >= pointCount)
            throw Error(concat("gradients of the point ", point, "; there are ", pointCount));
        if (isKnown[point]) throw Error(concat("the point ", point, " has gradients twice"));
        isKnown[point] = true;
    };
    const auto checkUvw = [](Index point, const std::array<double, 3>& uvw) {
        for (const double coordinate : uvw)
            if (!std::isfinite(coordinate))
                throw Error(concat("the place of point ", point, " in its cell is not finite"));
    };
    for (const Index point : points) take(point);
    for (const auto& [point, cell, uvw] : cells.places) {
        take(point);
        checkUvw(point, uvw);
        if (cell < 0 || cell >= std::ssize(cells.cells))
            throw Error(concat("the gradient of point ", point, " is in cell ", cell, " of ",
                               cells.cells.size()));
    }
    for (const CellPlaces::Cell& cell : cells.cells)
        for (const Index vertex : cell)
            if (vertex < 0 || vertex >= vertices.rowCount())
                throw Error(concat("a cell of the gradients has vertex ", vertex, "; there are ",
                                   vertices.rowCount()));
    const auto& [spacing, patches, places] = splines;
    if (!(spacing >= 0 && spacing <= 1))
        throw Error(concat("a spacing of ", spacing, " in the gradients; expected 0 to 1"));
    if (!places.empty() && std::ssize(places) != pointCount)
        throw Error(concat("gradients of ", pointCount, " points have ", places.size(), " places"));
    for (std::size_t i = 0; i < places.size(); ++i) {
        const auto& [uvw, patch] = places[i];
        if (patch == kMaxIndex) continue;
        take(static_cast<Index>(i));
        if (patch < 0 || patch >= std::ssize(patches))
            throw Error(concat("the gradient of point ", i, " is in patch ", patch, " of ",
                               patches.size()));
        checkUvw(static_cast<Index>(i), uvw);
    }
    for (const auto& patch : patches) TricubicPatch::checkVertices(patch, columnCount());
}

void addGradients(const Gradients& gradients, std::span<const Point3> rest,
                  std::span<const Point3> displacements, std::span<DeformationGradient> sums) {
    const auto& [vertices, points, rows, cells, splines] = gradients;
    if (!points.empty()) {
        const auto columns =
            stencils::applyLevelTable(rows, stencils::applyLevelTable(vertices, displacements));
        for (std::size_t row = 0; row < columns.size(); ++row)
            for (std::size_t i = 0; i < 3; ++i)
                sums[points[row / 3]][3 * i + row % 3] += columns[row][i];
    }
    const CellMaps maps(gradients, rest, displacements);
    const std::span<const CellPlaces::Place> places(cells.places);
    parallelFor(std::ssize(places), 1024, [&](Offset first, Offset last) {
        for (const CellPlaces::Place& place : places.subspan(first, last - first)) {
            const auto weights = CellMaps::weightsAt(place);
            const Matrix3d inverse = maps.inverse(place, weights);
            if (inverse.allFinite())
                addTransposed(inverse * maps.displaced(place, weights), sums[place.point]);
        }
    });
    forEachPlace(
        splines, rest, displacements, [&](Index point, const PatchDerivatives& derivatives) {
            const Matrix3d inverse = inverseAtRest(derivatives);
            // Fᵀ − 1 = (T X)⁻¹ T (x − X)
            if (inverse.allFinite())
                addTransposed(inverse * derivatives.bottomRows<3>().transpose(), sums[point]);
        });
}

GradientTables gradientTables(const Gradients& gradients, std::span<const Point3> rest,
                              Index pointCount) {
    const SplinePlaces& splines = gradients.splines;
    const auto rows =
        stencils::multiply(rowsOverVertices(gradients, rest, pointCount), gradients.vertices);
    const std::vector<Point3> none(rest.size());
    const double perLength = LengthUnit(rest).toUnits(1.0);  // Derivatives are in units.
    std::vector<Matrix3d> inverses(splines.places.size());
    forEachPlace(splines, rest, none, [&](Index point, const PatchDerivatives& derivatives) {
        inverses[point] = perLength * inverseAtRest(derivatives);
    });
    std::vector<TricubicPatch> patches(splines.patches.begin(), splines.patches.end());
    GradientTables result;
    for (std::size_t axis = 0; axis < 3; ++axis)
        result[axis] = stencils::buildTable(
            pointCount, gradients.columnCount(),
            [&](Index point, stencils::RowAccumulator& accumulator) {
                const Index row = 3 * point + static_cast<Index>(axis);
                for (std::size_t k = 0; k < rows.columns(row).size(); ++k)
                    accumulator.add(rows.columns(row)[k], rows.weights(row)[k]);
                const bool hasPlace =
                    !splines.places.empty() && splines.places[point].patch != kMaxIndex;
                if (hasPlace && inverses[point].allFinite()) {
                    const SplinePlaces::Place& place = splines.places[point];
                    const TricubicPatch& patch = patches[place.patch];
                    for (std::size_t by = 0; by < 3; ++by) {
                        const double factor = inverses[point](static_cast<Eigen::Index>(axis),
                                                              static_cast<Eigen::Index>(by));
                        std::array<int, 3> orders = {};
                        orders[by] = 1;
                        const auto along =
                            patch.axisWeights(Vector3d(place.uvw.data()), splines.spacing, orders);
                        std::array<Index, 64> vertices;
                        std::array<double, 64> weights;
                        patch.writeRow(along, vertices.data(), weights.data());
                        const Index length = TricubicPatch::rowLength(along);
                        for (Index k = 0; k < length; ++k)
                            accumulator.add(vertices[k], factor * weights[k]);
                    }
                }
                accumulator.makeSumZero();
            });
    return result;
}

}  // namespace espalier::embed

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

/// Returns (T X)⁻¹ for the derivatives at rest, as rows; NaN where they span no volume.
Matrix3d inverseAtRest(const Matrix3d& atRest) {
    return inverseOf(atRest, atRest.rowwise().norm());
}

/// The vertices of the gradients at rest, and their displacements in a pose, in units. Both are
/// relative to one vertex of the lattice, so that differences of large coordinates do not round.
/// (The rows of the vertices sum to 1.)
struct MovedVertices {
    std::vector<Point3> rest, displaced;

    /// Empty if no place needs the vertices.
    /// \param displacements of the base; empty if only the rest is needed
    MovedVertices(const Gradients& gradients, std::span<const Point3> ofBase,
                  std::span<const Point3> displacements) {
        if (gradients.cells.places.empty() && gradients.splines.places.empty() &&
            gradients.basis.places.empty())
            return;
        const LengthUnit unit(ofBase);
        const auto ofVertices = [&](std::span<const Point3> of) {
            std::vector<Point3> relative(of.size());
            for (std::size_t v = 0; v < of.size(); ++v)
                for (std::size_t c = 0; c < 3; ++c)
                    relative[v][c] = unit.toUnits(of[v][c] - of.front()[c]);
            return stencils::applyLevelTable(gradients.vertices, relative);
        };
        rest = ofVertices(ofBase);
        displaced =
            displacements.empty() ? std::vector<Point3>(rest.size()) : ofVertices(displacements);
    }
};

/// The vertices of a patch as columns: at rest, and their displacements.
using PatchPositions = Eigen::Matrix<double, 6, 64>;

PatchPositions positionsOf(const SplinePlaces::Patch& patch, const MovedVertices& vertices) {
    const Index origin = patch[TricubicPatch::kCorner];
    PatchPositions result = PatchPositions::Zero();  // Vertices that do not exist have no weight.
    for (Eigen::Index k = 0; k < 64; ++k) {
        const Index vertex = patch[static_cast<std::size_t>(k)];
        if (vertex == kMaxIndex) continue;
        for (std::size_t c = 0; c < 3; ++c) {
            const auto row = static_cast<Eigen::Index>(c);
            result(row, k) = vertices.rest[vertex][c] - vertices.rest[origin][c];
            result(row + 3, k) = vertices.displaced[vertex][c] - vertices.displaced[origin][c];
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

/// The numbers of the places in splines, patch by patch.
struct PlacesOfPatches {
    std::vector<Offset> offsets;
    std::vector<Index> places;

    explicit PlacesOfPatches(const SplinePlaces& splines)
        : offsets(splines.patches.size() + 1), places(splines.places.size()) {
        for (const auto& place : splines.places) ++offsets[place.patch + 1];
        std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
        std::vector<Offset> next(offsets.begin(), offsets.end() - 1);
        for (std::size_t i = 0; i < splines.places.size(); ++i)
            places[next[splines.places[i].patch]++] = static_cast<Index>(i);
    }
};

/// Calls use(i, derivatives) for each place i in splines, from several threads.
template <class Use>
void forEachPlace(const SplinePlaces& splines, const MovedVertices& vertices, Use use) {
    const PlacesOfPatches of(splines);
    const std::array<int, 3> values = {0, 0, 0};
    parallelFor(std::ssize(splines.patches), 16, [&](Offset first, Offset last) {
        for (Offset p = first; p < last; ++p) {
            const TricubicPatch patch(splines.patches[p]);
            const PatchPositions positions = positionsOf(splines.patches[p], vertices);
            for (Offset k = of.offsets[p]; k < of.offsets[p + 1]; ++k) {
                const Index i = of.places[k];
                const Vector3d uvw(splines.places[i].uvw.data());
                const PlaceWeights weights{patch.axisWeights(uvw, splines.spacing, values),
                                           patch.axisWeights(uvw, splines.spacing, {1, 1, 1})};
                use(i, derivativesAt(positions, weights));
            }
        }
    });
}

/// Returns the weights of the corners in the derivatives by u, v and w.
std::array<Trilinear::Weights, 3> weightsAt(const CellPlaces::Place& place) {
    return Trilinear::weightDerivatives(Vector3d(place.uvw.data()));
}

/// Returns the derivatives of the map of a cell, as rows.
Matrix3d derivativesOf(const CellPlaces::Cell& cell,
                       const std::array<Trilinear::Weights, 3>& weights,
                       const std::vector<Point3>& positions) {
    Matrix3d result = Matrix3d::Zero();
    for (std::size_t corner = 0; corner < 8; ++corner) {
        const Eigen::RowVector3d at(positions[cell[corner]].data());
        for (std::size_t axis = 0; axis < 3; ++axis)
            result.row(static_cast<Eigen::Index>(axis)) += weights[axis][corner] * at;
    }
    return result;
}

/// The basis functions of the three axes at one place.
using GridFunctions = std::array<AxisFunctions, 3>;

void setFunctions(const BasisPlaces& basis, const BasisPlaces::Place& place,
                  GridFunctions& functions) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        axisFunctions(basis.basis, basis.cells[axis], place.at[axis], functions[axis]);
}

/// Calls use(vertex, y, z) for each line of vertices along the first axis: its first vertex, and
/// the numbers of the functions of the other axes.
template <class Use>
void forEachLine(const BasisPlaces& basis, const GridFunctions& functions, Use use) {
    const auto& [x, y, z] = functions;
    for (std::size_t k = 0; k < z.values.size(); ++k)
        for (std::size_t j = 0; j < y.values.size(); ++j) {
            const Index row = y.first + static_cast<Index>(j);
            const Index layer = z.first + static_cast<Index>(k);
            use(x.first + (basis.cells[0] + 1) * (row + (basis.cells[1] + 1) * layer), j, k);
        }
}

/// Returns the derivatives of the map of a basis, as rows.
Matrix3d derivativesOf(const BasisPlaces& basis, const GridFunctions& functions,
                       const std::vector<Point3>& positions) {
    const AxisFunctions &x = functions[0], &y = functions[1], &z = functions[2];
    Matrix3d result = Matrix3d::Zero();
    forEachLine(basis, functions, [&](Index vertex, std::size_t j, std::size_t k) {
        Eigen::RowVector3d slope = Eigen::RowVector3d::Zero(), value = slope;
        for (std::size_t i = 0; i < x.values.size(); ++i) {
            const Eigen::RowVector3d at(positions[vertex + static_cast<Index>(i)].data());
            slope += x.derivatives[i] * at;
            value += x.values[i] * at;
        }
        result.row(0) += y.values[j] * z.values[k] * slope;
        result.row(1) += y.derivatives[j] * z.values[k] * value;
        result.row(2) += y.values[j] * z.derivatives[k] * value;
    });
    return result;
}

/// Returns (T X)⁻¹, which is the same for all places: at rest, the map of a basis is affine.
Matrix3d inverseAtRest(const BasisPlaces& basis, const MovedVertices& vertices) {
    GridFunctions functions;
    setFunctions(basis, basis.places.front(), functions);
    return inverseAtRest(derivativesOf(basis, functions, vertices.rest));
}

/// Adds a matrix, given as its transpose.
void addTransposed(const Matrix3d& added, DeformationGradient& sum) {
    for (Eigen::Index i = 0; i < 3; ++i)
        for (Eigen::Index j = 0; j < 3; ++j)
            sum[static_cast<std::size_t>(3 * i + j)] += added(j, i);
}

/// Builds rows of F − 1 over the vertices, three for each point.
class RowsOverVertices {
public:
    RowsOverVertices(const Gradients& gradients, std::span<const Point3> rest, Index pointCount)
        : gradients_(gradients),
          patches_(gradients.splines.patches.begin(), gradients.splines.patches.end()),
          inverses_(gradients.splines.places.size()),
          vertices_(gradients, rest, {}),
          perLength_(LengthUnit(rest).toUnits(1.0)),
          sources_(pointCount) {
        for (std::size_t i = 0; i < gradients.points.size(); ++i)
            sources_[gradients.points[i]] = {Source::Row, static_cast<Index>(i)};
        const auto add = [&](const auto& places, Source::Kind kind) {
            for (std::size_t i = 0; i < places.size(); ++i)
                sources_[places[i].point] = {kind, static_cast<Index>(i)};
        };
        add(gradients.cells.places, Source::Cell);
        add(gradients.splines.places, Source::Spline);
        add(gradients.basis.places, Source::Basis);
        forEachPlace(gradients.splines, vertices_, [&](Index i, const PatchDerivatives& at) {
            inverses_[i] = perLength_ * inverseAtRest(at.topRows<3>().transpose());
        });
        if (!gradients.basis.places.empty())
            inverseOfBasis_ = perLength_ * inverseAtRest(gradients.basis, vertices_);
    }

    stencils::StencilTable<double> build() const {
        return stencils::buildTable(
            3 * static_cast<Index>(sources_.size()), gradients_.vertices.rowCount(),
            [&](Index row, stencils::RowAccumulator& accumulator) {
                const auto& [kind, i] = sources_[row / 3];
                const Index axis = row % 3;
                switch (kind) {
                    case Source::None:
                        return;
                    case Source::Row:
                        addRow(3 * i + axis, accumulator);
                        break;
                    case Source::Cell:
                        add(gradients_.cells.places[i], axis, accumulator);
                        break;
                    case Source::Spline:
                        add(gradients_.splines.places[i], inverses_[i], axis, accumulator);
                        break;
                    case Source::Basis:
                        add(gradients_.basis.places[i], axis, accumulator);
                        break;
                }
                accumulator.makeSumZero();
            });
    }

private:
    /// Where the gradient of a point comes from: its number in the list of this kind.
    struct Source {
        enum Kind { None, Row, Cell, Spline, Basis } kind = None;
        Index number = 0;
    };

    void addRow(Index row, stencils::RowAccumulator& accumulator) const {
        const auto& rows = gradients_.rows;
        for (std::size_t k = 0; k < rows.columns(row).size(); ++k)
            accumulator.add(rows.columns(row)[k], rows.weights(row)[k]);
    }

    void add(const CellPlaces::Place& place, Index axis,
             stencils::RowAccumulator& accumulator) const {
        const CellPlaces::Cell& cell = gradients_.cells.cells[place.cell];
        const auto weights = weightsAt(place);
        const Matrix3d inverse =
            perLength_ * inverseAtRest(derivativesOf(cell, weights, vertices_.rest));
        if (!inverse.allFinite()) return;
        for (std::size_t by = 0; by < 3; ++by)
            for (std::size_t corner = 0; corner < 8; ++corner)
                accumulator.add(cell[corner],
                                inverse(axis, static_cast<Eigen::Index>(by)) * weights[by][corner]);
    }

    void add(const SplinePlaces::Place& place, const Matrix3d& inverse, Index axis,
             stencils::RowAccumulator& accumulator) const {
        if (!inverse.allFinite()) return;
        const TricubicPatch& patch = patches_[place.patch];
        for (std::size_t by = 0; by < 3; ++by) {
            const double factor = inverse(axis, static_cast<Eigen::Index>(by));
            std::array<int, 3> orders = {};
            orders[by] = 1;
            const auto along =
                patch.axisWeights(Vector3d(place.uvw.data()), gradients_.splines.spacing, orders);
            std::array<Index, 64> vertices;
            std::array<double, 64> weights;
            patch.writeRow(along, vertices.data(), weights.data());
            const Index length = TricubicPatch::rowLength(along);
            for (Index k = 0; k < length; ++k) accumulator.add(vertices[k], factor * weights[k]);
        }
    }

    void add(const BasisPlaces::Place& place, Index axis,
             stencils::RowAccumulator& accumulator) const {
        if (!inverseOfBasis_.allFinite()) return;
        GridFunctions functions;
        setFunctions(gradients_.basis, place, functions);
        const AxisFunctions &x = functions[0], &y = functions[1], &z = functions[2];
        const Eigen::RowVector3d factors = inverseOfBasis_.row(axis);
        forEachLine(gradients_.basis, functions, [&](Index vertex, std::size_t j, std::size_t k) {
            const double slope = factors[0] * y.values[j] * z.values[k];
            const double value = factors[1] * y.derivatives[j] * z.values[k] +
                                 factors[2] * y.values[j] * z.derivatives[k];
            for (std::size_t i = 0; i < x.values.size(); ++i)
                accumulator.add(vertex + static_cast<Index>(i),
                                slope * x.derivatives[i] + value * x.values[i]);
        });
    }

    const Gradients& gradients_;
    std::vector<TricubicPatch> patches_;
    std::vector<Matrix3d> inverses_;  ///< one per place in splines
    MovedVertices vertices_;
    double perLength_;  ///< makes inverses per length; in tiny lattices they overflow
    Matrix3d inverseOfBasis_ = Matrix3d::Zero();
    std::vector<Source> sources_;  ///< one per point
};

}  // namespace

Index Gradients::identityCount(Index pointCount) const {
    return static_cast<Index>(pointCount - std::ssize(points) - std::ssize(cells.places) -
                              std::ssize(splines.places) - std::ssize(basis.places));
}

namespace {

/// \throws Error unless the places are in the lattice, and the lattice has the vertices
void checkBasis(const BasisPlaces& basis, Index vertexCount) {
    const auto& [kind, cells, places] = basis;
    if (places.empty()) return;
    double expected = 1;
    for (const Index along : cells) expected *= along + 1.0;
    if (expected != vertexCount || std::ranges::min(cells) < (kind == Basis::Bezier ? 1 : 3))
        throw Error(concat("gradients in a lattice of ", cells[0], " × ", cells[1], " × ", cells[2],
                           " cells have ", vertexCount, " vertices"));
    for (const auto& [point, at] : places)
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (const auto [low, high] = axisRange(kind, cells[axis]);
                !(at[axis] >= low && at[axis] <= high))
                throw Error(concat("the place of point ", point, " in the lattice is ", at[axis],
                                   " along axis ", axis, "; expected ", low, " to ", high));
}

}  // namespace

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
    for (const auto& [point, patch, uvw] : places) {
        take(point);
        checkUvw(point, uvw);
        if (patch < 0 || patch >= std::ssize(patches))
            throw Error(concat("the gradient of point ", point, " is in patch ", patch, " of ",
                               patches.size()));
    }
    for (const auto& patch : patches) TricubicPatch::checkVertices(patch, vertices.rowCount());
    checkBasis(basis, vertices.rowCount());
    for (const auto& place : basis.places) take(place.point);
}

void addGradients(const Gradients& gradients, std::span<const Point3> rest,
                  std::span<const Point3> displacements, std::span<DeformationGradient> sums) {
    const auto& [vertices, points, rows, cells, splines, basis] = gradients;
    if (!points.empty()) {
        const auto columns =
            stencils::applyLevelTable(rows, stencils::applyLevelTable(vertices, displacements));
        for (std::size_t row = 0; row < columns.size(); ++row)
            for (std::size_t i = 0; i < 3; ++i)
                sums[points[row / 3]][3 * i + row % 3] += columns[row][i];
    }
    const MovedVertices moved(gradients, rest, displacements);
    // Fᵀ − 1 = (T X)⁻¹ T (x − X)
    const auto addAt = [&](Index point, const Matrix3d& atRest, const Matrix3d& displaced) {
        const Matrix3d inverse = inverseAtRest(atRest);
        if (inverse.allFinite()) addTransposed(inverse * displaced, sums[point]);
    };
    const auto& ofCells = cells;  // clang 14 captures no structured binding
    parallelFor(std::ssize(cells.places), 1024, [&](Offset first, Offset last) {
        for (Offset i = first; i < last; ++i) {
            const CellPlaces::Place& place = ofCells.places[i];
            const CellPlaces::Cell& cell = ofCells.cells[place.cell];
            const auto weights = weightsAt(place);
            addAt(place.point, derivativesOf(cell, weights, moved.rest),
                  derivativesOf(cell, weights, moved.displaced));
        }
    });
    const auto& ofSplines = splines;
    forEachPlace(splines, moved, [&](Index i, const PatchDerivatives& derivatives) {
        addAt(ofSplines.places[i].point, derivatives.topRows<3>().transpose(),
              derivatives.bottomRows<3>().transpose());
    });
    if (basis.places.empty()) return;
    const auto& ofBasis = basis;
    const Matrix3d inverse = inverseAtRest(basis, moved);
    if (!inverse.allFinite()) return;
    parallelFor(std::ssize(basis.places), 1024, [&](Offset first, Offset last) {
        GridFunctions functions;
        for (const BasisPlaces::Place& place :
             std::span(ofBasis.places).subspan(first, last - first)) {
            setFunctions(ofBasis, place, functions);
            addTransposed(inverse * derivativesOf(ofBasis, functions, moved.displaced),
                          sums[place.point]);
        }
    });
}

GradientTables gradientTables(const Gradients& gradients, std::span<const Point3> rest,
                              Index pointCount) {
    const auto rows = stencils::multiply(RowsOverVertices(gradients, rest, pointCount).build(),
                                         gradients.vertices);
    GradientTables result;
    for (std::size_t axis = 0; axis < 3; ++axis)
        result[axis] = stencils::buildTable(
            pointCount, gradients.columnCount(),
            [&](Index point, stencils::RowAccumulator& accumulator) {
                const Index row = 3 * point + static_cast<Index>(axis);
                for (std::size_t k = 0; k < rows.columns(row).size(); ++k)
                    accumulator.add(rows.columns(row)[k], rows.weights(row)[k]);
                accumulator.makeSumZero();
            });
    return result;
}

}  // namespace espalier::embed

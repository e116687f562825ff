// SPDX-License-Identifier: Apache-2.0
#include "cage_energy.h"

#include <espalier/base/parallel.h>
#include <espalier/base/sort_unique.h>
#include <espalier/base/vector3.h>
#include <espalier/far/standard_cells.h>
#include <espalier/limit/vertex_limits.h>
#include <espalier/stencils/composition.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>
#include <utility>

namespace espalier::cages {
namespace {

Point3 rowTimes(const stencils::StencilTable<double>& table, Index row,
                std::span<const Point3> values) {
    Point3 result = {0, 0, 0};
    const auto columns = table.columns(row);
    const auto weights = table.weights(row);
    for (std::size_t i = 0; i < columns.size(); ++i) {
        const Point3& value = values[columns[i]];
        result[0] += weights[i] * value[0];
        result[1] += weights[i] * value[1];
        result[2] += weights[i] * value[2];
    }
    return result;
}

void addRow(const stencils::StencilTable<double>& table, Index row, const Point3& value,
            std::span<Point3> sums) {
    const auto columns = table.columns(row);
    const auto weights = table.weights(row);
    for (std::size_t i = 0; i < columns.size(); ++i) {
        Point3& sum = sums[columns[i]];
        sum[0] += weights[i] * value[0];
        sum[1] += weights[i] * value[1];
        sum[2] += weights[i] * value[2];
    }
}

void addTo(Point3& sum, const Point3& value, double factor) {
    for (int axis = 0; axis < 3; ++axis) sum[axis] += factor * value[axis];
}

/// Part of the energy that counts the lengths of the edges. The rest counts only their angles, so
/// that cells around a thin part may be thin.
constexpr double kLengthPart = 0.1;

/// The energy of one corner of a hexahedron, and its derivatives by the three edges.
struct CornerEnergy {
    double energy = 0;
    std::array<Point3, 3> slopes;
};

/// \param u, v, w edges to the three neighbours
inline CornerEnergy cornerEnergy(const Point3& u, const Point3& v, const Point3& w) {
    // A quotient below this is treated as if it were slowly rising, so that the energy is finite
    // and has a slope in folded cells too.
    constexpr double kFlat = 1e-3;
    constexpr double kTiny = 1e-300;
    const double uu = dot(u, u) + kTiny, vv = dot(v, v) + kTiny, ww = dot(w, w) + kTiny;
    const Point3 vw = cross(v, w), wu = cross(w, u), uv = cross(u, v);
    const double determinant = dot(u, vw);
    // q = determinant · density is 1 for a cube.
    const double perSquare = 3 / (uu + vv + ww);
    const double perProduct = 1 / (uu * (vv * ww));
    const double density = perSquare * std::sqrt(perSquare), q = determinant * density;
    const double densityOfAngles = std::sqrt(perProduct), qOfAngles = determinant * densityOfAngles;
    // The energy is a mean of 1 / safe(q)², with safe(q) = (q + root) / 2 and safe' = safe / root.
    const double root = std::sqrt(q * q + kFlat * kFlat), safe = (q + root) / 2;
    const double rootOfAngles = std::sqrt(qOfAngles * qOfAngles + kFlat * kFlat),
                 safeOfAngles = (qOfAngles + rootOfAngles) / 2;
    const double energy = kLengthPart / (safe * safe);
    const double energyOfAngles = (1 - kLengthPart) / (safeOfAngles * safeOfAngles);
    const double slope = -2 * energy / root, slopeOfAngles = -2 * energyOfAngles / rootOfAngles;
    // dq/du = v × w · density − q u / (square of the length of u, or mean of the three squares)
    const double ofArea = slope * density + slopeOfAngles * densityOfAngles;
    const double ofEdge = slope * q * perSquare, ofAngles = slopeOfAngles * qOfAngles * perProduct;
    return {energy + energyOfAngles,
            {difference(scaled(vw, ofArea), scaled(u, ofEdge + ofAngles * (vv * ww))),
             difference(scaled(wu, ofArea), scaled(v, ofEdge + ofAngles * (ww * uu))),
             difference(scaled(uv, ofArea), scaled(w, ofEdge + ofAngles * (uu * vv)))}};
}

/// The sum of the energies of the corners of a hexahedron, and its derivatives by the vertices.
struct HexahedronEnergy {
    double energy = 0;
    std::array<Point3, 8> slopes = {};
};

HexahedronEnergy hexahedronEnergy(const std::array<Index, 8>& vertices,
                                  std::span<const Point3> positions) {
    // One array for each coordinate, so that the compiler computes several corners at once.
    using OfCorners = std::array<double, 8>;
    std::array<std::array<OfCorners, 3>, 3> edges, slopes;
    OfCorners energies;
    for (std::size_t corner = 0; corner < 8; ++corner)
        for (std::size_t i = 0; i < 3; ++i) {
            const Point3 edge =
                difference(positions[vertices[far::kHexahedronNeighbours[corner][i]]],
                           positions[vertices[corner]]);
            for (std::size_t axis = 0; axis < 3; ++axis) edges[i][axis][corner] = edge[axis];
        }
    for (std::size_t corner = 0; corner < 8; ++corner) {
        const auto edge = [&](std::size_t i) {
            return Point3{edges[i][0][corner], edges[i][1][corner], edges[i][2][corner]};
        };
        const CornerEnergy at = cornerEnergy(edge(0), edge(1), edge(2));
        energies[corner] = at.energy;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t axis = 0; axis < 3; ++axis)
                slopes[i][axis][corner] = at.slopes[i][axis];
    }
    HexahedronEnergy result;
    for (std::size_t corner = 0; corner < 8; ++corner)
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                result.slopes[far::kHexahedronNeighbours[corner][i]][axis] +=
                    slopes[i][axis][corner];
                result.slopes[corner][axis] -= slopes[i][axis][corner];
            }
    for (const double energy : energies) result.energy += energy;
    return result;
}

/// Returns the limits of all vertices of a level. A vertex that comes from a vertex of the level
/// before has the same limit as that one.
/// \param before the limits of the level before; empty for level 0
stencils::StencilTable<double> limitsOf(const far::TopologyRefiner& refiner, int level,
                                        const stencils::StencilTable<double>& before) {
    const Index count = refiner.level(level).complex.count(0);
    std::vector<Index> newVertices;
    std::vector<std::optional<Index>> parents(count);
    for (Index vertex = 0; vertex < count; ++vertex) {
        const Entity parent = refiner.refinement(level).parentOf({0, vertex}).upper;
        if (parent.dimension == 0 && parent.index < before.rowCount())
            parents[vertex] = parent.index;
        else
            newVertices.push_back(vertex);
    }
    const auto ofNew = limit::buildVertexLimits(refiner, level, newVertices);
    Array<Offset> offsets = {0};
    Array<Index> columns;
    Array<double> weights;
    Index next = 0;
    for (const auto& parent : parents) {
        const auto& table = parent ? before : ofNew;
        const Index row = parent ? *parent : next++;
        columns.insert(columns.end(), table.columns(row).begin(), table.columns(row).end());
        weights.insert(weights.end(), table.weights(row).begin(), table.weights(row).end());
        offsets.push_back(static_cast<Offset>(columns.size()));
    }
    return {stencils::Trusted(), ofNew.columnCount(), std::move(offsets), std::move(columns),
            std::move(weights)};
}

double dotOf(std::span<const Point3> a, std::span<const Point3> b) {
    double total = 0;
    for (std::size_t i = 0; i < a.size(); ++i) total += dot(a[i], b[i]);
    return total;
}

}  // namespace

CellShapes::CellShapes(const far::TopologyRefiner& refiner)
    : refiner_(refiner), weights_(refiner.level(0).complex.count(3)) {
    addLevel();
    addLevel();
    resetWeights();
}

void CellShapes::addLevel() {
    const auto k = static_cast<int>(levels_.size());
    LevelCells cells;
    const far::CellComplex& complex = refiner_.level(k).complex;
    if (k > 0) cells.table = limitsOf(refiner_, k, levels_.back().table);
    for (Index cell = 0; cell < complex.count(3); ++cell) {
        const auto vertices = far::hexahedronVertices(complex, CellId(cell));
        if (!vertices) continue;
        Index base = cell;
        for (int j = k; j > 0; --j) base = refiner_.refinement(j).parentOf({3, base}).upper.index;
        cells.cells.push_back({*vertices, base});
    }
    cells.weight = k == 0 ? 0.5 : 1.0 / std::pow(8.0, k);
    levels_.push_back(std::move(cells));
}

void CellShapes::addAllLevels() {
    while (levels_.size() <= kLevel) addLevel();
}

void CellShapes::resetWeights() {
    weights_.assign(weights_.size(), 1.0);
    isExamined_.assign(weights_.size(), 0);
    activate();
}

void CellShapes::examine(std::span<const Index> baseCells) {
    addAllLevels();
    for (const Index cell : baseCells) isExamined_[cell] = 1;
    activate();
}

void CellShapes::activate() {
    for (std::size_t k = 0; k < levels_.size(); ++k) {
        LevelCells& level = levels_[k];
        level.activeCells.clear();
        level.activeRows.clear();
        for (std::size_t i = 0; i < level.cells.size(); ++i) {
            const Cell& cell = level.cells[i];
            if (k > 1 && isExamined_[cell.baseCell] == 0) continue;
            level.activeCells.push_back(static_cast<Index>(i));
            if (k == 0) continue;  // no rows: the vertices of the base
            level.activeRows.insert(level.activeRows.end(), cell.vertices.begin(),
                                    cell.vertices.end());
        }
        sortUnique(level.activeRows);
    }
}

double CellShapes::evaluate(std::span<const Point3> positions, std::span<Point3> gradient) const {
    double total = 0;
    for (const LevelCells& level : levels_) {
        if (level.table.rowCount() == 0) {
            total += evaluateCells(level, positions, gradient);
            continue;
        }
        if (level.activeCells.empty()) continue;
        std::vector<Point3> refined(level.table.rowCount()), slopes(refined.size());
        parallelFor(std::ssize(level.activeRows), 256, [&](Offset first, Offset last) {
            for (Offset i = first; i < last; ++i)
                refined[level.activeRows[i]] =
                    rowTimes(level.table, level.activeRows[i], positions);
        });
        total += evaluateCells(level, refined, slopes);
        for (const Index row : level.activeRows) addRow(level.table, row, slopes[row], gradient);
    }
    return total;
}

/// Returns the energy of the active cells of a level: the mean over the corners of each cell,
/// less 1. Adds its gradient.
double CellShapes::evaluateCells(const LevelCells& level, std::span<const Point3> positions,
                                 std::span<Point3> gradient) const {
    // The energies are computed on several threads, and added in the order of the cells.
    constexpr Offset kCellsAtOnce = 2048;
    const Offset count = std::ssize(level.activeCells);
    std::vector<HexahedronEnergy> energies(std::min(count, kCellsAtOnce));
    double total = 0;
    for (Offset begin = 0; begin < count; begin += kCellsAtOnce) {
        const auto cells =
            std::span(level.activeCells).subspan(begin, std::min(count - begin, kCellsAtOnce));
        parallelFor(std::ssize(cells), 64, [&](Offset first, Offset last) {
            for (Offset i = first; i < last; ++i)
                energies[i] = hexahedronEnergy(level.cells[cells[i]].vertices, positions);
        });
        for (std::size_t i = 0; i < cells.size(); ++i) {
            const Cell& cell = level.cells[cells[i]];
            const double weight = level.weight * weights_[cell.baseCell];
            for (std::size_t corner = 0; corner < 8; ++corner)
                addTo(gradient[cell.vertices[corner]], energies[i].slopes[corner], weight / 8);
            total += weight * (energies[i].energy / 8 - 1);
        }
    }
    return total;
}

double CellShapes::workOfEvaluation() const {
    constexpr double kPerCell = 200, kPerRow = 100;
    double steps = 0;
    for (const LevelCells& level : levels_)
        steps += kPerCell * static_cast<double>(level.activeCells.size()) +
                 kPerRow * static_cast<double>(level.activeRows.size());
    return steps;
}

std::vector<double> CellShapes::leastJacobians(std::span<const Point3> positions) {
    addAllLevels();
    std::vector<double> least(weights_.size(), 1.0);
    for (const LevelCells& level : levels_) {
        std::vector<Point3> refined(positions.begin(), positions.end());
        if (level.table.rowCount() > 0) refined = stencils::applyLevelTable(level.table, positions);
        for (const Cell& cell : level.cells)
            for (std::size_t corner = 0; corner < 8; ++corner) {
                const auto& next = far::kHexahedronNeighbours[corner];
                std::array<Point3, 3> ways;
                double lengths = 1;
                for (int i = 0; i < 3; ++i) {
                    ways[i] =
                        difference(refined[cell.vertices[next[i]]], refined[cell.vertices[corner]]);
                    lengths *= length(ways[i]);
                }
                const double volume = dot(ways[0], cross(ways[1], ways[2]));
                double& value = least[cell.baseCell];
                value = std::min(value, lengths > 0 ? volume / lengths : 0);
            }
    }
    return least;
}

double evaluatePlanes(const stencils::StencilTable<double>& table, std::span<const PlaneTerm> terms,
                      std::span<const Point3> positions, std::span<Point3> gradient) {
    std::vector<double> distances(terms.size());
    parallelFor(std::ssize(terms), 256, [&](Offset first, Offset last) {
        for (Offset i = first; i < last; ++i) {
            const PlaneTerm& term = terms[i];
            if (term.inside == 0 && term.outside == 0) continue;
            distances[i] = dot(term.direction, rowTimes(table, term.row, positions)) - term.offset;
        }
    });
    double total = 0;
    for (std::size_t i = 0; i < terms.size(); ++i) {
        const PlaneTerm& term = terms[i];
        const double distance = distances[i];
        const double weight = distance < 0 ? term.inside : term.outside;
        if (weight == 0) continue;
        const double limited = std::clamp(distance, -term.reach, term.reach);
        total += weight * limited * (2 * distance - limited);
        addRow(table, term.row, scaled(term.direction, 2 * weight * limited), gradient);
    }
    return total;
}

std::vector<Point3> minimise(const Energy& energy, std::vector<Point3> positions, int iterations,
                             double longestStep) {
    constexpr std::size_t kHistory = 8;
    constexpr int kHalvings = 12;
    const std::size_t size = positions.size();
    struct Pair {
        std::vector<Point3> step, change;
        double product;
    };
    std::deque<Pair> history;
    std::vector<Point3> gradient(size), next(size), nextGradient(size), direction(size);
    double value = energy(positions, gradient);
    for (int iteration = 0; iteration < iterations; ++iteration) {
        direction = gradient;
        std::vector<double> factors;
        for (auto pair = history.rbegin(); pair != history.rend(); ++pair) {
            const double factor = dotOf(pair->step, direction) / pair->product;
            factors.push_back(factor);
            for (std::size_t i = 0; i < size; ++i) addTo(direction[i], pair->change[i], -factor);
        }
        if (!history.empty()) {
            const Pair& last = history.back();
            const double scale = last.product / dotOf(last.change, last.change);
            for (Point3& d : direction) d = scaled(d, scale);
        }
        for (std::size_t k = 0; k < history.size(); ++k) {
            const Pair& pair = history[k];
            const double factor =
                factors[history.size() - 1 - k] - dotOf(pair.change, direction) / pair.product;
            for (std::size_t i = 0; i < size; ++i) addTo(direction[i], pair.step[i], factor);
        }
        double longest = 0;
        for (Point3& d : direction) {
            d = scaled(d, -1);
            longest = std::max(longest, dot(d, d));
        }
        longest = std::sqrt(longest);
        if (longest == 0) break;
        double slope = dotOf(direction, gradient);
        if (!(slope < 0)) {
            if (history.empty()) break;
            history.clear();
            continue;
        }
        double length = std::min(1.0, longestStep / longest);
        if (history.empty()) length = longestStep / longest / 4;
        double nextValue = 0;
        int halving = 0;
        for (; halving < kHalvings; ++halving, length /= 2.5) {
            for (std::size_t i = 0; i < size; ++i) {
                next[i] = positions[i];
                addTo(next[i], direction[i], length);
            }
            std::fill(nextGradient.begin(), nextGradient.end(), Point3{0, 0, 0});
            nextValue = energy(next, nextGradient);
            if (nextValue <= value + 1e-4 * length * slope) break;
        }
        if (halving == kHalvings) {
            if (history.empty()) break;
            history.clear();
            continue;
        }
        Pair pair{std::vector<Point3>(size), std::vector<Point3>(size), 0};
        for (std::size_t i = 0; i < size; ++i) {
            pair.step[i] = difference(next[i], positions[i]);
            pair.change[i] = difference(nextGradient[i], gradient[i]);
        }
        pair.product = dotOf(pair.step, pair.change);
        if (pair.product >
            1e-12 * std::sqrt(dotOf(pair.step, pair.step) * dotOf(pair.change, pair.change))) {
            history.push_back(std::move(pair));
            if (history.size() > kHistory) history.pop_front();
        }
        positions.swap(next);
        gradient.swap(nextGradient);
        value = nextValue;
    }
    return positions;
}

}  // namespace espalier::cages

// SPDX-License-Identifier: Apache-2.0
#include "layered_edge.h"

#include <espalier/base/error.h>
#include <espalier/embed/cell_frame.h>
#include <espalier/far/complex_builder.h>
#include <espalier/stencils/levels.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace espalier::limit {
namespace {

using Eigen::Vector3d;

constexpr Index kLayerCount = 4;
constexpr Index kKindCount = 3;

/// Number of times that an edge is halved. Its parts are then hardly longer than the rounding of
/// coordinates.
constexpr int kHalvings = 48;

/// Kind of vertex i of a layer: 0 on the axis, 1 and 2 in turn on the ring.
Index kindOf(Index i) {
    return i == 0 ? 0 : 2 - i % 2;
}

Index layerSize(Index cellCount) {
    return 1 + 2 * cellCount;
}

/// Returns true if the cells around an edge continue beyond one of its ends: n hexahedra around the
/// edge and n around another edge are all cells at this vertex. Then all rules around the vertex
/// are the rules for the interior.
bool isContinued(const far::Level& level, Index edge, Index vertex) {
    const far::CellComplex& complex = level.complex;
    const auto around = complex.relation(1, 3)[edge];
    const auto cells = complex.relation(0, 3)[vertex];
    if (cells.size() != 2 * around.size()) return false;
    for (int dimension = 0; dimension < 3; ++dimension)
        for (const Index index : complex.relation(0, dimension)[vertex]) {
            const Entity entity{dimension, index};
            if (level.strata.of(entity) != 3 || level.strata.isOpen(entity) ||
                (dimension < 2 && far::isSemiSharp(level.strata.sharpness(entity))))
                return false;
        }
    const auto isOpposite = [&](Index other) {
        return complex.relation(1, 3)[other].size() == around.size() &&
               std::none_of(around.begin(), around.end(), [&](Index cell) {
                   return far::contains(complex.relation(3, 1)[cell], other);
               });
    };
    const auto edges = complex.relation(0, 1)[vertex];
    return std::any_of(edges.begin(), edges.end(), isOpposite) &&
           std::all_of(cells.begin(), cells.end(), [&](Index cell) {
               return far::hexahedronVertices(complex, CellId(cell)).has_value();
           });
}

}  // namespace

std::optional<std::vector<Index>> layersAround(const far::Level& level, Index edge) {
    const far::CellComplex& complex = level.complex;
    const auto cells = complex.relation(1, 3)[edge];
    const auto ends = complex.relation(1, 0)[edge];
    const auto cellCount = static_cast<Index>(cells.size());
    if (cellCount < 3 || !isContinued(level, edge, ends[0]) || !isContinued(level, edge, ends[1]))
        return std::nullopt;
    const Index size = layerSize(cellCount);
    std::vector<Index> layers(kLayerCount * size);

    // Walk around the edge, from one face to the next.
    Index cell = cells[0], face = kMaxIndex;
    const auto otherFace = [&] {
        const auto faces = complex.relation(3, 2)[cell];
        return *std::find_if(faces.begin(), faces.end(), [&](Index other) {
            return other != face && far::contains(complex.relation(2, 1)[other], edge);
        });
    };
    face = otherFace();
    for (Index k = 0; k < cellCount; ++k) {
        const embed::CellFrame frame = *embed::frameOf(complex, cell);
        const auto cornerOf = [&](Index vertex) -> std::size_t {
            return std::find(frame.corners.begin(), frame.corners.end(), vertex) -
                   frame.corners.begin();
        };
        // The corner at the low end of the edge's axis in the frame. A step along the edge changes
        // one bit of a corner's number.
        const std::size_t first = cornerOf(ends[0]), axisBit = first ^ cornerOf(ends[1]);
        const std::size_t axis = axisBit >> 1;  // 1, 2, 4 belong to the axes 0, 1, 2.
        const auto faceVertices = complex.relation(2, 0)[face];
        std::size_t enterBit = 0;  // Steps along the face through which the walk enters the cell.
        for (const std::size_t bit : {1, 2, 4})
            if (bit != axisBit && far::contains(faceVertices, frame.corners[first ^ bit]))
                enterBit = bit;
        const std::size_t leaveBit = 7 ^ axisBit ^ enterBit;
        const auto before = embed::neighbourOf(complex, frame, axis, first >> axis & 1);
        const auto after = embed::neighbourOf(complex, frame, axis, ~first >> axis & 1);
        if (!before || !after) return std::nullopt;
        const auto put = [&](Offset layer, const embed::CellFrame& from, std::size_t corner) {
            Index* row = layers.data() + layer * size;
            row[0] = from.corners[corner];
            row[1 + 2 * k] = from.corners[corner ^ enterBit];
            row[2 + 2 * k] = from.corners[corner ^ enterBit ^ leaveBit];
        };
        put(0, *before, first);
        put(1, frame, first);
        put(2, frame, first ^ axisBit);
        put(3, *after, first ^ axisBit);
        face = otherFace();
        const auto sides = complex.relation(2, 3)[face];
        cell = sides[0] == cell ? sides[1] : sides[0];
    }
    return layers;
}

namespace {

/// Returns a lattice of three layers of n hexahedra around an axis. Vertices are numbered as
/// layersAround() orders them.
far::CellComplex layersOfCells(Index cellCount) {
    const Index size = layerSize(cellCount);
    far::ComplexBuilder builder(3, kLayerCount * size);
    for (Index layer = 0; layer + 1 < kLayerCount; ++layer)
        for (Index k = 0; k < cellCount; ++k) {
            const Index low = layer * size, high = low + size;
            const std::array<Index, 4> corners = {0, 1 + 2 * k, 2 + 2 * k,
                                                  1 + 2 * ((k + 1) % cellCount)};
            std::array<Index, 8> cell;
            for (std::size_t i = 0; i < 4; ++i) {
                cell[i] = low + corners[i];
                cell[i + 4] = high + corners[i];
            }
            builder.addCell(far::StandardCell::Hexahedron, cell);
        }
    return builder.build();
}

/// Returns the entity of a dimension that contains some vertices. Searches the entities of the
/// first vertex.
Entity entityWith(const far::CellComplex& complex, int dimension, std::span<const Index> vertices) {
    for (const Index index : complex.relation(0, dimension)[vertices[0]]) {
        const auto own = complex.relation(dimension, 0)[index];
        if (std::all_of(vertices.begin(), vertices.end(),
                        [&](Index vertex) { return far::contains(own, vertex); }))
            return {dimension, index};
    }
    throw Error("a lattice of layers lacks an entity");
}

/// Refines a lattice of layers. Returns the rows of the five layers of child vertices around its
/// middle edge.
stencils::StencilTable<double> refinedLayers(far::Rules rules, Index cellCount) {
    const far::CellComplex complex = layersOfCells(cellCount);
    stencils::Levels levels(far::TopologyRefiner(complex, {.rules = rules}));
    std::vector<Index> all(complex.count(3));
    std::iota(all.begin(), all.end(), Index{0});
    levels.refineAround(all, far::TopologyRefiner::Extent::Cells);
    const Index size = layerSize(cellCount);
    std::vector<Index> children;
    for (Index half = 1; half <= 5; ++half) {
        for (Index i = 0; i < size; ++i) {
            // Even numbers of halves are layers of the parent; the others are between two of them.
            std::vector<Index> parents;
            if (i > 0) parents.push_back(i);
            if (kindOf(i) == 2) parents.insert(parents.end(), {i - 1, 1 + i % (2 * cellCount)});
            parents.push_back(0);
            for (Index& vertex : parents) vertex += half / 2 * size;
            const std::size_t count = half % 2 == 1 ? parents.size() : 0;
            for (std::size_t k = 0; k < count; ++k) parents.push_back(parents[k] + size);
            const Entity parent = entityWith(complex, kindOf(i) + half % 2, parents);
            children.push_back(levels.refiner().refinement(1).childOf({parent, parent})->index);
        }
    }
    return stencils::selectRows(levels.tables()[0], children);
}

/// A wave around the axis: the factor of vertex i of a layer.
using Wave = std::vector<double>;

/// Each layer has a wave, times three factors: one for each kind of vertices. Returns the matrix
/// that gives these factors for the refined layers. Returns nothing if the refined layers do not
/// have the same wave.
std::optional<Eigen::Matrix<double, 15, 12>> actionOn(const Wave& wave,
                                                      const stencils::StencilTable<double>& rows) {
    constexpr double kRounding = 1e-12;
    const auto size = static_cast<Index>(wave.size());
    const auto classOf = [&](Index vertex) {
        return vertex / size * kKindCount + kindOf(vertex % size);
    };
    // The response of each child vertex to each class of vertices.
    Eigen::Matrix<double, Eigen::Dynamic, 12> responses(rows.rowCount(), 12);
    responses.setZero();
    Eigen::Matrix<double, 15, 12> action = Eigen::Matrix<double, 15, 12>::Zero();
    Eigen::Matrix<double, 15, 1> squares = Eigen::Matrix<double, 15, 1>::Zero();
    for (Index child = 0; child < rows.rowCount(); ++child) {
        const auto columns = rows.columns(child);
        for (std::size_t k = 0; k < columns.size(); ++k)
            responses(child, classOf(columns[k])) +=
                rows.weights(child)[k] * wave[columns[k] % size];
        const double factor = wave[child % size];
        action.row(classOf(child)) += factor * responses.row(child);
        squares[classOf(child)] += factor * factor;
    }
    for (Index i = 0; i < 15; ++i)
        if (squares[i] > 0) action.row(i) /= squares[i];
    for (Index child = 0; child < rows.rowCount(); ++child) {
        const Eigen::Matrix<double, 1, 12> expected =
            wave[child % size] * action.row(classOf(child));
        if ((responses.row(child) - expected).lpNorm<Eigen::Infinity>() > kRounding)
            return std::nullopt;
    }
    return action;
}

}  // namespace

EdgeRefinement::EdgeRefinement(Index cellCount)
    : cellCount_(cellCount), cosines_{0.0}, sines_{0.0} {
    for (Index i = 1; i < layerSize(cellCount); ++i) {
        const double angle = (i - 1) * std::numbers::pi / cellCount;
        cosines_.push_back(std::cos(angle));
        sines_.push_back(std::sin(angle));
    }
}

std::optional<EdgeRefinement> EdgeRefinement::make(far::Rules rules, Index cellCount) {
    EdgeRefinement result(cellCount);
    const auto rows = refinedLayers(rules, cellCount);
    const auto averages = actionOn(Wave(result.cosines_.size(), 1.0), rows),
               cosines = actionOn(result.cosines_, rows), sines = actionOn(result.sines_, rows);
    // Below this difference the two actions are equal up to rounding.
    constexpr double kRounding = 1e-12;
    if (!averages || !cosines || !sines ||
        (*cosines - *sines).lpNorm<Eigen::Infinity>() > kRounding)
        return std::nullopt;
    result.averages_ = *averages;
    result.waves_ = *cosines;
    Vertex middle = Vertex::Zero(), upwards = Vertex::Zero(), outwards = Vertex::Zero();
    middle[kKindCount] = 1;
    upwards[Eigen::Index{2} * kKindCount] = 1;
    upwards[0] = -1;
    outwards[kKindCount + 1] = 1;
    const auto limit = leading(result.averages_, middle, 1),
               along = leading(result.averages_, upwards, -1),
               across = leading(result.waves_, outwards, 1);
    if (!limit || !along || !across) return std::nullopt;
    result.limit_ = *limit / limit->sum();
    result.along_ = *along;
    result.across_ = *across;
    return result;
}

/// Returns the weights that a functional of the middle layer's vertex converges to, up to a factor.
/// \param parity 1 if the functional is symmetric along the edge, -1 if it is antisymmetric
std::optional<EdgeRefinement::Vertex> EdgeRefinement::leading(const Refinement& refinement,
                                                              Vertex weights, double parity) {
    // The weights converge by a factor of at most about 0.7 in each step.
    constexpr int kMaxSteps = 1000;
    constexpr double kSettled = 1e-15, kConverged = 1e-13;
    double change = 1;
    for (int step = 0; step < kMaxSteps && change > kSettled; ++step) {
        Vertex next = weights * refinement.topLeftCorner<9, 9>();
        // Rounding must not add the other parity, which may shrink more slowly.
        const Vertex reversed =
            (Vertex() << next.tail<3>(), next.segment<3>(3), next.head<3>()).finished();
        next = (next + parity * reversed).normalized();
        change = (next - weights).norm();
        weights = next;
    }
    if (!(change <= kConverged)) return std::nullopt;
    return weights;
}

EdgeRefinement::ControlPoints EdgeRefinement::controlPoints(
    std::span<const Index> layers, std::span<const Point3> positions) const {
    ControlPoints points = ControlPoints::Zero();
    const Index size = layerSize(cellCount_);
    for (Index layer = 0; layer < kLayerCount; ++layer)
        for (Index i = 0; i < size; ++i)
            points.row(layer * kKindCount + kindOf(i)) +=
                Vector3d(positions[layers[layer * size + i]].data()) / (i == 0 ? 1 : cellCount_);
    return points;
}

std::optional<double> EdgeRefinement::find(ControlPoints edge, const Vector3d& point,
                                           double distance) const {
    // Beyond this distance from the chord, in chords, the point is not near the edge.
    constexpr double kBend = 0.125;
    edge.rowwise() -= point.transpose();
    double low = 0, width = 1;
    for (int halving = 0;; ++halving, width /= 2) {
        const Vector3d from = limit_ * edge.topRows<9>(), to = limit_ * edge.bottomRows<9>();
        const Vector3d chord = to - from;
        const double length = chord.norm();
        const double at = std::clamp(-from.dot(chord) / (length * length), 0.0, 1.0);
        const double away = (from + at * chord).norm();
        // The comparison is such that a chord without length ends the search.
        if (!(away <= kBend * length + distance) || !(length > 0)) return std::nullopt;
        if (length <= distance || halving == kHalvings) {
            if (away > distance) return std::nullopt;
            return low + at * width;
        }
        // The general product is slower for matrices of this size.
        const Eigen::Matrix<double, 15, 3> halves = averages_.lazyProduct(edge);
        const Vector3d middle = limit_ * halves.middleRows<9>(kKindCount);
        const bool isHigh = middle.dot(chord) < 0;
        edge = halves.middleRows<12>(isHigh ? kKindCount : 0);
        if (isHigh) low += width / 2;
    }
}

EdgeRows EdgeRefinement::rowsAt(std::span<const Index> layers, double at) const {
    // The halves that contain the place, and the place in the last of them.
    std::array<bool, kHalvings> isHigh;
    for (bool& half : isHigh) {
        half = at > 0.5;
        at = 2 * at - half;
    }
    const Index nearest = at > 0.5 ? kKindCount : 0;
    Weights position = Weights::Zero(), along = Weights::Zero(), across = Weights::Zero();
    position.head<9>() = (1 - at) * limit_;
    position.tail<9>() += at * limit_;
    along.segment<9>(nearest) = along_;
    across.segment<9>(nearest) = across_;
    for (std::size_t k = isHigh.size(); k-- > 0;) {
        const Index first = isHigh[k] ? kKindCount : 0;
        position = position.lazyProduct(averages_.middleRows<12>(first)).eval();
        along = along.lazyProduct(averages_.middleRows<12>(first)).eval();
        across = across.lazyProduct(waves_.middleRows<12>(first)).eval();
        // The rounding of the sum would not shrink with the weights.
        along[kKindCount] -= along.sum();
    }
    along.normalize();
    across.normalize();
    EdgeRows rows;
    const Index size = layerSize(cellCount_);
    for (Index layer = 0; layer < kLayerCount; ++layer)
        for (Index i = 0; i < size; ++i) {
            const Index vertex = layers[layer * size + i], number = layer * kKindCount + kindOf(i);
            const double share = i == 0 ? 1 : 1.0 / cellCount_;
            rows.position.push_back({vertex, share * position[number]});
            rows.directions[0].push_back({vertex, share * along[number]});
            if (i == 0) continue;
            rows.directions[1].push_back({vertex, share * across[number] * cosines_[i]});
            rows.directions[2].push_back({vertex, share * across[number] * sines_[i]});
        }
    return rows;
}

const EdgeRefinement* EdgeRefinements::of(Index cellCount) const {
    const std::scoped_lock lock(mutex_);
    auto place = known_.find(cellCount);
    if (place == known_.end())
        place = known_.emplace(cellCount, EdgeRefinement::make(rules_, cellCount)).first;
    return place->second ? &*place->second : nullptr;
}

}  // namespace espalier::limit

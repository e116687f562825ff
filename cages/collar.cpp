// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/argument_error.h>
#include <espalier/base/bounding_box.h>
#include <espalier/base/error.h>
#include <espalier/base/number_text.h>
#include <espalier/base/sort_unique.h>
#include <espalier/base/vector3.h>
#include <espalier/cages/collar.h>
#include <espalier/far/box_grid.h>
#include <espalier/far/standard_cells.h>
#include <espalier/shapes/held.h>
#include <espalier/shapes/transform.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

#include "collar_cells.h"
#include "collar_extrusion.h"
#include "collar_grid.h"
#include "collar_proof.h"
#include "collar_reach.h"

namespace espalier::cages {
namespace {

void check(const Lattice& lattice, const CollarOptions& options) {
    if (lattice.complex.dimension() != 3 ||
        std::ssize(lattice.positions) != lattice.complex.count(0))
        throw Error("a collar needs a lattice of cells, with one position for each vertex");
    for (const Point3& position : lattice.positions)
        for (const double coordinate : position)
            if (!std::isfinite(coordinate))
                throw Error("a collar: a position of the lattice is not finite");
    if (options.layers < 1 || options.layers > kMaxCollarLayers)
        throw ArgumentError("collar", "layers", std::to_string(options.layers),
                            concat("1 to ", kMaxCollarLayers));
    if (options.held < 0 || options.held > options.layers)
        throw ArgumentError("collar", "held", std::to_string(options.held),
                            concat("1 to the number of layers (", options.layers, ")"));
    const bool hasReach = options.reach != 0;
    if (hasReach && !(options.reach > 0 && std::isfinite(options.reach)))
        throw ArgumentError("collar", "reach", textOf(options.reach), "a length above 0");
    if (hasReach == options.until.has_value())
        throw ArgumentError("collar", "reach", hasReach ? textOf(options.reach) : "",
                            hasReach ? "either a reach or until, not both"
                                     : "a length above 0, or a box to reach until");
    if (options.until)
        for (const Point3& corner : *options.until)
            for (const double coordinate : corner)
                if (!std::isfinite(coordinate))
                    throw ArgumentError("collar", "until", textOf(coordinate), "finite numbers");
    if (options.symmetry && (options.symmetry->axis < 0 || options.symmetry->axis > 2))
        throw ArgumentError("collar", "symmetry", std::to_string(options.symmetry->axis),
                            "axis 0, 1 or 2");
    shapes::requireHeldIsFree(lattice);
}

/// Returns the distance of each outer vertex, as Collar::reach has them; 0 for the vertices that do
/// not count.
std::vector<double> outerDistances(const Lattice& lattice, const CollarCells& cells, int layers) {
    if (!cells.isGrid) return distancesFromLattice(lattice, cells, layers);
    std::vector<double> distances(cells.vertices.size(), 0.0);
    for (std::size_t v = 0; v < cells.vertices.size(); ++v) {
        const CollarVertex& vertex = cells.vertices[v];
        if (vertex.layer == layers && vertex.isStraight)
            distances[v] = length(difference(vertex.position, lattice.positions[vertex.over]));
    }
    return distances;
}

/// Returns the smallest and the largest distance above 0.
std::array<double, 2> reachOf(std::span<const double> distances) {
    std::array<double, 2> reach = {std::numeric_limits<double>::max(), 0};
    for (const double distance : distances)
        if (distance > 0) reach = {std::min(reach[0], distance), std::max(reach[1], distance)};
    return reach;
}

/// \param before the lattice without the collar
Collar finished(const Lattice& before, Lattice lattice, const CollarCells& cells,
                const CollarOptions& options) {
    constexpr int kSmoothly = 2;
    const int heldLayers = options.held > 0 ? options.held : std::min(options.layers, kSmoothly);
    Collar result;
    result.reach = reachOf(outerDistances(before, cells, options.layers));
    const auto first = static_cast<Index>(before.positions.size());
    for (std::size_t v = 0; v < cells.vertices.size(); ++v)
        if (cells.vertices[v].layer > options.layers - heldLayers)
            result.held.push_back(first + static_cast<Index>(v));
    std::vector<Index> all = shapes::heldVertices(before);
    all.insert(all.end(), result.held.begin(), result.held.end());
    shapes::setHeldVertices(lattice, all);
    result.continuity = heldLayers < kSmoothly ? embed::Continuity::C0 : embed::Continuity::C2;
    result.isGrid = cells.isGrid;
    result.lattice = std::move(lattice);
    return result;
}

std::optional<far::BoxGrid> gridOf(const far::CellComplex& complex) {
    try {
        return far::asBoxGrid(complex);
    } catch (const far::TopologyError&) {
        return std::nullopt;
    }
}

/// Opens the ends of the lattice that are in a plane exactly.
void openSidesInPlane(const Lattice& lattice, const shapes::SymmetryPlane& plane,
                      std::array<bool, 6>& open) {
    const auto axis = std::size_t(plane.axis);
    const double at = plane.at.value_or(0);
    const BoundingBox box(lattice.positions);
    if (box.min[axis] == at) open[2 * axis] = true;
    if (box.max[axis] == at) open[2 * axis + 1] = true;
}

/// Tells whether most cells have a negative volume.
bool isMostlyInsideOut(const Lattice& lattice) {
    const far::CellComplex& complex = lattice.complex;
    Index positive = 0, negative = 0;
    for (Index cell = 0; cell < complex.count(3); ++cell) {
        const Point3& origin = lattice.positions[complex.relation(3, 0)[cell][0]];
        double volume = 0;
        for (const auto& loop : far::outwardLoops(complex, CellId(cell))) {
            std::vector<Point3> corners;
            for (const Index vertex : loop)
                corners.push_back(difference(lattice.positions[vertex], origin));
            volume += dot(mean(corners), areaVector(corners));
        }
        positive += volume > 0;
        negative += volume < 0;
    }
    return negative > positive;
}

/// Tries to make a collar in one way after the other, until one can be proved.
class CollarAttempts {
public:
    CollarAttempts(const Lattice& lattice, const CollarOptions& options, const CollarProof& proof)
        : lattice_(lattice), options_(options), proof_(proof) {}

    /// Returns nothing if no collar can be proved; lastFailure() then tells why.
    std::optional<Collar> best() {
        const auto grid = gridOf(lattice_.complex);
        if (!grid && options_.until)
            throw ArgumentError("collar", "until", "",
                                "a box lattice; set reach for a lattice of another shape");
        if (grid)
            if (auto result = asGrid(*grid)) return result;
        if (options_.until) return std::nullopt;
        return extruded(grid ? openFacesOfBox(lattice_, *grid, options_)
                             : openFacesAtEnds(lattice_, options_.open));
    }

    const CollarProof::Failure& lastFailure() const { return *last_; }

private:
    std::optional<Collar> asGrid(const far::BoxGrid& grid) {
        const auto cells = gridCollar(lattice_, grid, options_);
        if (!cells) return std::nullopt;
        if (auto result = attempt(*cells)) return result;
        if (options_.until) return std::nullopt;
        constexpr double kTether = 0.5;
        return attemptWithoutFolds(*cells, kTether);
    }

    std::optional<Collar> extruded(const OpenFaces& open) {
        // Cells that fold or overlap and vertices that are too far away get less room from try to
        // try. With another tether, the vertices find other places.
        constexpr int kTries = 5;
        constexpr double kTethers[] = {0.5, 0.3};
        constexpr double kLess = 0.6, kMuchLess = 0.4;
        std::vector<double> parts(lattice_.positions.size(), 1);
        for (int tried = 0; tried < kTries; ++tried) {
            const CollarCells cells = extrudedCollar(lattice_, options_, open, parts);
            if (tried == 0)
                if (auto result = attempt(cells)) return result;
            if (auto result = attemptWithoutFolds(cells, kTethers[tried % 2])) return result;
            const bool overlaps = last_->kind == CollarProof::FailureKind::Overlap;
            std::vector<Index> near = last_->vertices;
            sortUnique(near);
            for (const Index vertex : near) parts[vertex] *= overlaps ? kMuchLess : kLess;
        }
        return std::nullopt;
    }

    std::optional<Collar> attempt(const CollarCells& cells) {
        Lattice result = joined(lattice_, cells);
        auto failure = proof_.failure(result, cells);
        if (!failure) failure = tooThick(cells);
        if (!failure) return finished(lattice_, std::move(result), cells, options_);
        last_ = std::move(failure);
        return std::nullopt;
    }

    /// Moves the vertices so that no cell folds, and tries the result.
    /// \param tether as removeFolds() has it, for the first round
    std::optional<Collar> attemptWithoutFolds(const CollarCells& planned, double tether) {
        constexpr int kRounds = 8;
        constexpr double kMore = 8;
        constexpr double kTighter = 0.5;
        CollarCells cells = planned;
        std::vector<double> weights = weightsOf(joined(lattice_, planned).complex);
        for (int round = 0; round < kRounds; ++round) {
            removeFolds(lattice_, weights, planned.vertices, tether, cells);
            if (auto result = attempt(cells)) return result;
            if (last_->kind == CollarProof::FailureKind::Overlap) break;
            // Vertices that are too far away get shorter tethers, cells that still fold more
            // weight.
            if (last_->kind == CollarProof::FailureKind::TooThick)
                tether *= kTighter;
            else
                for (const Index cell : last_->cells) weights[std::size_t(cell)] *= kMore;
        }
        return std::nullopt;
    }

    /// Returns the weight 1 for the cells of the collar and the good cells of the lattice next to
    /// them, and 0 for the others.
    std::vector<double> weightsOf(const far::CellComplex& complex) const {
        std::vector<double> weights(std::size_t(complex.count(3)), 0.0);
        const auto wasBad = proof_.wasBad();
        for (Index cell = lattice_.complex.count(3); cell < complex.count(3); ++cell)
            for (const Index vertex : complex.relation(3, 0)[cell])
                for (const Index near : complex.relation(0, 3)[vertex])
                    weights[std::size_t(near)] =
                        near >= std::ssize(wasBad) || !wasBad[near] ? 1 : 0;
        return weights;
    }

    /// Returns the outer vertices of a collar around a lattice that are too far away.
    std::optional<CollarProof::Failure> tooThick(const CollarCells& cells) const {
        constexpr double kMostReach = 2;
        if (options_.until) return std::nullopt;
        CollarProof::Failure failure{CollarProof::FailureKind::TooThick};
        const auto distances = outerDistances(lattice_, cells, options_.layers);
        for (std::size_t v = 0; v < distances.size(); ++v)
            if (distances[v] > kMostReach * options_.reach)
                failure.vertices.push_back(cells.vertices[v].over);
        if (failure.vertices.empty()) return std::nullopt;
        return failure;
    }

    const Lattice& lattice_;
    const CollarOptions& options_;
    const CollarProof& proof_;
    std::optional<CollarProof::Failure> last_;  ///< of the last attempt
};

/// Returns the end of the message about a collar that cannot be made: options that work.
std::string wayOut(const Lattice& lattice, const CollarOptions& options, const CollarProof& proof) {
    if (options.until) return "; set reach instead of until, so that vertices can move";
    const auto works = [&](int layers, double reach) {
        CollarOptions other = options;
        other.layers = layers;
        other.reach = reach;
        other.held = std::min(options.held, layers);
        return CollarAttempts(lattice, other, proof).best().has_value();
    };
    for (int layers = options.layers / 2; layers > 0; layers /= 2)
        if (works(layers, options.reach))
            return concat("; a collar of ", layers, layers == 1 ? " layer" : " layers", " works");
    for (const double factor : {0.5, 2.0})
        if (works(options.layers, factor * options.reach))
            return concat("; a collar with the reach ", textOf(factor * options.reach), " works");
    return "; no collar with fewer layers, or with half or twice the reach, works either: make "
           "the lattice coarser, or take a box around it";
}

Collar collarOf(const Lattice& lattice, const CollarOptions& options) {
    const CollarProof proof(lattice);
    CollarAttempts attempts(lattice, options, proof);
    if (auto result = attempts.best()) return *result;
    const CollarProof::Failure& failure = attempts.lastFailure();
    const Index vertex = failure.mostFrequent();
    throw Error(concat("a collar: cells would ", failure.text(), " near vertex ", vertex,
                       " of the lattice at ", textOf(lattice.positions[vertex]),
                       wayOut(lattice, options, proof)));
}

}  // namespace

std::array<bool, 6> sidesOf(std::span<const std::string> words) {
    std::array<bool, 6> sides = {};
    for (const std::string& word : words) {
        bool isKnown = false;
        for (std::size_t side = 0; side < kSideWords.size(); ++side)
            if (word == kSideWords[side] || word == kSideWords[side] + 1)
                sides[side] = isKnown = true;
        if (!isKnown)
            throw ArgumentError("collar", "open", inQuotes(word),
                                "an axis x, y or z, or one side of it, such as +x or -z");
    }
    return sides;
}

Collar collar(const Lattice& lattice, const CollarOptions& given) {
    check(lattice, given);
    CollarOptions options = given;
    if (given.symmetry) openSidesInPlane(lattice, *given.symmetry, options.open);
    if (!isMostlyInsideOut(lattice)) return collarOf(lattice, options);
    Lattice right = lattice;
    right.complex = shapes::insideOut(lattice.complex);
    Collar result = collarOf(right, options);
    result.lattice.complex = shapes::insideOut(result.lattice.complex);
    return result;
}

}  // namespace espalier::cages

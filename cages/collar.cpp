// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/argument_error.h>
#include <espalier/base/bounding_box.h>
#include <espalier/base/error.h>
#include <espalier/base/number_text.h>
#include <espalier/base/sort_unique.h>
#include <espalier/base/vector3.h>
#include <espalier/cages/collar.h>
#include <espalier/embed/embedding.h>
#include <espalier/far/box_grid.h>
#include <espalier/far/complex_builder.h>
#include <espalier/limit/limit_parts.h>
#include <espalier/shapes/held.h>
#include <espalier/shapes/new_vertices.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/solve/validity.h>
#include <espalier/stencils/composition.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

#include "collar_cells.h"
#include "collar_extrusion.h"
#include "collar_grid.h"
#include "untangle.h"

namespace espalier::cages {
namespace {

/// Level to which limit::LimitParts refines irregular features for the proof.
constexpr int kLevelOfParts = 2;

void check(const Lattice& lattice, const CollarOptions& options) {
    constexpr int kMaxLayers = 100;
    if (lattice.complex.dimension() != 3 ||
        std::ssize(lattice.positions) != lattice.complex.count(0))
        throw Error("a collar needs a lattice of cells, with one position for each vertex");
    for (const Point3& position : lattice.positions)
        for (const double coordinate : position)
            if (!std::isfinite(coordinate))
                throw Error("a collar: a position of the lattice is not finite");
    if (options.layers < 1 || options.layers > kMaxLayers)
        throw ArgumentError("collar", "layers", std::to_string(options.layers), "1 to 100");
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
}

/// Adds the cells to the lattice.
Lattice joined(const Lattice& lattice, const CollarCells& cells) {
    std::vector<shapes::NewVertex> newVertices;
    for (const CollarVertex& vertex : cells.vertices)
        newVertices.push_back({vertex.position, {vertex.over}});
    Lattice result = shapes::withNewVertices(lattice, newVertices);
    far::ComplexBuilder builder(3, static_cast<Index>(result.positions.size()));
    for (Index cell = 0; cell < lattice.complex.count(3); ++cell)
        builder.addCell(far::outwardLoops(lattice.complex, CellId(cell)));
    for (const auto& [bottom, top] : cells.prisms) {
        const std::size_t n = bottom.size();
        std::vector<std::vector<Index>> loops = {{bottom.rbegin(), bottom.rend()}, top};
        for (std::size_t i = 0; i < n; ++i) {
            const std::size_t next = (i + 1) % n;
            loops.push_back({bottom[i], bottom[next], top[next], top[i]});
        }
        builder.addCell(loops);
    }
    result.complex = builder.build();
    const auto append = [](auto& marks, const auto& more) {
        marks.insert(marks.end(), more.begin(), more.end());
    };
    append(result.marks.edges, cells.marks.edges);
    append(result.marks.vertices, cells.marks.vertices);
    return result;
}

/// Removes folds from the cells by moving their vertices.
/// \param wasBad per cell of the lattice
void untangleCells(const Lattice& lattice, std::span<const char> wasBad, CollarCells& cells) {
    const Lattice whole = joined(lattice, cells);
    const far::CellComplex& complex = whole.complex;
    const Index count = lattice.complex.count(0);
    std::vector<VertexFreedom> freedoms(lattice.positions.size());
    for (const CollarVertex& vertex : cells.vertices)
        freedoms.push_back({true, vertex.planeNormal});
    // An edge that folds have shortened gets half the length of the edge of the lattice that it is
    // over.
    const auto over = [&](Index vertex) {
        return vertex < count ? vertex : cells.vertices[std::size_t(vertex - count)].over;
    };
    const double smallest = 1e-6 * BoundingBox(whole.positions).diagonal();
    std::vector<double> lengths;
    for (Index edge = 0; edge < complex.count(1); ++edge) {
        const auto ends = complex.relation(1, 0)[edge];
        const double now = length(difference(whole.positions[ends[0]], whole.positions[ends[1]]));
        const double below =
            length(difference(lattice.positions[over(ends[0])], lattice.positions[over(ends[1])]));
        lengths.push_back(std::max({now, 0.5 * below, smallest}));
    }
    // The cells of the collar, and the good cells of the lattice next to them.
    std::vector<char> isExamined(std::size_t(complex.count(3)), 0);
    for (Index cell = lattice.complex.count(3); cell < complex.count(3); ++cell)
        for (const Index vertex : complex.relation(3, 0)[cell])
            for (const Index near : complex.relation(0, 3)[vertex])
                isExamined[near] = near >= std::ssize(wasBad) || !wasBad[near];
    std::vector<Point3> positions = whole.positions;
    const far::TopologyRefiner base(complex, refinerOptions(whole));
    untangle(positions, {base, freedoms, lengths, isExamined});
    for (std::size_t v = 0; v < cells.vertices.size(); ++v)
        cells.vertices[v].position = positions[std::size_t(count) + v];
}

/// The proof that a lattice with a collar has no folds and no overlaps.
class Proof {
public:
    explicit Proof(const Lattice& before)
        : before_(before), wasBad_(std::size_t(before.complex.count(3)), 0) {
        const far::TopologyRefiner base(before.complex, refinerOptions(before));
        for (const Index cell : solve::cellsBadAtRest(base, before.positions)) wasBad_[cell] = 1;
    }

    /// Tells for each cell of the lattice whether it was bad before.
    std::span<const char> wasBad() const { return wasBad_; }

    /// Cells that cannot be proved.
    struct Failure {
        std::vector<Index> vertices;  ///< vertices of the lattice near them; at least one
        const char* what = "";
    };

    /// Returns nothing if all cells can be proved.
    std::optional<Failure> failure(const Lattice& lattice, const CollarCells& cells) const {
        const far::TopologyRefiner base(lattice.complex, refinerOptions(lattice));
        const auto fails = [&](std::span<const Index> bad, const char* what) {
            Failure failure{{}, what};
            for (const Index cell : bad)
                if (cell >= std::ssize(wasBad_) || !wasBad_[cell])
                    for (const Index vertex : lattice.complex.relation(3, 0)[cell])
                        failure.vertices.push_back(over(cells, vertex));
            return failure.vertices.empty() ? std::nullopt : std::optional(std::move(failure));
        };
        if (auto failure = fails(solve::cellsBadAtRest(base, lattice.positions), "fold"))
            return failure;
        const limit::LimitParts parts(base, kLevelOfParts);
        const solve::ValidityCheck check(parts, lattice.positions);
        if (auto failure = fails(check.badAtRest(), "fold in the limit")) return failure;
        return fails(overlaps(base, lattice), "overlap");
    }

private:
    Index over(const CollarCells& cells, Index vertex) const {
        const Index count = before_.complex.count(0);
        return vertex < count ? vertex : cells.vertices[std::size_t(vertex - count)].over;
    }

    /// Returns the base cells with a vertex of level 1 on the outer boundary that is in a cell
    /// apart.
    std::vector<Index> overlaps(far::TopologyRefiner base, const Lattice& lattice) const {
        base.refineUniform(1);
        const far::CellComplex& complex = base.level(1).complex;
        const auto positions = stencils::refinePositions(base, 1, lattice.positions);
        const Index firstNewCell = before_.complex.count(3);
        std::vector<char> isOuter(positions.size(), 0);
        for (Index face = 0; face < complex.count(2); ++face) {
            const auto owners = complex.relation(2, 3)[face];
            if (owners.size() != 1 || solve::baseCellOf(base, 1, owners[0]) < firstNewCell)
                continue;
            for (const Index vertex : complex.relation(2, 0)[face]) isOuter[vertex] = 1;
        }
        std::vector<Index> outer;
        std::vector<Point3> points;
        for (std::size_t vertex = 0; vertex < positions.size(); ++vertex) {
            if (!isOuter[vertex]) continue;
            outer.push_back(static_cast<Index>(vertex));
            points.push_back(positions[vertex]);
        }
        std::vector<Index> cells;
        const embed::Embedding places = embed::embedPoints(complex, positions, points);
        for (std::size_t i = 0; i < outer.size(); ++i) {
            const auto& place = places.points[i].place;
            if (!place) continue;
            const auto own = complex.relation(0, 3)[outer[i]];
            if (std::ranges::find(own, place->cell.value) != own.end()) continue;
            cells.push_back(solve::baseCellOf(base, 1, own[0]));
            cells.push_back(solve::baseCellOf(base, 1, place->cell.value));
        }
        return cells;
    }

    const Lattice& before_;
    std::vector<char> wasBad_;  ///< per cell of the lattice
};

Collar finished(Lattice lattice, const CollarCells& cells, const CollarOptions& options) {
    constexpr int kSmoothly = 2;
    const int heldLayers = options.held > 0 ? options.held : std::min(options.layers, kSmoothly);
    Collar result;
    const auto first = std::ssize(lattice.positions) - std::ssize(cells.vertices);
    result.reach = {std::numeric_limits<double>::max(), 0};
    std::vector<Index> all = shapes::heldVertices(lattice);
    // The new vertices have copies of the integers of the vertices that they are over.
    std::erase_if(all, [&](Index vertex) { return vertex >= first; });
    for (std::size_t v = 0; v < cells.vertices.size(); ++v) {
        const CollarVertex& vertex = cells.vertices[v];
        if (vertex.layer > options.layers - heldLayers)
            result.held.push_back(static_cast<Index>(first + static_cast<Offset>(v)));
        if (vertex.layer < options.layers || !vertex.isStraight) continue;
        const double reach = length(difference(vertex.position, lattice.positions[vertex.over]));
        result.reach = {std::min(result.reach[0], reach), std::max(result.reach[1], reach)};
    }
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

}  // namespace

std::array<bool, 6> sidesOf(const std::string& word) {
    std::array<bool, 6> sides = {};
    const auto known = std::ranges::find(kSideWords, word);
    if (known != kSideWords.end()) {
        sides[std::size_t(known - kSideWords.begin())] = true;
        return sides;
    }
    if (word.size() != 1 || word[0] < 'x' || word[0] > 'z')
        throw ArgumentError("collar", "open", inQuotes(word),
                            "an axis x, y or z, or one side of it, such as +x or -z");
    const auto axis = std::size_t(word[0] - 'x');
    sides[2 * axis] = sides[2 * axis + 1] = true;
    return sides;
}

std::array<bool, 6> sidesInPlane(const Lattice& lattice, int axis, double at) {
    if (axis < 0 || axis > 2)
        throw ArgumentError("sidesInPlane", "axis", std::to_string(axis), "0, 1 or 2");
    const BoundingBox box(lattice.positions);
    std::array<bool, 6> sides = {};
    sides[2 * std::size_t(axis)] = box.min[std::size_t(axis)] == at;
    sides[2 * std::size_t(axis) + 1] = box.max[std::size_t(axis)] == at;
    return sides;
}

Point3 sideDirection(std::size_t side) {
    Point3 direction = {0, 0, 0};
    direction[side / 2] = side % 2 == 1 ? 1 : -1;
    return direction;
}

std::vector<double> layerParts(int layers, double reach, double first) {
    // The sum of the layers, q^0 + ... + q^(layers − 1), grows with q.
    const auto total = [&](double q) {
        double sum = 0;
        for (int layer = 0; layer < layers; ++layer) sum += std::pow(q, layer);
        return sum;
    };
    const double wanted = first > 0 ? reach / first : 0;
    double low = 1, high = 1;
    if (layers > 1 && std::isfinite(wanted) && wanted > total(1)) {
        while (total(high) < wanted) high *= 2;
        constexpr int kHalvings = 60;
        for (int i = 0; i < kHalvings; ++i) {
            const double middle = 0.5 * (low + high);
            (total(middle) < wanted ? low : high) = middle;
        }
    }
    std::vector<double> parts = {0};
    double sum = 0;
    const double all = total(low);
    for (int layer = 0; layer < layers; ++layer) {
        sum += std::pow(low, layer);
        parts.push_back(layer + 1 == layers ? 1 : sum / all);
    }
    return parts;
}

Collar collar(const Lattice& lattice, const CollarOptions& options) {
    check(lattice, options);
    const Proof proof(lattice);
    std::optional<Proof::Failure> failed;
    const auto attempt = [&](const CollarCells& cells) -> std::optional<Collar> {
        Lattice result = joined(lattice, cells);
        failed = proof.failure(result, cells);
        if (failed) return std::nullopt;
        return finished(std::move(result), cells, options);
    };
    const auto grid = gridOf(lattice.complex);
    if (grid) {
        CollarCells cells = gridCollar(lattice, *grid, options);
        if (auto result = attempt(cells)) return *result;
        if (!options.until) {
            untangleCells(lattice, proof.wasBad(), cells);
            if (auto result = attempt(cells)) return *result;
        }
    }
    if (!grid || !options.until) {
        // Cells that fold or overlap get less room from try to try.
        constexpr int kTries = 3;
        constexpr double kLess = 0.6;
        std::vector<double> parts(lattice.positions.size(), 1);
        for (int tried = 0; tried < kTries; ++tried) {
            CollarCells cells = extrudedCollar(lattice, options, parts);
            if (tried == 0)
                if (auto result = attempt(cells)) return *result;
            untangleCells(lattice, proof.wasBad(), cells);
            if (auto result = attempt(cells)) return *result;
            sortUnique(failed->vertices);
            for (const Index vertex : failed->vertices) parts[vertex] *= kLess;
        }
    }
    const Index vertex = failed->vertices.front();
    throw Error(concat(
        "a collar: cells would ", failed->what, " near vertex ", vertex, " of the lattice at ",
        textOf(lattice.positions[vertex]),
        options.until ? "; give a reach instead of a box"
                      : "; give a smaller reach, more layers, or a lattice without narrow gaps"));
}

}  // namespace espalier::cages

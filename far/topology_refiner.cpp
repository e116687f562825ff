// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/memory.h>
#include <espalier/far/refinement.h>
#include <espalier/far/topology_error.h>
#include <espalier/far/topology_refiner.h>

#include <algorithm>
#include <string>
#include <utility>

namespace espalier::far {

namespace {

/// Throws if an edge or a vertex is semi-sharp. The rules of RATS have no such sharpness.
void checkNotSemiSharp(const Level& level) {
    if (!level.strata.hasSemiSharp()) return;
    for (int dimension = 0; dimension <= 1; ++dimension)
        for (Index index = 0; index < level.complex.count(dimension); ++index) {
            const float sharpness = level.strata.sharpness({dimension, index});
            if (sharpness == kSmooth || sharpness == kInfinitelySharp) continue;
            std::string name = concat("vertex ", index);
            if (dimension == 1) {
                const auto ends = level.complex.relation(1, 0)[index];
                const auto [low, high] = std::minmax(ends.front(), ends.back());
                name = concat("edge (", low, ", ", high, ")");
            }
            throw TopologyError(TopologyCause::BadMark, {dimension, index},
                                name +
                                    " is semi-sharp; under the rules of RATS everything is "
                                    "smooth or infinitely sharp");
        }
}

/// Checks that the rules can refine a level.
void checkRules(const Level& level, const RefinerOptions& options) {
    const bool isRats = options.rules == Rules::Rats;
    if (isRats && level.complex.dimension() == kMaxDimension)
        throw Error("the rules of RATS are for curves and meshes, not for lattices");
    if (isRats && options.boundary == Boundary::Open)
        throw Error("the rules of RATS do not have the boundary mode 'open'");
    if (isRats || options.rules == Rules::Mlca)
        if (options.triangles == TriangleSubdivision::Smooth)
            throw Error(concat("the rules of ", isRats ? "RATS" : "MLCA",
                               " do not have smooth triangles; use catmark"));
    if (isRats) checkNotSemiSharp(level);
}

}  // namespace

TopologyRefiner::TopologyRefiner(CellComplex base, const RefinerOptions& options)
    : options_(options) {
    Strata strata = classify(base, options.boundary, options.sharpEdges, options.marks);
    std::vector<Index> holes = readHoles(base, options.marks);
    levels_.push_back({std::move(base), std::move(strata), std::move(holes)});
    checkRules(levels_.front(), options_);
}

TopologyRefiner::TopologyRefiner(Level first, const RefinerOptions& options) : options_(options) {
    levels_.push_back(std::move(first));
    checkRules(levels_.front(), options_);
}

namespace {

ByEntity<std::uint8_t> marksOf(const CellComplex& complex, std::uint8_t mark) {
    ByEntity<std::uint8_t> marks;
    for (int d = 0; d <= complex.dimension(); ++d) marks[d].assign(complex.count(d), mark);
    return marks;
}

/// Marks the entities that are lower ends of children: those that are not on the open boundary.
ByEntity<std::uint8_t> closedEntities(const Level& parent) {
    ByEntity<std::uint8_t> closed = marksOf(parent.complex, 1);
    for (int d = 0; d <= parent.complex.dimension(); ++d)
        for (Index index = 0; index < parent.complex.count(d); ++index)
            if (parent.strata.isOpen({d, index})) closed[d][index] = 0;
    return closed;
}

/// Returns the children [v, f] of the holes.
std::vector<Index> refineHoles(const Level& parent, const Refinement& refinement) {
    std::vector<Index> holes;
    if (parent.holes.empty()) return holes;
    refinement.forEachChild(0, 2, [&](const Entity& child, const Interval& interval) {
        if (std::binary_search(parent.holes.begin(), parent.holes.end(), interval.upper.index))
            holes.push_back(child.index);
    });
    return holes;
}

}  // namespace

Refinement TopologyRefiner::splitWhole(const Level& parent, Boundary boundary) {
    if (boundary != Boundary::Open) return Refinement(parent.complex);
    const Refinement::Kept kept{closedEntities(parent), marksOf(parent.complex, 1)};
    return Refinement(parent.complex, &kept);
}

void TopologyRefiner::addLevel(Refinement refinement) {
    const Level& parent = levels_.back();
    Strata strata =
        refineStrata(parent.complex, parent.strata, refinement, boundary(), options_.creasing);
    addLevel(std::move(refinement), std::move(strata));
}

void TopologyRefiner::addLevel(Refinement refinement, Strata strata) {
    // Reserve memory first: an exception below then leaves the levels unchanged.
    refinements_.reserve(refinements_.size() + 1);
    levels_.reserve(levels_.size() + 1);
    Level next{refinement.child(), std::move(strata), refineHoles(levels_.back(), refinement)};
    refinements_.push_back(std::move(refinement));
    levels_.push_back(std::move(next));
}

namespace {

/// Throws if a level is too large, before the levels below it are made.
void checkSize(const CellComplex& complex, int levels, int level) {
    const LevelSize size = levelSize(complex, levels);
    const std::string name = concat("level ", level);
    for (int d = 0; d <= complex.dimension(); ++d)
        if (size.counts[d] > kMaxIndex)
            throw TopologyError(
                TopologyCause::TooManyEntities, {d, kMaxIndex},
                concat(name, " would have more than ", kMaxIndex, " entities of one dimension"));
    requireMemory(static_cast<std::uint64_t>(size.bytes()), name);
}

}  // namespace

void TopologyRefiner::refineUniform(int level) {
    // Without boundary control, levels are smaller by an amount that is not known in advance.
    if (level > maxLevel() && isUniform() && boundary() != Boundary::Open)
        checkSize(levels_.back().complex, level - maxLevel(), level);
    while (maxLevel() < level) {
        if (!isUniform())
            throw Error(concat("level ", maxLevel(),
                               " is refined around some cells only: there is no whole level ",
                               level));
        addLevel(splitWhole(levels_.back(), boundary()));
    }
}

namespace {

/// Returns `cells` and the cells that share a vertex with one of them, ascending.
std::vector<Index> grown(const CellComplex& complex, std::span<const Index> cells) {
    std::vector<std::uint8_t> isIn(complex.count(complex.dimension()));
    for (const Index cell : cells)
        for (const Index vertex : complex.relation(complex.dimension(), 0)[cell])
            for (const Index other : complex.relation(0, complex.dimension())[vertex])
                isIn[other] = 1;
    std::vector<Index> result;
    for (std::size_t cell = 0; cell < isIn.size(); ++cell)
        if (isIn[cell] != 0) result.push_back(static_cast<Index>(cell));
    return result;
}

/// Removes the mark of entities that have no vertex of one of `cells`.
void unmarkOutside(const CellComplex& complex, std::span<const Index> cells,
                   ByEntity<std::uint8_t>& marks) {
    std::vector<std::uint8_t> isCorner(complex.count(0), 0);
    for (const Index cell : cells)
        for (const Index vertex : complex.relation(complex.dimension(), 0)[cell])
            isCorner[vertex] = 1;
    for (int d = 0; d <= complex.dimension(); ++d) {
        const Incidence& vertices = complex.relation(d, 0);
        for (Index index = 0; index < complex.count(d); ++index) {
            const auto row = vertices[index];
            if (std::none_of(row.begin(), row.end(),
                             [&](Index vertex) { return isCorner[vertex] != 0; }))
                marks[d][index] = 0;
        }
    }
}

/// Marks cells and all entities that they contain.
ByEntity<std::uint8_t> marksIn(const CellComplex& complex, std::span<const Index> cells) {
    ByEntity<std::uint8_t> marks = marksOf(complex, 0);
    for (int d = 0; d <= complex.dimension(); ++d)
        for (const Index cell : cells)
            for (const Index part : complex.relation(complex.dimension(), d)[cell])
                marks[d][part] = 1;
    return marks;
}

}  // namespace

void TopologyRefiner::refineAround(std::span<const Index> cells, Extent extent) {
    const Level& parent = levels_.back();
    const auto refuse = [&](Index cell, const char* why) {
        throw Error(concat("cannot refine around cell ", cell, " of level ", maxLevel(), why));
    };
    if (cells.empty()) throw Error("there is no cell to refine around");
    for (std::size_t i = 0; i < cells.size(); ++i) {
        if (cells[i] < 0 || cells[i] >= parent.complex.count(dimension()))
            refuse(cells[i], ": there is no such cell");
        if (i > 0 && cells[i] <= cells[i - 1]) refuse(cells[i], ": cells must ascend");
        if (chosen_ &&
            !std::binary_search(chosen_->begin(), chosen_->end(),
                                refinements_.back().parentOf({dimension(), cells[i]}).upper.index))
            refuse(cells[i], ": the level was not refined around the cell that it is a child of");
    }
    Refinement::Kept kept{closedEntities(parent), {}};
    std::vector<Index> chosen;
    if (extent == Extent::Cells) {
        kept.upper = marksIn(parent.complex, cells);
    } else {
        kept.upper = marksOf(parent.complex, 1);
        chosen.assign(cells.begin(), cells.end());
        // Chaikin's rule uses the edges at both ends of an edge, so one more ring must be complete.
        if (options_.creasing == Creasing::Chaikin && parent.strata.hasSemiSharp())
            chosen = grown(parent.complex, chosen);
        unmarkOutside(parent.complex, chosen, kept.lower);
    }
    addLevel(Refinement(parent.complex, &kept));
    chosen_ = std::move(chosen);
}

namespace {

void checkLevel(int level, int first, int last) {
    if (level < first || level > last)
        throw Error(concat("there is no level ", level, " here: levels ", first, " to ", last,
                           " have been refined"));
}

}  // namespace

const Level& TopologyRefiner::level(int level) const {
    checkLevel(level, 0, maxLevel());
    return levels_[level];
}

const Refinement& TopologyRefiner::refinement(int level) const {
    checkLevel(level, 1, maxLevel());
    return refinements_[level - 1];
}

}  // namespace espalier::far

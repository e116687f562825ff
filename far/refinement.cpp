// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/far/refinement.h>

#include <numeric>
#include <string>

namespace espalier::far {

Refinement::Refinement(const CellComplex& parent, const Strata* open)
    : dimension_(parent.dimension()) {
    numberChildren(parent, open);
    if (childCounts_[static_cast<std::size_t>(dimension_)] == 0)
        throw TopologyError(TopologyCause::EmptyComplex, {dimension_, 0},
                            std::string("refined without boundary control, the complex has no ") +
                                dimensionName(dimension_) + " left: it has no interior vertex");
    CellComplex::Boundaries boundaries;
    for (int d = 1; d <= dimension_; ++d)
        boundaries[static_cast<std::size_t>(d) - 1] = childBoundary(parent, d);
    child_ = CellComplex(dimension_, childCounts_[0], std::move(boundaries));
}

void Refinement::numberChildren(const CellComplex& parent, const Strata* open) {
    for (int d = 0; d <= dimension_; ++d) {
        Offset count = 0;
        for (int lower = 0; lower + d <= dimension_; ++lower) {
            const int upper = lower + d;
            Family& family =
                families_[static_cast<std::size_t>(lower)][static_cast<std::size_t>(upper)];
            const auto isKept = [&](Index index) {
                return open == nullptr || !open->isOpen({lower, index});
            };
            family.firstChild = static_cast<Index>(count);
            // Counted before they are made.
            const auto parts = parent.relation(upper, lower).values();
            count += std::count_if(parts.begin(), parts.end(), isKept);
            if (count > kMaxIndex)
                throw TopologyError(TopologyCause::TooManyEntities, {d, kMaxIndex},
                                    "the refined complex has more than " +
                                        std::to_string(kMaxIndex) + " entities of one dimension");
            family.lowerEnds = Incidence(
                buildRows<Index>(parent.count(upper), [&](Index index, std::vector<Index>& row) {
                    for (const Index part : parent.relation(upper, lower)[index])
                        if (isKept(part)) row.push_back(part);
                }));
        }
        childCounts_[static_cast<std::size_t>(d)] = static_cast<Index>(count);
    }
}

Index Refinement::childIndex(Entity lower, Entity upper) const {
    const Family& f = family(lower.dimension, upper.dimension);
    const auto row = f.lowerEnds[upper.index];
    const auto at = std::find(row.begin(), row.end(), lower.index) - row.begin();
    return f.firstChild + static_cast<Index>(f.lowerEnds.offset(upper.index) + at);
}

/// The child whose lower end is at `position` in the parent's row of the upper end.
Index Refinement::childAt(const CellComplex& parent, int lower, Entity upper,
                          std::size_t position) const {
    const Family& f = family(lower, upper.dimension);
    const auto all = parent.relation(upper.dimension, lower)[upper.index];
    const auto kept = f.lowerEnds[upper.index];
    const auto dropped =
        all.size() == kept.size()
            ? 0
            : std::count_if(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(position),
                            [&](Index part) { return !contains(kept, part); });
    return f.firstChild + static_cast<Index>(f.lowerEnds.offset(upper.index) +
                                             static_cast<Offset>(position) - dropped);
}

SignedIncidence Refinement::childBoundary(const CellComplex& parent, int dimension) const {
    // Rows for all families of this dimension, one after the other: as the children are numbered.
    Rows<Signed> all;
    for (int lower = 0; lower + dimension <= dimension_; ++lower) {
        const Family& f = family(lower, lower + dimension);
        const Incidence& parts = parent.relation(lower + dimension, lower);
        // Of each child, the upper end and the position of the lower one in it.
        std::vector<std::pair<Entity, std::size_t>> ends;
        ends.reserve(f.lowerEnds.values().size());
        for (Index upper = 0; upper < f.lowerEnds.rowCount(); ++upper) {
            const bool isWhole = f.lowerEnds[upper].size() == parts[upper].size();
            for (std::size_t position = 0; position < parts[upper].size(); ++position)
                if (isWhole || contains(f.lowerEnds[upper], parts[upper][position]))
                    ends.emplace_back(Entity{lower + dimension, upper}, position);
        }
        const Rows<Signed> rows = buildRows<Signed>(
            static_cast<Index>(ends.size()), [&](Index child, std::vector<Signed>& out) {
                const auto& [upper, position] = ends[static_cast<std::size_t>(child)];
                if (upper.dimension < kMaxDimension)
                    appendBoundaryInLoop(parent, lower, upper, position, out);
                else
                    appendBoundaryInCell(parent, {lower, parts[upper.index][position]}, upper, out);
            });
        const Offset shift = all.offsets.back();
        for (std::size_t row = 1; row < rows.offsets.size(); ++row)
            all.offsets.push_back(rows.offsets[row] + shift);
        all.values.insert(all.values.end(), rows.values.begin(), rows.values.end());
    }
    return SignedIncidence(all);
}

// With σ(x, y) the incidence number of y in the boundary of x, and d = dim b − dim a,
//
//     ∂[a,b] = Σ σ(b,b') [a,b']  +  (−1)^d Σ σ(a',a) [a',b]
//
// over the b' of one dimension less than b, and the a' of one more than a, inside [a,b]. The sign
// (−1)^d makes the mixed terms of ∂∂ cancel, so a coherently oriented parent has a coherently
// oriented child, and [v,c] is oriented as c is.

/// The boundary of [a, b] in an edge or a face b. By positions, not by names: a loop may pass a
/// vertex more than once (degenerate faces of meshes).
void Refinement::appendBoundaryInLoop(const CellComplex& parent, int lower, Entity upper,
                                      std::size_t position, std::vector<Signed>& boundary) const {
    const SignedIncidence& sides = parent.boundary(upper.dimension);
    const auto vertexChild = [&](Entity entity) {
        return childAt(parent, entity.dimension, entity, 0);
    };
    const auto negated = [](int sign) { return static_cast<std::int8_t>(-sign); };
    if (lower + 1 == upper.dimension) {
        // From [a,a] to [b,b], or the other way round; the tail comes first.
        const std::int8_t sign = sides.signs(upper.index)[position];
        const Signed first{vertexChild({lower, sides[upper.index][position]}), sign};
        const Signed last{vertexChild(upper), negated(sign)};
        boundary.insert(boundary.end(), {sign < 0 ? first : last, sign < 0 ? last : first});
        return;
    }
    // A corner of a face: the loop leaves the vertex along one edge, and has entered along another.
    const auto edges = sides[upper.index];
    const std::size_t before = (position + edges.size() - 1) % edges.size();
    const Entity leaving{1, edges[position]}, entering{1, edges[before]};
    const std::int8_t leavingSign = sides.signs(upper.index)[position];
    const std::int8_t enteringSign = sides.signs(upper.index)[before];
    const std::size_t tailOfLeaving = leavingSign > 0 ? 0 : 1;
    const std::size_t headOfEntering = enteringSign > 0 ? 1 : 0;
    boundary.insert(boundary.end(), {{childAt(parent, 0, leaving, tailOfLeaving), leavingSign},
                                     {childAt(parent, 1, upper, position), negated(leavingSign)},
                                     {childAt(parent, 1, upper, before), enteringSign},
                                     {childAt(parent, 0, entering, headOfEntering), enteringSign}});
}

/// The boundary of [a, b] in a cell b.
void Refinement::appendBoundaryInCell(const CellComplex& parent, Entity lower, Entity upper,
                                      std::vector<Signed>& boundary) const {
    const int d = upper.dimension - lower.dimension;
    const auto begin = static_cast<std::ptrdiff_t>(boundary.size());

    const auto isIn = [&](Entity part, Entity whole) {
        return contains(family(part.dimension, whole.dimension).lowerEnds[whole.index], part.index);
    };
    const auto signOf = [&](Entity whole, Index part) {
        const SignedIncidence& rows = parent.boundary(whole.dimension);
        const auto row = rows[whole.index];
        const auto at = std::find(row.begin(), row.end(), part) - row.begin();
        return rows.signs(whole.index)[static_cast<std::size_t>(at)];
    };

    // [a, b'] for the b' in the boundary of b that contain a.
    const SignedIncidence& down = parent.boundary(upper.dimension);
    for (std::size_t i = 0; i < down[upper.index].size(); ++i) {
        const Entity middle{upper.dimension - 1, down[upper.index][i]};
        if (isIn(lower, middle))
            boundary.push_back({childIndex(lower, middle), down.signs(upper.index)[i]});
    }
    // [a', b] for the a' in b whose boundary contains a.
    const int up = lower.dimension + 1;
    for (const Index index : family(up, upper.dimension).lowerEnds[upper.index]) {
        const Entity middle{up, index};
        if (!isIn(lower, middle)) continue;
        const int sign = (d % 2 == 0 ? 1 : -1) * signOf(middle, lower.index);
        boundary.push_back({childIndex(middle, upper), static_cast<std::int8_t>(sign)});
    }

    const auto entries = std::span(boundary).subspan(static_cast<std::size_t>(begin));
    if (d == 1) {
        // Tail first.
        if (entries[0].sign > 0) std::swap(entries[0], entries[1]);
    } else if (d == 2) {
        // Collected as [a,x] [a,y] [x,b] [y,b] up to the order of the last two. The loop leaves
        // [a,a] along the edge whose sign is that of an edge with its tail in [a,a].
        const auto leavesLower = [&](const Signed& edge) {
            const Entity child{1, edge.index};
            return edge.sign == -signOf(parentOf(child).upper, lower.index);
        };
        Signed first = entries[0], last = entries[1];
        if (!leavesLower(first)) std::swap(first, last);
        const Entity x = parentOf({1, first.index}).upper;
        Signed second = entries[2], third = entries[3];
        if (parentOf({1, second.index}).lower != x) std::swap(second, third);
        entries[0] = first;
        entries[1] = second;
        entries[2] = third;
        entries[3] = last;
    }
}

Interval Refinement::parentOf(Entity child) const {
    // The last family of this dimension that starts at or before the child and is not empty.
    int lower = 0;
    while (lower + 1 + child.dimension <= dimension_ &&
           family(lower + 1, lower + 1 + child.dimension).firstChild <= child.index)
        ++lower;
    const int upper = lower + child.dimension;
    const Family& f = family(lower, upper);
    const Offset at = child.index - f.firstChild;
    // The last row that starts at or before the position.
    Index first = 0;
    for (Index length = f.lowerEnds.rowCount(); length > 0;) {
        const Index half = length / 2;
        if (f.lowerEnds.offset(first + half + 1) <= at) {
            first += half + 1;
            length -= half + 1;
        } else {
            length = half;
        }
    }
    return {{lower, f.lowerEnds.values()[static_cast<std::size_t>(at)]}, {upper, first}};
}

std::optional<Entity> Refinement::childOf(const Interval& interval) const {
    if (interval.lower.dimension > interval.upper.dimension ||
        interval.upper.dimension > dimension_)
        return std::nullopt;
    const Family& f = family(interval.lower.dimension, interval.upper.dimension);
    if (!contains(f.lowerEnds[interval.upper.index], interval.lower.index)) return std::nullopt;
    return Entity{interval.upper.dimension - interval.lower.dimension,
                  childIndex(interval.lower, interval.upper)};
}

}  // namespace espalier::far

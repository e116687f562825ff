// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/cell_complex.h>
#include <espalier/far/strata.h>

#include <array>
#include <optional>

namespace espalier::far {

/// A pair of entities of the parent complex, the lower contained in or equal to the upper.
struct Interval {
    Entity lower;
    Entity upper;
    friend bool operator==(const Interval&, const Interval&) = default;
};

/// One split of a complex. The children are the incidence intervals [a, b] of the parent; the
/// dimension of a child is dim b − dim a:
///
///     vertex   one per entity: [v,v] vertex points, [e,e] edge points, [f,f] face points,
///              [c,c] cell points
///     edge     [v,e]  [e,f]  [f,c]
///     face     [v,f]  [e,c]             always a quadrilateral
///     cell     [v,c]                    of type n, where n edges of c meet in v: 2n quadrilaterals
///
/// [a,b] is bounded by the [a,b'] and the [a',b] of one dimension less. This is the reconnection of
/// the papers; one code path serves curves, meshes and lattices, regular or not.
///
/// Children of a dimension are numbered by the dimension of a, then by b, then by the order of a in
/// b. So the child vertices are the vertex points in the order of the vertices, then the edge
/// points, the face points and the cell points. A child quadrilateral's loop runs from [a,a] by way
/// of one of the two entities between a and b to [b,b], and by way of the other one back.
///
/// \cite MacCracken & Joy 1996, section 2.2; Joy & MacCracken CSE-96-1, section 6
class Refinement {
public:
    /// Splits `parent`. With `open`, the strata of a complex without boundary control, just the
    /// intervals whose lower end is not open are kept.
    ///
    /// \throws TopologyError (TooManyEntities; EmptyComplex if no child of the parent's dimension
    ///         is left)
    /// \cost O(entries of the child × entities of a parent cell), in parallel
    explicit Refinement(const CellComplex& parent, const Strata* open = nullptr);

    const CellComplex& child() const { return child_; }

    /// The interval that a child entity stands for. \cost O(log entities)
    Interval parentOf(Entity child) const;

    /// The child that stands for an interval; nothing if `interval.lower` is not in
    /// `interval.upper` or was not kept. Where a face of a mesh passes its lower end more than once
    /// there is a child for each time, and this is the first. \cost O(entities in the upper end)
    std::optional<Entity> childOf(const Interval& interval) const;

    /// Calls visit(child, interval) for every child, in the order of their dimensions and numbers.
    /// \cost O(children)
    template <class Visit>
    void forEachChild(Visit visit) const {
        for (int d = 0; d <= dimension_; ++d)
            for (int lower = 0; lower + d <= dimension_; ++lower) {
                const Family& f = family(lower, lower + d);
                Index child = f.firstChild;
                for (Index upper = 0; upper < f.lowerEnds.rowCount(); ++upper)
                    for (const Index part : f.lowerEnds[upper])
                        visit(Entity{d, child++}, Interval{{lower, part}, {lower + d, upper}});
            }
    }

private:
    /// The kept intervals with ends of dimensions `lower` ≤ `upper`: row b lists the a in it.
    struct Family {
        Incidence lowerEnds;
        Index firstChild = 0;
    };
    const Family& family(int lower, int upper) const {
        return families_[static_cast<std::size_t>(lower)][static_cast<std::size_t>(upper)];
    }
    void numberChildren(const CellComplex& parent, const Strata* open);
    SignedIncidence childBoundary(const CellComplex& parent, int dimension) const;
    void appendBoundaryInLoop(const CellComplex& parent, int lower, Entity upper,
                              std::size_t position, std::vector<Signed>& boundary) const;
    void appendBoundaryInCell(const CellComplex& parent, Entity lower, Entity cell,
                              std::vector<Signed>& boundary) const;
    Index childIndex(Entity lower, Entity upper) const;
    Index childAt(const CellComplex& parent, int lower, Entity upper, std::size_t position) const;

    int dimension_ = 0;
    std::array<std::array<Family, kMaxDimension + 1>, kMaxDimension + 1> families_;
    std::array<Index, kMaxDimension + 1> childCounts_ = {};
    CellComplex child_;
};

}  // namespace espalier::far

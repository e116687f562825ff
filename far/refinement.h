// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/parallel.h>
#include <espalier/far/cell_complex.h>
#include <espalier/far/topology_error.h>

#include <array>
#include <cstdint>
#include <optional>
#include <type_traits>
#include <vector>

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
/// The boundary of [a,b] consists of the intervals [a,b'] and [a',b] whose dimension is lower by
/// one. This is the reconnection of the papers; the same code serves curves, meshes and lattices,
/// regular or not.
///
/// Children of a dimension are numbered by the dimension of a, then by b, then by the order of a in
/// b. So the child vertices are the vertex points in the order of the vertices, then the edge
/// points, the face points and the cell points. The loop of a child quadrilateral runs from [a,a]
/// through one of the two entities between a and b to [b,b], and back through the other one.
///
/// \cite MacCracken & Joy 1996, section 2.2; Joy & MacCracken CSE-96-1, section 6
class ESPALIER_API Refinement {
public:
    /// Selects the intervals to keep: both ends of an interval must have a mark other than 0.
    struct Kept {
        ByEntity<std::uint8_t> lower;  ///< an entity that contains a marked one must be marked too
        ByEntity<std::uint8_t> upper;  ///< an entity that a marked one contains must be marked too
    };

    /// Splits `parent`. With `kept`, the child has only the selected intervals, numbered in the
    /// same order.
    ///
    /// \throws TopologyError (TooManyEntities; EmptyComplex if no child of the parent's dimension
    ///         is left)
    /// \cost O(entries of the child), in parallel; slightly more in cells with very many faces
    explicit Refinement(const CellComplex& parent, const Kept* kept = nullptr);

    const CellComplex& child() const { return child_; }

    /// Returns the interval of a child entity. \cost O(log entities)
    Interval parentOf(Entity child) const;

    /// Returns the child of an interval; nothing if `interval.lower` is not in `interval.upper`, or
    /// the interval was not kept. If a face of a mesh passes its lower end several times, each time
    /// has a child, and this returns the first. \cost O(entities in the upper end)
    std::optional<Entity> childOf(const Interval& interval) const;

    /// Calls visit(child, interval) for every child with ends of these dimensions, in the order of
    /// the children's numbers. \cost O(children)
    template <class Visit>
    void forEachChild(int lower, int upper, Visit visit) const {
        withWhole([&](auto isWhole) {
            const auto family = numbers<isWhole>(lower, upper);
            for (Index row = 0; row < family.rowCount(); ++row)
                for (Offset entry = family.offset(row); entry < family.offset(row + 1); ++entry)
                    if (family.isKept(entry))
                        visit(Entity{upper - lower, family.child(entry)},
                              Interval{{lower, family.part(entry)}, {upper, row}});
        });
    }

    /// The same for every child, in the order of dimensions and numbers.
    template <class Visit>
    void forEachChild(Visit visit) const {
        for (int d = 0; d <= dimension_; ++d)
            for (int lower = 0; lower + d <= dimension_; ++lower)
                forEachChild(lower, lower + d, visit);
    }

    /// Gives each child the value of its upper end, whose interior contains the child.
    /// \param values one per entity of the parent
    /// \cost O(children), in parallel
    template <class T>
    ByEntity<T> inherit(const ByEntity<T>& values) const {
        ByEntity<T> result;
        for (int d = 0; d <= dimension_; ++d) {
            auto& ofChildren = result[d];
            ofChildren.resize(child_.count(d));
            for (int lower = 0; lower + d <= dimension_; ++lower)
                withWhole([&](auto isWhole) {
                    spread(numbers<isWhole>(lower, lower + d), values[lower + d], ofChildren);
                });
        }
        return result;
    }

private:
    /// The intervals with ends of dimensions `lower` ≤ `upper`. Row b of `parts` lists the entities
    /// a in b. The entry of an interval is the position of its a in the values of `parts`.
    struct Family {
        const Incidence* parts = nullptr;  ///< a relation of parent_
        Index firstChild = 0;
        Index childCount = 0;
        bool isWhole = true;               ///< every interval is kept; otherwise:
        std::vector<Index> childOfEntry;   ///< relative to firstChild; kMaxIndex if not kept
        std::vector<Offset> entryOfChild;  ///< ascending

        void drop(const std::vector<std::uint8_t>& lower, const std::vector<std::uint8_t>& upper);
    };

    /// The numbers of a family, to be copied into loops. The compiler can keep a local copy in
    /// registers; it would read a Family again after each write of an index.
    /// \tparam kIsWhole true if every interval of every family is kept
    template <bool kIsWhole>
    class Numbers {
    public:
        explicit Numbers(const Family& family)
            : parts_(family.parts->values().data()),
              starts_(family.parts->starts()),
              firstChild_(family.firstChild),
              childOfEntry_(family.childOfEntry.data()) {}

        Index rowCount() const { return starts_.rowCount; }
        Offset offset(Index row) const { return starts_[row]; }
        Index part(Offset entry) const { return parts_[entry]; }
        bool isKept(Offset entry) const { return kIsWhole || childOfEntry_[entry] != kMaxIndex; }
        Index child(Offset entry) const {
            return firstChild_ + (kIsWhole ? static_cast<Index>(entry) : childOfEntry_[entry]);
        }

    private:
        const Index* parts_;
        RowStarts::View starts_;
        Index firstChild_;
        const Index* childOfEntry_;
    };

    template <bool kIsWhole>
    Numbers<kIsWhole> numbers(int lower, int upper) const {
        return Numbers<kIsWhole>(families_[lower][upper]);
    }

    /// Calls use(std::true_type()) if every interval is kept, else use(std::false_type()).
    template <class Use>
    decltype(auto) withWhole(Use use) const {
        return isWhole_ ? use(std::true_type()) : use(std::false_type());
    }

    template <class T, bool kIsWhole>
    static void spread(const Numbers<kIsWhole>& family, const std::vector<T>& ofRows,
                       std::vector<T>& ofChildren) {
        parallelFor(family.rowCount(), 1 << 14, [&](Offset first, Offset last) {
            const Numbers<kIsWhole> numbers = family;
            T* const children = ofChildren.data();
            for (Offset row = first; row < last; ++row) {
                const auto r = static_cast<Index>(row);
                const T value = ofRows[row];
                const Offset end = numbers.offset(r + 1);
                for (Offset entry = numbers.offset(r); entry < end; ++entry)
                    if (numbers.isKept(entry)) children[numbers.child(entry)] = value;
            }
        });
    }

    void numberChildren(const Kept* kept);
    std::uint64_t leastBytes() const;
    struct Quadrilaterals;
    template <bool kIsWhole>
    SignedIncidence childEdges() const;
    template <bool kIsWhole>
    void addCorners(Quadrilaterals& quadrilaterals) const;
    template <bool kIsWhole>
    RowStarts startsOfCorners() const;
    template <bool kIsWhole>
    SignedIncidence addSides(Quadrilaterals& quadrilaterals) const;

    CellComplex parent_;
    int dimension_ = 0;
    std::array<std::array<Family, kMaxDimension + 1>, kMaxDimension + 1> families_;
    std::array<Index, kMaxDimension + 1> childCounts_ = {};
    bool isWhole_ = true;  ///< every interval is kept
    CellComplex child_;
};

/// The size of a level of a complex. The numbers are in floating point, because the size of a level
/// that is too large to build may exceed every integer type. They are exact up to 2^53.
struct LevelSize {
    std::array<double, kMaxDimension + 1> counts = {};  ///< entities of each dimension

    double faceEdges = 0;     ///< number of pairs of a face and an edge of it
    double cellFaces = 0;     ///< number of pairs of a cell and a face of it
    double cellEdges = 0;     ///< number of pairs of a cell and an edge of it
    double cellVertices = 0;  ///< number of pairs of a cell and a vertex of it

    /// Returns the least number of bytes of its CellComplex, without derived relations.
    double bytes() const;
};

/// Returns the size of a level without refining. (Under Boundary::Open, levels are smaller.)
///
/// \param levels number of levels above `complex`, 0 or more
/// \cost O(1), plus the relations of `complex`, which refinement derives anyway
/// \cite Azlan & Misro, Table 2, for the counts of polyhedra; the rest follows from the intervals
///       of Refinement
ESPALIER_API LevelSize levelSize(const CellComplex& complex, int levels);

}  // namespace espalier::far

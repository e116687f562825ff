// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/array.h>
#include <espalier/base/hash.h>
#include <espalier/base/parallel.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "number_bits.h"
#include "row_sets.h"

namespace espalier::osd {
namespace {

/// Returns a bit mask of the columns. A set can be a subset only of sets that have all of its bits.
std::uint64_t maskOf(std::span<const Index> columns) {
    std::uint64_t mask = 0;
    for (const Index column : columns)
        mask |= std::uint64_t{1} << ((static_cast<std::uint64_t>(column) * kHashFactor) >> 58);
    return mask;
}

/// Returns a hash of columns, not 0. It is a polynomial with the columns as coefficients: the
/// products of four columns do not wait for each other.
std::uint64_t hashOfColumns(std::span<const Index> columns) {
    constexpr std::uint64_t f = kHashFactor, f2 = f * f, f3 = f2 * f, f4 = f3 * f;
    const auto at = [&](std::size_t i) { return static_cast<std::uint64_t>(columns[i]); };
    std::uint64_t hash = columns.size();
    std::size_t i = 0;
    for (; i + 4 <= columns.size(); i += 4)
        hash = hash * f4 + (at(i) * f3 + at(i + 1) * f2 + at(i + 2) * f + at(i + 3));
    for (; i < columns.size(); ++i) hash = hash * f + at(i);
    return std::max<std::uint64_t>(appendedHash(hash, 0), 1);
}

/// Numbers sets of columns in the order in which rows bring them. This is a hash table.
class SetNumbers {
public:
    /// Returns the number of the set of a row.
    std::uint32_t numberOf(std::span<const Index> columns, std::uint64_t hash) {
        if (slots_.size() < 2 * std::size_t{count_ + 1}) grow();
        Slot* slot = firstSlot(hash);
        while (slot->hash != 0 && !(slot->hash == hash &&
                                    haveSameBits(std::span(slot->columns, slot->length), columns)))
            slot = next(slot);
        if (slot->hash == 0)
            *slot = {hash, columns.data(), static_cast<std::uint32_t>(columns.size()), count_++};
        return slot->number;
    }

    // Prefetch what numberOf() will read: first the slot, later the columns that it refers to.
    void prefetchSlot(std::uint64_t hash) { __builtin_prefetch(firstSlot(hash)); }
    void prefetchColumns(std::uint64_t hash) { __builtin_prefetch(firstSlot(hash)->columns); }

    Index count() const { return static_cast<Index>(count_); }

private:
    struct Slot {
        std::uint64_t hash = 0;  ///< 0 if there is no set here
        const Index* columns = nullptr;
        std::uint32_t length = 0;
        std::uint32_t number = 0;
    };

    Slot* firstSlot(std::uint64_t hash) { return &slots_[hash >> shift_]; }
    Slot* next(Slot* slot) { return slot == &slots_.back() ? slots_.data() : slot + 1; }

    void grow() {
        --shift_;
        const std::vector<Slot> before =
            std::exchange(slots_, std::vector<Slot>(2 * slots_.size()));
        for (const Slot& each : before) {
            if (each.hash == 0) continue;
            Slot* slot = firstSlot(each.hash);
            while (slot->hash != 0) slot = next(slot);
            *slot = each;
        }
    }

    int shift_ = 60;  ///< the highest bits of a hash are the place of its slot
    std::vector<Slot> slots_ = std::vector<Slot>(16);
    std::uint32_t count_ = 0;
};

/// Groups the rows of a table by their columns: set → its rows. Sets are in the order of their
/// first rows.
template <class Real>
InverseIndex<Index> groupRows(const stencils::StencilTable<Real>& table) {
    constexpr Offset kGrain = 4096;
    const Index rowCount = table.rowCount();
    // Neighbouring rows often have the same columns, and to compare two rows is faster than to hash
    // one. 0 stands for the hash of a row that has the columns of the row before.
    Array<std::uint64_t> hashes(rowCount);
    parallelFor(rowCount, kGrain, [&](Offset first, Offset last) {
        for (auto row = static_cast<Index>(first); row < last; ++row)
            hashes[row] = row > 0 && haveSameBits(table.columns(row - 1), table.columns(row))
                              ? 0
                              : hashOfColumns(table.columns(row));
    });
    // The number of the set takes the place of the hash: fresh memory is slow. Prefetching halves
    // the time of a table of a million rows and more.
    SetNumbers sets;
    Array<std::uint64_t>& setOf = hashes;
    std::uint64_t set = 0;
    for (Index row = 0; row < rowCount; ++row) {
        constexpr Index kAhead = 16;
        if (row + 2 * kAhead < rowCount) {
            if (const auto later = hashes[row + 2 * kAhead]; later != 0) sets.prefetchSlot(later);
            if (const auto soon = hashes[row + kAhead]; soon != 0) sets.prefetchColumns(soon);
        }
        if (hashes[row] != 0) set = sets.numberOf(table.columns(row), hashes[row]);
        setOf[row] = set;
    }
    return {sets.count(), [&](auto found) {
                for (Index row = 0; row < rowCount; ++row)
                    found(static_cast<Index>(setOf[row]), row);
            }};
}

/// Returns the superset of each set.
template <class Real>
std::vector<Index> supersetsOf(const stencils::StencilTable<Real>& table,
                               const InverseIndex<Index>& sets) {
    const auto columnsOf = [&](Index set) { return table.columns(sets.of(set).front()); };
    std::vector<Index> supersetOf(sets.count());
    std::iota(supersetOf.begin(), supersetOf.end(), Index{0});
    // Goes from the largest set to the smallest, so that a superset has no superset other than
    // itself.
    std::size_t longest = 0;
    for (Index set = 0; set < sets.count(); ++set)
        longest = std::max(longest, columnsOf(set).size());
    const InverseIndex<Index> bySize(static_cast<Index>(longest) + 1, [&](auto found) {
        for (Index set = 0; set < sets.count(); ++set)
            found(static_cast<Index>(longest - columnsOf(set).size()), set);
    });
    std::vector<std::uint64_t> masks;
    for (Index set = 0; set < sets.count(); ++set) masks.push_back(maskOf(columnsOf(set)));
    std::vector<std::vector<Index>> supersetsWith(table.columnCount());
    for (const Index set : bySize.places()) {
        const auto columns = columnsOf(set);
        if (columns.empty()) continue;
        // Searches among the supersets that contain the rarest of the columns. At a vertex with
        // very many edges there are many such supersets. The search is limited, because a missed
        // superset costs little.
        constexpr std::size_t kMaxTried = 256, kMaxSizeRatio = 3;
        const auto& supersets =
            supersetsWith[*std::min_element(columns.begin(), columns.end(), [&](Index a, Index b) {
                return supersetsWith[a].size() < supersetsWith[b].size();
            })];
        const auto last =
            supersets.begin() + static_cast<std::ptrdiff_t>(std::min(supersets.size(), kMaxTried));
        const auto superset = std::find_if(supersets.begin(), last, [&](Index candidate) {
            return (masks[set] & ~masks[candidate]) == 0 &&
                   columnsOf(candidate).size() <= kMaxSizeRatio * columns.size() &&
                   std::ranges::includes(columnsOf(candidate), columns);
        });
        if (superset != last) {
            supersetOf[set] = *superset;
            continue;
        }
        for (const Index column : columns) supersetsWith[column].push_back(set);
    }
    return supersetOf;
}

}  // namespace

template <class Real>
RowSets::RowSets(const stencils::StencilTable<Real>& table) : rows_(groupRows(table)) {
    const std::vector<Index> supersetOf = supersetsOf(table, rows_);
    subsets_ = {count(), [&](auto found) {
                    for (Index set = 0; set < count(); ++set) found(supersetOf[set], set);
                }};
}

template RowSets::RowSets(const stencils::StencilTable<float>&);
template RowSets::RowSets(const stencils::StencilTable<double>&);

}  // namespace espalier::osd

// SPDX-License-Identifier: Apache-2.0
#include "shared_numbers.h"

#include <espalier/base/parallel.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>
#include <unordered_map>

#include "number_bits.h"

namespace espalier::osd {

using kernels::kLanes;
using stencils::StencilTable;

namespace {

/// The numbers of one group of a form.
template <class Real>
class GroupNumbers {
public:
    /// \param order in which they are stored
    /// \param uses number of supersets with this form
    GroupNumbers(const StencilTable<Real>& table, NumberOrder order, SupersetForm<Real>& form,
                 std::size_t group, Index uses)
        : table_(&table), order_(order), form_(&form), group_(group), uses_(uses) {}

    Index uses() const { return uses_; }

    std::uint64_t key() const { return group().key; }

    /// Returns a hash of the numbers and the size. It does not depend on the order of the rows.
    std::uint64_t hash() const {
        const auto& size = group().size;
        const std::uint64_t kind[] = {
            static_cast<std::uint64_t>(group().columnCount), static_cast<std::uint64_t>(size[0]),
            static_cast<std::uint64_t>(size[1]), static_cast<std::uint64_t>(size[2])};
        std::uint64_t hash = hashOf(std::span<const std::uint64_t>(kind));
        // A sum does not depend on the order of the rows.
        std::vector<Real> spread;
        for (Index i = 0; i < group().rowCount; ++i) hash += hashOf(row(i, spread));
        return hash;
    }

    /// Sorts the rows by the bits of their numbers. The order has no meaning; it only puts
    /// identical rows side by side.
    void sortRows() {
        const std::size_t count = rowCount(), length = this->length();
        std::vector<Real> numbers, spread;
        numbers.reserve(count * length);
        for (Index i = 0; i < group().rowCount; ++i) {
            const auto own = row(i, spread);
            numbers.insert(numbers.end(), own.begin(), own.end());
        }
        const auto first = [&](Index i) { return numbers.data() + i * length; };
        std::vector<Index> order(count);
        std::iota(order.begin(), order.end(), Index{0});
        std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) {
            return std::memcmp(first(a), first(b), length * sizeof(Real)) < 0;
        });
        const std::span<Index> own = slots();
        const std::vector<Index> unsorted(own.begin(), own.end());
        for (std::size_t i = 0; i < count; ++i) {
            own[i] = unsorted[order[i]];
            if (isProduct())
                std::copy_n(first(order[i]), length,
                            form_->factors.data() + group().firstFactor + i * length);
        }
    }

    bool hasSameNumbers(const GroupNumbers& other) const {
        const auto &a = group(), &b = other.group();
        if (a.size != b.size || a.rowCount != b.rowCount || a.columnCount != b.columnCount)
            return false;
        std::vector<Real> spread, otherSpread;
        for (Index i = 0; i < a.rowCount; ++i)
            if (!std::ranges::equal(row(i, spread), other.row(i, otherSpread))) return false;
        return true;
    }

    /// Returns true if the weights of an outer product are stored instead of its factors.
    bool isMultipliedOut() const {
        return order_ == NumberOrder::Adjoint && isProduct() &&
               !kernels::adjointTakesFactors(group().size[0], group().columnCount);
    }

    /// Returns how many numbers are stored: whole registers, so that each group is aligned.
    Offset storedCount() const {
        const auto roundedUp = [](std::size_t count) {
            constexpr std::size_t lanes = kLanes<Real>;
            return static_cast<Offset>((count + lanes - 1) / lanes * lanes);
        };
        if (order_ == NumberOrder::Panels)
            return roundedUp(rowCount()) * static_cast<Offset>(length());
        return roundedUp(rowCount() * storedLength());
    }

    /// The slot of the first number in the compiled table.
    Offset first() const { return group().firstNumber; }
    void setFirst(Offset number) { form_->groups[group_].firstNumber = number; }

    void store(const kernels::Kernels<Real>& kernels, Real* to) const {
        if (order_ == NumberOrder::Panels)
            storePanels(kernels, to);
        else
            storeForAdjoint(kernels, to);
    }

    /// Says that the numbers are weights, if they have been stored so.
    void setKind() {
        if (isMultipliedOut()) form_->groups[group_].size = {};
    }

private:
    using Group = typename SupersetForm<Real>::Group;

    /// Stores the numbers in panels, one row in each lane.
    void storePanels(const kernels::Kernels<Real>& kernels, Real* to) const {
        constexpr Index lanes = kLanes<Real>;
        constexpr std::size_t kLine = 64 / sizeof(Real);
        std::array<std::vector<Real>, lanes> spread;
        const std::vector<Real> zeros(length(), Real{0});
        for (Index first = 0; first < group().rowCount; first += lanes) {
            std::array<const Real*, lanes> numbers;
            for (Index lane = 0; lane < lanes; ++lane) {
                const Index i = first + lane;
                numbers[lane] = i < group().rowCount ? row(i, spread[lane]).data() : zeros.data();
                // Prefetches the same lane of the next panel: without this, storing weights takes
                // 1.6 times as long.
                if (isProduct() || i + lanes >= group().rowCount) continue;
                const auto later = weights(i + lanes);
                for (std::size_t k = 0; k < later.size(); k += kLine)
                    __builtin_prefetch(later.data() + k);
            }
            kernels.interleave(numbers.data(), static_cast<Offset>(length()), to);
            to += lanes * static_cast<Offset>(length());
        }
    }

    /// Stores the numbers in the order of AdjointRun, and zeros up to the next group.
    void storeForAdjoint(const kernels::Kernels<Real>& kernels, Real* to) const {
        Real* const last = to + storedCount();
        const bool isFactors = isProduct() && !isMultipliedOut();
        const std::size_t atOnce =
            isFactors ? storedLength() : static_cast<std::size_t>(kernels.adjointColumns);
        std::vector<Real> spread, product;
        for (std::size_t first = 0; first < rowCount(); first += kernels::kAdjointRows) {
            const std::size_t count =
                std::min(rowCount() - first, std::size_t{kernels::kAdjointRows});
            for (std::size_t i = 0; i < count; ++i) {
                auto own = row(static_cast<Index>(first + i), spread);
                if (isMultipliedOut()) own = multipliedOut(own, product);
                for (Real* part = to; !own.empty();) {
                    const std::size_t width = std::min(own.size(), atOnce);
                    std::copy_n(own.begin(), width, part + i * width);
                    part += count * width;
                    own = own.subspan(width);
                }
            }
            to += count * storedLength();
        }
        std::fill(to, last, Real{0});
    }

    /// Returns the weights of an outer product.
    std::span<const Real> multipliedOut(std::span<const Real> factors,
                                        std::vector<Real>& weights) const {
        const auto& size = group().size;
        const Real *const a = factors.data(), *const b = a + size[0], *const c = b + size[1];
        weights.clear();
        for (Index z = 0; z < size[2]; ++z)
            for (Index y = 0; y < size[1]; ++y)
                for (Index x = 0; x < size[0]; ++x) weights.push_back(a[x] * (b[y] * c[z]));
        return weights;
    }

    const Group& group() const { return form_->groups[group_]; }
    bool isProduct() const { return group().size[0] > 0; }
    std::size_t rowCount() const { return group().rowCount; }
    std::size_t length() const { return group().length(); }
    /// How many numbers of a row are stored.
    std::size_t storedLength() const {
        return isMultipliedOut() ? static_cast<std::size_t>(group().columnCount) : length();
    }
    std::span<Index> slots() const {
        return std::span(form_->slots).subspan(group().firstSlot, group().rowCount);
    }
    /// Returns the weights of row i in the table.
    std::span<const Real> weights(Index i) const {
        return table_->weights(form_->first.rows[slots()[i]]);
    }
    /// Returns the numbers of row i.
    std::span<const Real> row(Index i, std::vector<Real>& spread) const {
        return form_->numbersOf(*table_, group(), i, spread);
    }

    const StencilTable<Real>* table_;
    NumberOrder order_;
    SupersetForm<Real>* form_;
    std::size_t group_;
    Index uses_;
};

/// Calls body(g) for each group, in parallel.
template <class Real, class Body>
void forEach(const std::vector<GroupNumbers<Real>>& groups, Body body) {
    constexpr Offset kGrain = 16;
    parallelFor(std::ssize(groups), kGrain, [&](Offset first, Offset last) {
        for (Offset g = first; g < last; ++g) body(g);
    });
}

/// Finds groups with identical numbers and sorts their rows, so that they can share the numbers.
/// Returns for each group the first group with the same numbers.
template <class Real>
std::vector<std::size_t> findSources(std::vector<GroupNumbers<Real>>& groups) {
    // Hashes only groups that may be alike.
    std::unordered_map<std::uint64_t, Index> keyCounts, hashCounts;
    for (const auto& group : groups) keyCounts[group.key()] += group.uses();
    std::vector<char> mayShare(groups.size());
    for (std::size_t g = 0; g < groups.size(); ++g) mayShare[g] = keyCounts[groups[g].key()] > 1;
    std::vector<std::uint64_t> hashes(groups.size());
    forEach(groups, [&](std::size_t g) {
        if (mayShare[g]) hashes[g] = groups[g].hash();
    });
    for (std::size_t g = 0; g < groups.size(); ++g)
        if (mayShare[g]) hashCounts[hashes[g]] += groups[g].uses();
    // A group that shares its numbers with no other keeps the order of its rows, so that results
    // that are close in memory are written together.
    for (std::size_t g = 0; g < groups.size(); ++g)
        if (mayShare[g]) mayShare[g] = hashCounts[hashes[g]] > 1;
    std::vector<std::size_t> sources(groups.size());
    std::unordered_map<std::uint64_t, std::size_t> firstGroups;
    for (std::size_t g = 0; g < groups.size(); ++g)
        sources[g] = mayShare[g] ? firstGroups.try_emplace(hashes[g], g).first->second : g;
    forEach(groups, [&](std::size_t g) {
        if (mayShare[g]) groups[g].sortRows();
    });
    // Groups with the same hash have the same numbers, except in one case of 2^64.
    forEach(groups, [&](std::size_t g) {
        if (sources[g] != g && !groups[g].hasSameNumbers(groups[sources[g]])) sources[g] = g;
    });
    return sources;
}

}  // namespace

template <class Real>
void storeNumbers(const StencilTable<Real>& table, NumberOrder order,
                  const kernels::Kernels<Real>& kernels, std::vector<FormBlock<Real>>& blocks,
                  AlignedVector<Real>& numbers) {
    std::vector<GroupNumbers<Real>> groups;
    for (FormBlock<Real>& block : blocks) {
        std::vector<Index> uses(block.forms.size(), 0);
        for (const Index form : block.formOf) ++uses[form];
        for (std::size_t f = 0; f < block.forms.size(); ++f)
            for (std::size_t g = 0; g < block.forms[f].groups.size(); ++g)
                groups.emplace_back(table, order, block.forms[f], g, uses[f]);
    }
    const std::vector<std::size_t> sources = findSources(groups);
    Offset count = 0;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        if (sources[g] != g) {
            groups[g].setFirst(groups[sources[g]].first());
            continue;
        }
        groups[g].setFirst(count);
        count += groups[g].storedCount();
    }
    // Kernels add the lane to this pointer also for rows without entries, so it must not be null.
    // The adjoint reads beyond the last row.
    numbers.reserve(count + kLanes<Real>);
    numbers.resize(count);
    if (order == NumberOrder::Adjoint) numbers.resize(count + kLanes<Real>, Real{0});
    forEach(groups, [&](std::size_t g) {
        if (sources[g] == g) groups[g].store(kernels, numbers.data() + groups[g].first());
    });
    for (auto& group : groups) group.setKind();
}

template void storeNumbers(const StencilTable<float>&, NumberOrder, const kernels::Kernels<float>&,
                           std::vector<FormBlock<float>>&, AlignedVector<float>&);
template void storeNumbers(const StencilTable<double>&, NumberOrder,
                           const kernels::Kernels<double>&, std::vector<FormBlock<double>>&,
                           AlignedVector<double>&);

}  // namespace espalier::osd

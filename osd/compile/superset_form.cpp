// SPDX-License-Identifier: Apache-2.0
#include "superset_form.h"

#include <espalier/base/hash.h>
#include <espalier/osd/kernels/kernels.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <numeric>
#include <optional>
#include <unordered_map>
#include <utility>

#include "number_bits.h"
#include "outer_product.h"
#include "table_compiler.h"

namespace espalier::osd {

using kernels::kLanes;
using stencils::StencilTable;

void Superset::assign(const RowSets& sets, Index superset) {
    columns = sets.columnsOf(superset);
    rows.clear();
    subsets.assign(1, 0);
    for (const Index set : sets.subsetsOf(superset)) {
        const auto own = sets.rowsOf(set);
        rows.insert(rows.end(), own.begin(), own.end());
        subsets.push_back(static_cast<Index>(rows.size()));
    }
}

template <class Real>
std::span<const Real> SupersetForm<Real>::numbersOf(const StencilTable<Real>& table,
                                                    const Group& group, Index i,
                                                    std::vector<Real>& spread) const {
    if (group.size[0] > 0)
        return std::span(factors).subspan(group.firstFactor + i * group.length(), group.length());
    const Index row = first.rows[slots[group.firstSlot + i]];
    const auto weights = table.weights(row);
    if (std::ssize(weights) == group.columnCount) return weights;
    // Only groups with all columns of the superset have rows that lack some columns.
    spread.assign(first.columns.size(), 0);
    const auto own = table.columns(row);
    for (std::size_t k = 0, position = 0; k < own.size(); ++k) {
        while (first.columns[position] != own[k]) ++position;
        spread[position] = weights[k];
    }
    return spread;
}

namespace {

/// Finds the forms of supersets, one after the other.
template <class Real>
class FormFinder {
public:
    FormFinder(const StencilTable<Real>& table, const kernels::Kernels<Real>& kernels)
        : table_(table), kernels_(kernels) {}

    SupersetForm<Real> find(const Superset& superset) {
        form_ = {};
        form_.first = superset;
        addPositions();
        shared_.resize(superset.columns.size());
        std::iota(shared_.begin(), shared_.end(), Index{0});
        slots_.resize(superset.rows.size());
        std::iota(slots_.begin(), slots_.end(), Index{0});
        weights_.clear();
        for (const Index row : superset.rows) weights_.push_back(table_.weights(row).data());
        if (2 * superset.rows.size() < kLanes<Real>)
            form_.ungrouped = slots_;
        else
            addGroups();
        return std::move(form_);
    }

private:
    /// Adds the rows to groups, as far as they fill panels.
    void addGroups() {
        const auto product = findProduct();
        if (product)
            form_.factors.reserve(slots_.size() *
                                  (product->size[0] + product->size[1] + product->size[2]));
        products_.clear();
        left_.clear();
        std::span<const Index> later = form_.subsetPositions;
        for (std::size_t subset = 0; subset < form_.first.subsetCount(); ++subset) {
            std::span<const Index> others = slotsOf(subset);
            const auto positions = later.first(table_.columns(rowAt(others.front())).size());
            later = later.subspan(positions.size());
            if (product) {
                addFactors(*product, positions, others);
                others = others_;
            }
            // Full panels use the subset's own columns.
            const std::size_t full = others.size() / kLanes<Real> * kLanes<Real>;
            addPanels(others.first(full), positions);
            // With the superset's columns, the remaining rows need zeros for the columns that they
            // lack. Rows that would take more memory in this way stay ungrouped.
            const bool fits =
                shared_.size() * sizeof(Real) <= positions.size() * (sizeof(Real) + sizeof(Index));
            append(fits ? left_ : form_.ungrouped, others.subspan(full));
        }
        if (product) add(products_, product->order, product->size);
        // Uses the superset's columns for all remaining rows, for the rows that fill panels, or for
        // no rows, whichever is the first that saves memory.
        const std::size_t full = left_.size() / kLanes<Real> * kLanes<Real>;
        const std::size_t paneled = isSmaller(left_)                          ? left_.size()
                                    : isSmaller(std::span(left_).first(full)) ? full
                                                                              : 0;
        addPanels(std::span(left_).first(paneled), shared_);
        append(form_.ungrouped, std::span(left_).subspan(paneled));
    }

    Index rowAt(Index slot) const { return form_.first.rows[slot]; }

    std::span<const Index> slotsOf(std::size_t subset) const {
        const Index first = form_.first.subsets[subset], last = form_.first.subsets[subset + 1];
        return std::span(slots_).subspan(first, last - first);
    }

    std::span<const Real* const> weightsOf(std::span<const Index> consecutive) const {
        return std::span(weights_).subspan(consecutive.front(), consecutive.size());
    }

    /// Searches the rows with all columns: the rows of one subset, which is the superset.
    std::optional<OuterProduct> findProduct() const {
        for (std::size_t subset = 0; subset < form_.first.subsetCount(); ++subset) {
            const auto slots = slotsOf(subset);
            if (table_.columns(rowAt(slots.front())).size() == shared_.size())
                return findOuterProduct(weightsOf(slots), shared_.size());
        }
        return std::nullopt;
    }

    /// Finds the positions of the columns of all subsets.
    void addPositions() {
        const Superset& superset = form_.first;
        for (std::size_t subset = 0; subset < superset.subsetCount(); ++subset)
            for (std::size_t position = 0;
                 const Index column : table_.columns(rowAt(superset.subsets[subset]))) {
                while (superset.columns[position] != column) ++position;
                form_.subsetPositions.push_back(static_cast<Index>(position));
            }
    }

    /// Adds the factors of rows to the form. Puts rows that are not this kind of outer product into
    /// others_.
    void addFactors(const OuterProduct& product, std::span<const Index> positions,
                    std::span<const Index> slots) {
        factorizeRows(kernels_, product, positions, weightsOf(slots), form_.factors, isProduct_);
        others_.clear();
        for (std::size_t i = 0; i < slots.size(); ++i)
            (isProduct_[i] ? products_ : others_).push_back(slots[i]);
    }

    void addPanels(std::span<const Index> slots, std::span<const Index> positions) {
        add(slots, positions, {});
    }

    /// Adds groups of at most kMaxRowsPerGroup rows.
    /// \param size of outer products, whose factors were added before; zeros for panels
    void add(std::span<const Index> slots, std::span<const Index> positions,
             const std::array<Index, 3>& size) {
        std::size_t firstFactor = 0;
        while (!slots.empty()) {
            const auto part = slots.first(std::min(slots.size(), kMaxRowsPerGroup));
            form_.groups.push_back({static_cast<Index>(form_.positions.size()),
                                    static_cast<Index>(positions.size()),
                                    static_cast<Index>(form_.slots.size()),
                                    static_cast<Index>(part.size()), firstFactor, size, 0, 0});
            append(form_.positions, positions);
            append(form_.slots, part);
            auto& group = form_.groups.back();
            group.key = keyOf(group);
            firstFactor += part.size() * group.length();
            slots = slots.subspan(part.size());
        }
    }

    /// Returns a number that is equal for groups with the same numbers, whatever the order of the
    /// rows: a sum over the rows. Of a row of weights, it takes the first one that is not 0,
    /// because the weights of a whole group may not be in the cache.
    std::uint64_t keyOf(const typename SupersetForm<Real>::Group& group) const {
        std::uint64_t sum = static_cast<std::uint64_t>(group.rowCount) * group.length();
        for (Index i = 0; i < group.rowCount; ++i) {
            const std::span<const Real> numbers =
                group.size[0] > 0
                    ? std::span(form_.factors).subspan(group.firstFactor + i * group.length())
                    : table_.weights(rowAt(form_.slots[group.firstSlot + i]));
            const auto isZero = [](Real number) {
                return std::bit_cast<BitsOf<Real>>(number) == 0;
            };
            const auto first = std::find_if_not(numbers.begin(), numbers.end(), isZero);
            if (first != numbers.end()) sum += std::bit_cast<BitsOf<Real>>(*first);
        }
        return sum;
    }

    /// Returns true if rows take at most as much memory in panels with the superset's columns as
    /// they take ungrouped.
    bool isSmaller(std::span<const Index> slots) const {
        constexpr std::size_t lanes = kLanes<Real>;
        std::size_t entries = 0;
        for (const Index slot : slots) entries += table_.columns(rowAt(slot)).size();
        const std::size_t padded = (slots.size() + lanes - 1) / lanes * lanes * shared_.size();
        return padded * sizeof(Real) + shared_.size() * sizeof(Index) +
                   sizeof(typename CompiledRows<Real>::Group) <=
               entries * (sizeof(Real) + sizeof(Index));
    }

    static void append(std::vector<Index>& all, std::span<const Index> more) {
        all.insert(all.end(), more.begin(), more.end());
    }

    const StencilTable<Real>& table_;
    const kernels::Kernels<Real>& kernels_;
    SupersetForm<Real> form_;

    // find() works on these. They are members so that all supersets use the same memory.
    std::vector<Index> shared_;         ///< 0, 1, …: positions of the superset's columns
    std::vector<Index> slots_;          ///< 0, 1, …: slots of all rows
    std::vector<const Real*> weights_;  ///< the weights of all rows, by slot
    std::vector<char> isProduct_;       ///< whether each row of a subset is an outer product
    std::vector<Index> products_;       ///< slots of rows that are outer products
    std::vector<Index> others_;         ///< slots of rows of a subset that are not
    std::vector<Index> left_;  ///< slots of rows that do not fill panels with the columns of their
                               ///< set
};

/// Returns true if a superset has the same weights as the first superset with a form.
template <class Real>
bool hasForm(const StencilTable<Real>& table, const Superset& superset,
             const SupersetForm<Real>& form) {
    if (superset.columns.size() != form.first.columns.size() ||
        superset.subsets != form.first.subsets)
        return false;
    const Index* position = form.subsetPositions.data();
    for (std::size_t subset = 0; subset < superset.subsetCount(); ++subset) {
        const Index first = superset.subsets[subset];
        const auto columns = table.columns(superset.rows[first]);
        if (columns.size() != table.columns(form.first.rows[first]).size()) return false;
        for (const Index column : columns)
            if (superset.columns[*position++] != column) return false;
    }
    for (std::size_t slot = 0; slot < superset.rows.size(); ++slot)
        if (!haveSameBits(table.weights(superset.rows[slot]), table.weights(form.first.rows[slot])))
            return false;
    return true;
}

/// Returns a number that is the same for supersets with the same weights: a hash of the weights of
/// the first row of each subset.
template <class Real>
std::uint64_t keyOf(const StencilTable<Real>& table, const Superset& superset) {
    std::uint64_t key = superset.columns.size();
    for (std::size_t subset = 0; subset < superset.subsetCount(); ++subset) {
        const Index row = superset.rows[superset.subsets[subset]];
        key = appendedHash(key, hashOf(table.weights(row)));
    }
    return key;
}

}  // namespace

template <class Real>
void findForms(const StencilTable<Real>& table, const RowSets& sets,
               const kernels::Kernels<Real>& kernels, FormBlock<Real>& block) {
    FormFinder<Real> finder(table, kernels);
    std::unordered_map<std::uint64_t, Index> formWith;
    Superset superset, next;
    // Also prefetches the columns of each subset, and the ends of all rows of weights, if there are
    // few. The rows come from all over the table: without prefetching, this function takes twice as
    // long.
    constexpr std::size_t kFewRows = 256;
    const auto assignNext = [&](std::size_t i) {
        if (i == block.supersets.size()) return;
        next.assign(sets, block.supersets[i]);
        for (std::size_t subset = 0; subset < next.subsetCount(); ++subset)
            __builtin_prefetch(table.columns(next.rows[next.subsets[subset]]).data());
        if (next.rows.size() > kFewRows) return;
        for (const Index row : next.rows) {
            const auto weights = table.weights(row);
            __builtin_prefetch(weights.data());
            __builtin_prefetch(weights.data() + weights.size());
        }
    };
    assignNext(0);
    for (std::size_t i = 0; i < block.supersets.size(); ++i) {
        std::swap(superset, next);
        assignNext(i + 1);
        const auto [found, isNew] = formWith.try_emplace(keyOf(table, superset));
        if (isNew || !hasForm(table, superset, block.forms[found->second])) {
            found->second = static_cast<Index>(block.forms.size());
            block.forms.push_back(finder.find(superset));
        }
        block.formOf.push_back(found->second);
    }
}

template struct SupersetForm<float>;
template struct SupersetForm<double>;
template void findForms(const StencilTable<float>&, const RowSets&, const kernels::Kernels<float>&,
                        FormBlock<float>&);
template void findForms(const StencilTable<double>&, const RowSets&,
                        const kernels::Kernels<double>&, FormBlock<double>&);

}  // namespace espalier::osd

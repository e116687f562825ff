// SPDX-License-Identifier: Apache-2.0
#include "table_compiler.h"
#include "group_list.h"
#include "outer_product.h"
#include "row_runs.h"
#include "row_sets.h"

#include <algorithm>
#include <span>
#include <utility>

namespace espalier::osd {
namespace {

using kernels::kLanes;
using stencils::StencilTable;

/// About so many rows are a task, which one thread evaluates.
constexpr Index kRowsOfTask = 4096;

template <class Real>
class TableCompiler {
public:
    explicit TableCompiler(const StencilTable<Real>& table) : table_(table) {}

    CompiledRows<Real> compile() {
        const std::vector<RowSet> sets = findRowSets(table_);
        std::vector<std::vector<std::size_t>> guests(sets.size());
        for (std::size_t set = 0; set < sets.size(); ++set) guests[sets[set].host].push_back(set);
        for (std::size_t host = 0; host < sets.size(); ++host)
            if (!guests[host].empty()) addHost(sets, host, guests[host]);
        groups_.moveTo(result_);
        addRuns(table_, std::move(alone_), result_);
        addTasks();
        result_.groups.shrink_to_fit();
        result_.groupColumns.shrink_to_fit();
        result_.groupNumbers.shrink_to_fit();
        result_.groupRows.shrink_to_fit();
        result_.runs.shrink_to_fit();
        result_.columns.shrink_to_fit();
        result_.weights.shrink_to_fit();
        result_.rows.shrink_to_fit();
        return std::move(result_);
    }

private:
    /// Adds the rows of a host and its guests, as far as they fill panels.
    void addHost(const std::vector<RowSet>& sets, std::size_t host,
                 const std::vector<std::size_t>& guests) {
        const std::vector<Index>& own = sets[host].rows;
        shared_ = table_.columns(own.front());
        std::size_t rowCount = 0;
        for (const std::size_t set : guests) rowCount += sets[set].rows.size();
        if (2 * rowCount < kLanes<Real>) {
            for (const std::size_t set : guests) append(alone_, sets[set].rows);
            return;
        }
        std::vector<std::span<const Real>> weights;
        for (const Index row : own) weights.push_back(table_.weights(row));
        const auto product = findOuterProduct<Real>(weights);
        std::vector<Index> products, left;
        std::vector<Real> factors;
        for (const std::size_t set : guests) {
            std::vector<Index> others;
            for (const Index row : sets[set].rows)
                (product && addFactors(*product, row, factors) ? products : others).push_back(row);
            // Panels of the guest's own columns as far as they are full.
            const std::size_t full = others.size() / kLanes<Real> * kLanes<Real>;
            addPanels(std::span(others).first(full), table_.columns(sets[set].rows.front()));
            // With zeros for the columns that a row lacks it may take more room than alone.
            const std::size_t ownCount = table_.columns(sets[set].rows.front()).size();
            const bool fits =
                shared_.size() * sizeof(Real) <= ownCount * (sizeof(Real) + sizeof(Index));
            append(fits ? left : alone_, std::span(others).subspan(full));
        }
        if (product) addProducts(*product, products, factors);
        // What is left together, with the host's columns: all of it, or full panels, or none.
        const std::size_t full = left.size() / kLanes<Real> * kLanes<Real>;
        const std::size_t paneled = isSmaller(left)                          ? left.size()
                                    : isSmaller(std::span(left).first(full)) ? full
                                                                             : 0;
        addPanels(std::span(left).first(paneled), shared_);
        append(alone_, std::span(left).subspan(paneled));
    }

    /// Whether rows take no more room in panels of the host's columns than alone.
    bool isSmaller(std::span<const Index> rows) const {
        constexpr std::size_t lanes = kLanes<Real>;
        std::size_t entries = 0;
        for (const Index row : rows) entries += table_.columns(row).size();
        const std::size_t padded = (rows.size() + lanes - 1) / lanes * lanes * shared_.size();
        return padded * sizeof(Real) + shared_.size() * sizeof(Index) +
                   sizeof(typename CompiledRows<Real>::Group) <=
               entries * (sizeof(Real) + sizeof(Index));
    }

    static void append(std::vector<Index>& all, std::span<const Index> more) {
        all.insert(all.end(), more.begin(), more.end());
    }

    /// The weights of a row over columns that hold its own, with zeros.
    std::vector<Real> spread(Index row, std::span<const Index> columns) const {
        std::vector<Real> weights(columns.size(), 0);
        const auto own = table_.columns(row);
        for (std::size_t k = 0, place = 0; k < own.size(); ++k) {
            while (columns[place] != own[k]) ++place;
            weights[place] = table_.weights(row)[k];
        }
        return weights;
    }

    /// Appends the factors of a row, if it is such a product.
    bool addFactors(const OuterProduct& product, Index row, std::vector<Real>& factors) const {
        std::array<Real, 256> found;
        const std::size_t length = product.size[0] + product.size[1] + product.size[2];
        if (length > found.size()) return false;
        const auto own = std::span(found).first(length);
        if (!factorsOf<Real>(product, spread(row, shared_), own)) return false;
        factors.insert(factors.end(), own.begin(), own.end());
        return true;
    }

    void addPanels(std::span<const Index> rows, std::span<const Index> columns) {
        for (; !rows.empty(); rows = rows.subspan(std::min(rows.size(), kMaxRowsOfGroup))) {
            const auto part = rows.first(std::min(rows.size(), kMaxRowsOfGroup));
            std::vector<Real> numbers;
            numbers.reserve(part.size() * columns.size());
            for (const Index row : part) {
                const std::vector<Real> weights = spread(row, columns);
                numbers.insert(numbers.end(), weights.begin(), weights.end());
            }
            groups_.add(part, columns, {}, std::move(numbers));
        }
    }

    void addProducts(const OuterProduct& product, std::span<const Index> rows,
                     std::span<const Real> factors) {
        const std::size_t length = product.size[0] + product.size[1] + product.size[2];
        std::vector<Index> columns;
        for (const Index position : product.order) columns.push_back(shared_[position]);
        for (std::size_t first = 0; first < rows.size(); first += kMaxRowsOfGroup) {
            const auto part = rows.subspan(first, std::min(rows.size() - first, kMaxRowsOfGroup));
            const auto numbers = factors.subspan(first * length, part.size() * length);
            groups_.add(part, columns, product.size, {numbers.begin(), numbers.end()});
        }
    }

    /// Shares out the groups.
    void addTasks() {
        Index rowCount = 0;
        for (std::size_t group = 0; group < result_.groups.size(); ++group) {
            rowCount += result_.groups[group].rowCount;
            if (rowCount < kRowsOfTask && group + 1 < result_.groups.size()) continue;
            result_.taskStarts.push_back(static_cast<Offset>(group) + 1);
            rowCount = 0;
        }
    }

    const StencilTable<Real>& table_;
    CompiledRows<Real> result_;
    GroupList<Real> groups_;
    std::span<const Index> shared_;  ///< columns of the host at hand
    std::vector<Index> alone_;       ///< rows that are in no group
};

}  // namespace

template <class Real>
CompiledRows<Real> compileRows(const StencilTable<Real>& table) {
    return TableCompiler<Real>(table).compile();
}

template <class Real>
StencilTable<Real> rowsOnly(const StencilTable<Real>& table, std::span<const Index> rows) {
    std::vector<char> isThere(table.rowCount(), 0);
    for (const Index row : rows) isThere[row] = 1;
    Array<Offset> offsets = {0};
    Array<Index> columns;
    Array<Real> weights;
    for (Index row = 0; row < table.rowCount(); ++row) {
        if (isThere[row]) {
            columns.insert(columns.end(), table.columns(row).begin(), table.columns(row).end());
            weights.insert(weights.end(), table.weights(row).begin(), table.weights(row).end());
        }
        offsets.push_back(static_cast<Offset>(columns.size()));
    }
    return {stencils::Trusted{}, table.columnCount(), std::move(offsets), std::move(columns),
            std::move(weights)};
}

template CompiledRows<float> compileRows(const StencilTable<float>&);
template CompiledRows<double> compileRows(const StencilTable<double>&);
template StencilTable<float> rowsOnly(const StencilTable<float>&, std::span<const Index>);
template StencilTable<double> rowsOnly(const StencilTable<double>&, std::span<const Index>);

}  // namespace espalier::osd

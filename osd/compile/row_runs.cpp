// SPDX-License-Identifier: Apache-2.0
#include "row_runs.h"
#include "number_hash.h"

#include <algorithm>
#include <iterator>
#include <span>

namespace espalier::osd {
namespace {

/// Rows of a run, which one thread evaluates.
constexpr std::ptrdiff_t kMaxRowsOfRun = 4096;

/// Rows of the same weights that are worth a run.
constexpr std::ptrdiff_t kFewestShared = 16;

template <class Real>
class RunList {
public:
    RunList(const stencils::StencilTable<Real>& table, CompiledRows<Real>& compiled)
        : table_(table), compiled_(compiled) {}

    /// Adds rows of one length.
    /// \param isShared whether they have the same weights
    void add(std::span<const Index> rows, bool isShared) {
        const auto length = static_cast<Index>(table_.columns(rows.front()).size());
        const auto firstWeight = static_cast<Offset>(compiled_.weights.size());
        if (isShared) appendWeights(rows.front());
        while (!rows.empty()) {
            const auto part = rows.first(std::min(std::ssize(rows), kMaxRowsOfRun));
            compiled_.runs.push_back(
                {length, static_cast<Offset>(compiled_.columns.size()),
                 isShared ? firstWeight : static_cast<Offset>(compiled_.weights.size()), isShared,
                 static_cast<Offset>(compiled_.rows.size()), static_cast<Index>(part.size())});
            for (const Index row : part) {
                const auto columns = table_.columns(row);
                compiled_.columns.insert(compiled_.columns.end(), columns.begin(), columns.end());
                compiled_.rows.push_back(row);
                if (!isShared) appendWeights(row);
            }
            rows = rows.subspan(part.size());
        }
    }

private:
    void appendWeights(Index row) {
        const auto weights = table_.weights(row);
        compiled_.weights.insert(compiled_.weights.end(), weights.begin(), weights.end());
    }

    const stencils::StencilTable<Real>& table_;
    CompiledRows<Real>& compiled_;
};

}  // namespace

template <class Real>
void addRuns(const stencils::StencilTable<Real>& table, std::vector<Index> rows,
             CompiledRows<Real>& compiled) {
    /// A row, and what those with the same weights have in common with it.
    struct Candidate {
        std::size_t length;
        std::uint64_t hash;
        Index row;
        auto operator<=>(const Candidate&) const = default;
    };
    std::vector<Candidate> candidates;
    candidates.reserve(rows.size());
    for (const Index row : rows)
        candidates.push_back({table.columns(row).size(), hashOf(table.weights(row)), row});
    std::sort(candidates.begin(), candidates.end());
    RunList<Real> runs(table, compiled);
    std::vector<Index> same, others;
    // Of each length, first those of equal weights, then the rest.
    for (auto first = candidates.begin(); first != candidates.end();) {
        const auto last = std::find_if(first, candidates.end(), [&](const Candidate& other) {
            return other.length != first->length || other.hash != first->hash;
        });
        same.clear();
        // All of one hash: but for one case in 2^64, of the same weights.
        for (auto each = first; each != last; ++each)
            (std::ranges::equal(table.weights(each->row), table.weights(first->row)) ? same
                                                                                     : others)
                .push_back(each->row);
        if (std::ssize(same) >= kFewestShared)
            runs.add(same, true);
        else
            others.insert(others.end(), same.begin(), same.end());
        if (!others.empty() && (last == candidates.end() || last->length != first->length)) {
            std::sort(others.begin(), others.end());
            runs.add(others, false);
            others.clear();
        }
        first = last;
    }
}

template void addRuns(const stencils::StencilTable<float>&, std::vector<Index>,
                      CompiledRows<float>&);
template void addRuns(const stencils::StencilTable<double>&, std::vector<Index>,
                      CompiledRows<double>&);

}  // namespace espalier::osd

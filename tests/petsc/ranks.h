// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/petsc/distributed_table.h>
#include <espalier/stencils/stencil_table.h>
#include <mpi.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <span>
#include <vector>

#include "support/tables.h"

namespace espalier::test {

using petsc::OwnedRange;
using stencils::StencilTable;

inline int rank() {
    int result = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &result);
    return result;
}

inline int rankCount() {
    int result = 0;
    MPI_Comm_size(MPI_COMM_WORLD, &result);
    return result;
}

/// How points and vertices are distributed over the ranks.
enum class Spread {
    Even,
    Uneven,  ///< 1/16, 2/16 and so on; the last rank gets the rest
    AllOnFirst,
    AllOnLast
};

inline OwnedRange ownRange(Offset total, Spread spread) {
    const int me = rank(), size = rankCount();
    const OwnedRange none{me == 0 ? 0 : total, me == 0 ? 0 : total};
    switch (spread) {
        case Spread::Even:
            return petsc::evenRange(total, me, size);
        case Spread::Uneven: {
            const auto from = [&](int r) {
                return r == size ? total : ((1 << r) - 1) * total / 16;
            };
            return {from(me), from(me + 1)};
        }
        case Spread::AllOnFirst:
            return me == 0 ? OwnedRange{0, total} : none;
        case Spread::AllOnLast:
            return me == size - 1 ? OwnedRange{0, total} : OwnedRange{0, 0};
    }
    return none;
}

inline StencilTable<double> ownRows(const StencilTable<double>& table, OwnedRange own) {
    std::vector<Index> rows(own.count());
    std::iota(rows.begin(), rows.end(), Index(own.first));
    return stencils::selectRows(table, std::span<const Index>(rows));
}

/// Returns the part of the values that belongs to a range.
inline std::vector<double> ownValues(const std::vector<double>& all, OwnedRange own,
                                     int components) {
    return {all.begin() + own.first * components, all.begin() + own.last * components};
}

}  // namespace espalier::test

// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/petsc/owned_range.h>

#include <algorithm>
#include <string>

namespace espalier::petsc {

OwnedRange evenRange(Offset total, int rank, int size) {
    if (total < 0 || rank < 0 || rank >= size)
        throw Error("cannot split " + std::to_string(total) + " for rank " + std::to_string(rank) +
                    " of " + std::to_string(size));
    const Offset each = total / size, more = total % size;
    const Offset first = each * rank + std::min<Offset>(rank, more);
    return {first, first + each + (rank < more ? 1 : 0)};
}

}  // namespace espalier::petsc

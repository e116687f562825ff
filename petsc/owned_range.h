// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>

namespace espalier::petsc {

/// The points, or the lattice vertices, of one rank: first to last − 1 of all. Those of rank 0 come
/// first, then those of rank 1.
struct OwnedRange {
    Offset first = 0;
    Offset last = 0;

    Offset count() const { return last - first; }
    friend bool operator==(const OwnedRange&, const OwnedRange&) = default;
};

/// The part of `rank` of an even split, as PetscSplitOwnership makes it: the first ranks have one
/// more where it does not come out even.
/// \throws Error unless total ≥ 0 and 0 ≤ rank < size
ESPALIER_API OwnedRange evenRange(Offset total, int rank, int size);

}  // namespace espalier::petsc

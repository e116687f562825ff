// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/cell_complex.h>

#include <cstdint>
#include <optional>
#include <string>

namespace espalier::far {

/// Compares two complexes as sets of cells on numbered vertices. Returns the first difference in
/// one line ("the first has 12 cells, the second 10"), or nothing if they are equal. The order of
/// cells, faces and edges, and the start and direction of loops, do not matter.
/// \cost O(n log n)
ESPALIER_API std::optional<std::string> topologyDifference(const CellComplex& first,
                                                           const CellComplex& second);

/// Returns a hash that is equal for complexes without a topologyDifference(), on every machine.
ESPALIER_API std::uint64_t topologyHash(const CellComplex& complex);

}  // namespace espalier::far

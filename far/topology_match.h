// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/cell_complex.h>

#include <cstdint>
#include <optional>
#include <string>

namespace espalier::far {

/// What differs between two complexes as sets of cells on numbered vertices, in one line ("the
/// first has 12 cells, the second 10"); nothing if they are the same. The order of cells, faces and
/// edges, where loops start and which way they run does not count. \cost O(n log n)
ESPALIER_API std::optional<std::string> topologyDifference(const CellComplex& first,
                                                           const CellComplex& second);

/// A hash that is equal for complexes without difference, on every machine.
ESPALIER_API std::uint64_t topologyHash(const CellComplex& complex);

}  // namespace espalier::far

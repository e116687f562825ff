// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace espalier {

/// 2⁶⁴ divided by the golden ratio. Multiplied by it, numbers that are near each other become far
/// apart: in the highest bits they fill a hash table evenly.
inline constexpr std::uint64_t kHashFactor = 0x9E3779B97F4A7C15;

/// Returns the hash of a sequence, given the hash of all but its last number. The hash depends on
/// the order of the numbers.
inline std::uint64_t appendedHash(std::uint64_t hash, std::uint64_t number) {
    hash = (hash ^ number) * kHashFactor;
    return hash ^ hash >> 29;
}

}  // namespace espalier

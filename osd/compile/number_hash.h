// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>
#include <span>

namespace espalier::osd {

/// A hash of the bits of some numbers, in their order.
template <class Number>
std::uint64_t hashOf(std::span<const Number> numbers) {
    std::uint64_t hash = numbers.size();
    for (const Number number : numbers) {
        std::uint64_t bits = 0;
        std::memcpy(&bits, &number, sizeof(number));
        hash = (hash ^ bits) * 0x9E3779B97F4A7C15U;
        hash ^= hash >> 29;
    }
    return hash;
}

}  // namespace espalier::osd

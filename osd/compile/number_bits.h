// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/hash.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

namespace espalier::osd {

/// An integer with the size of a number.
template <class Number>
using BitsOf = std::conditional_t<sizeof(Number) == 4, std::uint32_t, std::uint64_t>;

/// Returns a hash of the bits of some numbers, which depends on their order.
template <class Number>
std::uint64_t hashOf(std::span<const Number> numbers) {
    std::uint64_t hash = numbers.size();
    for (const Number number : numbers)
        hash = appendedHash(hash, std::bit_cast<BitsOf<Number>>(number));
    return hash;
}

/// Returns true if numbers are the same, bit by bit.
template <class Number>
bool haveSameBits(std::span<const Number> a, std::span<const Number> b) {
    return a.size() == b.size() &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

}  // namespace espalier::osd

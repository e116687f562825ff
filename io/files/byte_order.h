// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>
#include <type_traits>

namespace espalier::io {

/// The number whose bytes begin at `bytes`, in this order; they need no alignment.
template <class Number>
Number loadNumber(const char* bytes, std::endian order) {
    static_assert(std::is_arithmetic_v<Number>);
    char native[sizeof(Number)];
    std::memcpy(native, bytes, sizeof native);
    if (order != std::endian::native) std::reverse(native, native + sizeof native);
    Number number;
    std::memcpy(&number, native, sizeof native);
    return number;
}

/// Puts the bytes of a number at `bytes`, in this order.
template <class Number>
void storeNumber(char* bytes, Number number, std::endian order) {
    static_assert(std::is_arithmetic_v<Number>);
    std::memcpy(bytes, &number, sizeof number);
    if (order != std::endian::native) std::reverse(bytes, bytes + sizeof number);
}

}  // namespace espalier::io

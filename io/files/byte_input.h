// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/array.h>
#include <espalier/base/memory.h>

#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include "byte_order.h"
#include "coding_error.h"

namespace espalier::io {

/// Takes numbers in one order of bytes off some bytes. Whatever asks for more than is left gets a
/// CodingError, before memory is taken for it.
class ByteInput {
public:
    /// \param bytes must outlive what is read
    ByteInput(std::string_view bytes, std::endian order) : bytes_(bytes), order_(order) {}

    /// Bytes that are left.
    std::size_t left() const { return bytes_.size(); }

    std::string_view bytes(std::uint64_t count) {
        if (count > left()) failFor(std::to_string(count) + " bytes");
        const std::string_view taken = bytes_.substr(0, count);
        bytes_.remove_prefix(count);
        return taken;
    }

    template <class Number>
    Number number() {
        return loadNumber<Number>(bytes(sizeof(Number)).data(), order_);
    }

    /// Numbers, each stored as a Stored.
    /// \throws CodingError naming the first, counted from 0, that is no Number
    template <class Stored, class Number>
    Array<Number> numbersAs(std::uint64_t count) {
        if (count > left() / sizeof(Stored))
            failFor(std::to_string(count) + " numbers of " + std::to_string(sizeof(Stored)) +
                    " bytes");
        requireMemory(count * sizeof(Number), "its data");
        const std::string_view stored = bytes(count * sizeof(Stored));
        Array<Number> numbers(count);
        if (std::is_same_v<Stored, Number> && order_ == std::endian::native) {
            if (count > 0) std::memcpy(numbers.data(), stored.data(), stored.size());
            return numbers;
        }
        for (std::size_t i = 0; i < numbers.size(); ++i) {
            const auto number = loadNumber<Stored>(stored.data() + i * sizeof(Stored), order_);
            if (!isHeldBy<Number>(number))
                throw CodingError("number " + std::to_string(i) + " is " + std::to_string(number) +
                                  ", beyond what can be held");
            numbers[i] = static_cast<Number>(number);
        }
        return numbers;
    }

private:
    /// Whether a Number can be exactly this. Real numbers are read as reals of no fewer bits.
    template <class Number, class Stored>
    static bool isHeldBy(Stored number) {
        if constexpr (std::is_floating_point_v<Stored>) {
            static_assert(std::is_floating_point_v<Number> && sizeof(Number) >= sizeof(Stored));
            return true;
        } else if constexpr (std::is_floating_point_v<Number>) {
            constexpr auto kLargest = std::int64_t{1} << std::numeric_limits<Number>::digits;
            return std::cmp_less_equal(number, kLargest) &&
                   std::cmp_greater_equal(number, -kLargest);
        } else {
            return std::in_range<Number>(number);
        }
    }

    [[noreturn]] void failFor(const std::string& expected) const {
        throw CodingError("the data ends too early: " + expected + " are expected, " +
                          std::to_string(left()) + " bytes are there");
    }

    std::string_view bytes_;
    std::endian order_;
};

}  // namespace espalier::io

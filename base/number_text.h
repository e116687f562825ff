// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/error.h>
#include <espalier/base/point.h>

#include <array>
#include <charconv>
#include <cstddef>
#include <string>
#include <string_view>
#include <type_traits>

/// \file
/// Numbers as texts, without a locale: std::to_chars() and std::from_chars(), also where the
/// standard library has them for whole numbers only (libc++ 14, for WebAssembly).

namespace espalier {

/// No number has a longer text; the longest ones have 24 bytes: -2.2250738585072014e-308.
inline constexpr std::size_t kMaxNumberText = 32;

/// Writes the shortest text that reads back as the same number, in fixed or scientific notation:
/// whichever is shorter, and fixed if both are as long.
/// \param at memory of kMaxNumberText bytes, all of which may change
/// \return the end of the text
ESPALIER_API char* writeNumber(char* at, double number);
ESPALIER_API char* writeNumber(char* at, float number);
template <class Integer>
requires std::is_integral_v<Integer>
char* writeNumber(char* at, Integer number) {
    return std::to_chars(at, at + kMaxNumberText, number).ptr;
}

/// The text of a number, as writeNumber() writes it.
class NumberText {
public:
    template <class Number>
    explicit NumberText(Number number) {
        size_ = writeNumber(text_.data(), number) - text_.data();
    }

    std::string_view view() const { return {text_.data(), size_}; }

private:
    std::array<char, kMaxNumberText> text_;
    std::size_t size_;
};

inline std::string textOf(const Point3& point) {
    return concat("(", textOf(point[0]), ", ", textOf(point[1]), ", ", textOf(point[2]), ")");
}

/// Returns a number in fixed notation, rounded to a number of decimals: "0.5" of 0.46 and 1.
ESPALIER_API std::string fixedText(double number, int decimals);

/// Reads a number at the begin of a text, rounded to nearest, like std::from_chars(). A number that
/// is too large, or too near 0 to differ from it, gives std::errc::result_out_of_range, and leaves
/// `number` as it was.
ESPALIER_API std::from_chars_result scanNumber(std::string_view text, double& number);
ESPALIER_API std::from_chars_result scanNumber(std::string_view text, float& number);
template <class Integer>
requires std::is_integral_v<Integer> std::from_chars_result scanNumber(std::string_view text,
                                                                       Integer& number) {
    return std::from_chars(text.data(), text.data() + text.size(), number);
}

}  // namespace espalier

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

/// The shortest text that reads back as the same number, in fixed or scientific notation: whichever
/// is shorter, and fixed if both are as long.
class ESPALIER_API NumberText {
public:
    explicit NumberText(double number);
    explicit NumberText(float number);
    template <class Integer>
    requires std::is_integral_v<Integer>
    explicit NumberText(Integer number) {
        setEnd(std::to_chars(digits_.data(), digits_.data() + digits_.size(), number).ptr);
    }

    std::string_view view() const { return {digits_.data(), size_}; }

private:
    void setEnd(const char* end) { size_ = static_cast<std::size_t>(end - digits_.data()); }

    std::array<char, 32> digits_;  ///< the longest texts have 24 bytes: -2.2250738585072014e-308
    std::size_t size_ = 0;
};

/// Returns the shortest text that reads back as `value`.
inline std::string textOf(double value) {
    return std::string(NumberText(value).view());
}

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

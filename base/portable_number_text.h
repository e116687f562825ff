// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fast_float/fast_float.h>
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <string>
#include <string_view>

/// \file
/// Conversions of floating-point numbers, for number_text.cpp where the standard library lacks
/// std::to_chars() and std::from_chars() for them, as libc++ 14 does. The test compares the
/// conversions with the standard library.

namespace espalier::portable {

/// The digits of a finite positive number, d.ddd · 10^exponent.
struct Decimal {
    std::string digits;  ///< the last digit is not 0
    int exponent = 0;
};

/// Takes apart what fmt writes: "123.5", "0.00012", "1e-07", "1.5e+300", "100000".
inline Decimal decimalOf(std::string_view text) {
    Decimal result;
    const std::size_t letter = text.find('e');
    const std::string_view mantissa = text.substr(0, letter);
    if (letter != std::string_view::npos)
        result.exponent = std::atoi(std::string(text.substr(letter + 1)).c_str());
    const std::size_t point = mantissa.find('.');
    for (const char c : mantissa)
        if (c != '.') result.digits += c;
    result.exponent += static_cast<int>(point == std::string_view::npos ? mantissa.size() : point);
    const std::size_t zeros = result.digits.find_first_not_of('0');
    result.digits.erase(0, zeros);
    result.exponent -= static_cast<int>(zeros) + 1;
    result.digits.erase(result.digits.find_last_not_of('0') + 1);
    return result;
}

/// Returns the decimal in scientific notation, with at least two digits in the exponent.
inline std::string scientific(const Decimal& decimal) {
    std::string text = decimal.digits;
    if (text.size() > 1) text.insert(1, ".");
    const int size = std::abs(decimal.exponent);
    return text + (decimal.exponent < 0 ? "e-" : "e+") + (size < 10 ? "0" : "") +
           std::to_string(size);
}

/// Returns the decimal in fixed notation. A number of more digits than the decimal has, which is
/// whole, gets all its digits.
template <class Real>
std::string fixed(const Decimal& decimal, Real number) {
    const auto count = static_cast<int>(decimal.digits.size());
    if (decimal.exponent >= count - 1) return fmt::format("{:.0f}", number);
    if (decimal.exponent < 0)
        return "0." + std::string(-decimal.exponent - 1, '0') + decimal.digits;
    return decimal.digits.substr(0, decimal.exponent + 1) + "." +
           decimal.digits.substr(decimal.exponent + 1);
}

/// Writes the text of a number from `first` on and returns its end, like std::to_chars().
template <class Real>
char* writeNumber(char* first, Real number) {
    std::string text;
    if (!std::isfinite(number) || number == 0) {
        text = std::isnan(number) ? "nan" : std::isinf(number) ? "inf" : "0";
    } else {
        const Decimal decimal = decimalOf(fmt::format("{}", std::abs(number)));
        text = scientific(decimal);
        const auto digits = static_cast<int>(decimal.digits.size());
        // The length of the fixed notation, which is long for large and for small numbers.
        const int fixedSize = decimal.exponent < 0            ? digits + 1 - decimal.exponent
                              : decimal.exponent < digits - 1 ? digits + 1
                                                              : decimal.exponent + 1;
        if (fixedSize <= static_cast<int>(text.size())) text = fixed(decimal, std::abs(number));
    }
    if (std::signbit(number)) *first++ = '-';
    return std::copy(text.begin(), text.end(), first);
}

inline std::string fixedText(double number, int decimals) {
    return fmt::format("{:.{}f}", number, decimals);
}

/// Like std::from_chars(), which unlike fast_float says when a number is out of range.
template <class Real>
std::from_chars_result scanNumber(std::string_view text, Real& number) {
    Real value = 0;
    const auto [end, error] = fast_float::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc()) return {end, error};
    const std::string_view read = text.substr(0, end - text.data());
    const std::string_view mantissa = read.substr(0, read.find_first_of("eE"));
    const bool isInfinite =
        std::isinf(value) && mantissa.find_first_of("0123456789") != mantissa.npos;
    const bool isZero = value == 0 && mantissa.find_first_of("123456789") != mantissa.npos;
    if (isInfinite || isZero) return {end, std::errc::result_out_of_range};
    number = value;
    return {end, std::errc()};
}

}  // namespace espalier::portable

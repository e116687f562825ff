// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/number_text.h>

#if !defined(__cpp_lib_to_chars)
#include "portable_number_text.h"
#endif

namespace espalier {
namespace {

#if defined(__cpp_lib_to_chars)
template <class Real>
char* writeReal(char* at, Real number) {
    return std::to_chars(at, at + kMaxNumberText, number).ptr;
}

std::string writeFixed(double number, int decimals) {
    std::array<char, 512> text;  // the largest number has 309 digits before the point
    const auto end = std::to_chars(text.data(), text.data() + text.size(), number,
                                   std::chars_format::fixed, decimals);
    return {text.data(), end.ptr};
}

template <class Real>
std::from_chars_result readReal(std::string_view text, Real& number) {
    return std::from_chars(text.data(), text.data() + text.size(), number);
}
#else
template <class Real>
char* writeReal(char* at, Real number) {
    return portable::writeNumber(at, number);
}

std::string writeFixed(double number, int decimals) {
    return portable::fixedText(number, decimals);
}

template <class Real>
std::from_chars_result readReal(std::string_view text, Real& number) {
    return portable::scanNumber(text, number);
}
#endif

}  // namespace

char* writeNumber(char* at, double number) {
    return writeReal(at, number);
}

char* writeNumber(char* at, float number) {
    return writeReal(at, number);
}

std::string fixedText(double number, int decimals) {
    return writeFixed(number, decimals);
}

std::from_chars_result scanNumber(std::string_view text, double& number) {
    return readReal(text, number);
}

std::from_chars_result scanNumber(std::string_view text, float& number) {
    return readReal(text, number);
}

std::string textOf(double value) {
    return std::string(NumberText(value).view());
}

}  // namespace espalier

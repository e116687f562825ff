// SPDX-License-Identifier: Apache-2.0
#include "decimal_digits.h"

#include <espalier/base/number_text.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <string_view>

namespace espalier::io {

DecimalDigits digitsOf(double number) {
    const NumberText text(number);
    std::string_view mantissa = text.view();
    int exponent = 0;
    if (const std::size_t e = mantissa.find('e'); e != std::string_view::npos) {
        std::string_view word = mantissa.substr(e + 1);
        if (word.starts_with('+')) word.remove_prefix(1);
        parseNumber(word, exponent);
        mantissa = mantissa.substr(0, e);
    }
    const std::size_t point = std::min(mantissa.find('.'), mantissa.size());
    DecimalDigits result{std::string(mantissa.substr(0, point)),
                         exponent + static_cast<int>(point)};
    if (point < mantissa.size()) result.digits += mantissa.substr(point + 1);
    const std::size_t first = std::min(result.digits.find_first_not_of('0'), result.digits.size());
    result.digits.erase(0, first);
    result.power -= static_cast<int>(first);
    result.digits.erase(result.digits.find_last_not_of('0') + 1);
    return result;
}

DecimalDigits rounded(DecimalDigits number, std::size_t count) {
    if (number.digits.size() <= count) return number;
    const bool isUp = number.digits[count] >= '5';
    number.digits.resize(count);
    if (isUp) {
        std::size_t at = count;
        while (at > 0 && number.digits[at - 1] == '9') number.digits[--at] = '0';
        if (at > 0) {
            ++number.digits[at - 1];
        } else {
            number.digits.insert(0, 1, '1');
            ++number.power;
        }
    }
    number.digits.erase(number.digits.find_last_not_of('0') + 1);
    return number;
}

}  // namespace espalier::io

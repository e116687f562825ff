// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

namespace espalier::io {

/// The decimal digits of a number without trailing zeros, and its power of ten: 0.d1d2d3… ·
/// 10^power.
struct DecimalDigits {
    std::string digits;
    int power;
};

/// Returns the fewest digits that read back as the same number.
/// \param number positive and finite
DecimalDigits digitsOf(double number);

/// Rounds digits to their first `count` ones, to nearest.
DecimalDigits rounded(DecimalDigits number, std::size_t count);

}  // namespace espalier::io

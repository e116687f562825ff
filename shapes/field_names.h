// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace espalier::shapes {

/// Returns a message with the field names of C and Python: minorRadius becomes minor_radius.
inline std::string withUnderscores(std::string_view message) {
    const auto isLower = [](char letter) { return letter >= 'a' && letter <= 'z'; };
    std::string text;
    for (const char letter : message) {
        const bool isCapital = letter >= 'A' && letter <= 'Z';
        if (isCapital && !text.empty() && isLower(text.back()))
            text += {'_', static_cast<char>(letter - 'A' + 'a')};
        else
            text += letter;
    }
    return text;
}

}  // namespace espalier::shapes

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>

#include <string>
#include <string_view>

namespace espalier::io {

inline constexpr std::string_view kBase64Alphabet =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
inline constexpr char kBase64Padding = '=';

/// Encodes bytes as base64 with padding, in one line.
ESPALIER_API std::string encodeBase64(std::string_view bytes);

/// Appends the same to a text.
ESPALIER_API void appendBase64(std::string& text, std::string_view bytes);

}  // namespace espalier::io

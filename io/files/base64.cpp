// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/progress.h>
#include <espalier/io/files/base64.h>

#include <cstddef>
#include <cstdint>

namespace espalier::io {

std::string encodeBase64(std::string_view bytes) {
    std::string text;
    appendBase64(text, bytes);
    return text;
}

void appendBase64(std::string& text, std::string_view bytes) {
    text.reserve(text.size() + (bytes.size() + 2) / 3 * 4);
    const auto byteAt = [&](std::size_t at) -> std::uint32_t {
        return at < bytes.size() ? static_cast<unsigned char>(bytes[at]) : 0;
    };
    for (std::size_t at = 0; at < bytes.size(); at += 3) {
        checkCancelledEvery(at / 3, 16);
        const std::uint32_t group = byteAt(at) << 16 | byteAt(at + 1) << 8 | byteAt(at + 2);
        for (std::size_t i = 0; i < 4; ++i)
            text += at + i > bytes.size() ? kBase64Padding
                                          : kBase64Alphabet[group >> (18 - 6 * i) & 63];
    }
}

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/files/file.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string_view>

namespace espalier::io {

/// Returns true if bytes begin as a text in UTF-16: with a byte order mark, or with several ASCII
/// characters that have a byte 0 beside each.
inline bool isUtf16(std::string_view bytes) {
    if (bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF")) return true;
    constexpr std::size_t kBytes = 32;
    if (bytes.size() < kBytes) return false;
    const auto isWide = [&](std::size_t zero) {
        for (std::size_t i = 0; i < kBytes; i += 2)
            if (bytes[i + zero] != 0 || bytes[i + 1 - zero] <= 0) return false;
        return true;
    };
    return isWide(0) || isWide(1);
}

/// Runs `read`, which reads the bytes of a file. If it fails and the file is UTF-16, the error says
/// so: no reader reads UTF-16, and their messages name odd words.
/// \throws FileError in place of another one, if the file is UTF-16; else the errors of `read`
template <class Read>
auto explainingUtf16(const std::filesystem::path& path, std::string_view bytes, Read read) {
    const bool isWide = isUtf16(bytes);  // `read` may take the bytes away
    try {
        return read();
    } catch (const FileError&) {
        if (!isWide) throw;
    }
    throw FileError(path, "is a text in UTF-16; expected UTF-8: save it as UTF-8");
}

}  // namespace espalier::io

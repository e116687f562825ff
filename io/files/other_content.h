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

/// Returns true for the text that stands in for a file of Git LFS that was not fetched.
inline bool isLfsPointer(std::string_view bytes) {
    return bytes.starts_with("version https://git-lfs.github.com/spec/");
}

/// Runs `read`, which reads the bytes of a file. If it fails and the file is UTF-16, or stands in
/// for a file of Git LFS, the error says so: the messages of the readers name odd words.
/// \throws FileError in place of another one for such a file; else the errors of `read`
template <class Read>
auto explainingContent(const std::filesystem::path& path, std::string_view bytes, Read read) {
    // `read` may take the bytes away.
    const bool isWide = isUtf16(bytes), isPointer = isLfsPointer(bytes);
    try {
        return read();
    } catch (const FileError&) {
        if (!isWide && !isPointer) throw;
    }
    throw FileError(path, isWide ? "is a text in UTF-16; expected UTF-8: save it as UTF-8"
                                 : "is a pointer to a file of Git LFS, which is not here: run "
                                   "'git lfs pull' in its repository");
}

}  // namespace espalier::io

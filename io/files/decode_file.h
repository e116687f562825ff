// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/memory.h>
#include <espalier/io/files/file.h>

#include <filesystem>

#include "coding_error.h"

namespace espalier::io {

/// Returns what `decode` does; a CodingError of it becomes a FileError of this file, and a
/// MemoryError names it.
template <class Decode>
auto decodeFile(const std::filesystem::path& path, Decode decode) {
    try {
        return decode();
    } catch (const CodingError& error) {
        throw FileError(path, error.what());
    } catch (const MemoryError& error) {
        throw MemoryError(shownPath(path) + ": " + error.what());
    }
}

}  // namespace espalier::io

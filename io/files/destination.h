// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

namespace espalier::io {

/// What is written to when a path is.
struct Destination {
    enum class Kind {
        File,       ///< made, or replaced
        Special,    ///< a device or a pipe: written to as it is
        Descriptor  ///< of this process (/dev/stdout): goes on where that is
    };
    Kind kind;
    std::filesystem::path path;  ///< behind all links, those that lead nowhere too
    int descriptor = 0;          ///< if it is one
};

/// \throws FileError if it is a directory, if it must not be written to, or if its folder must not
///         be or is not there
Destination destinationOf(const std::filesystem::path& path);

}  // namespace espalier::io

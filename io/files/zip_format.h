// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>

// Numbers of the ZIP format, as PKWARE's application note has them (version 6.3.9).
namespace espalier::io {

// What the records begin with.
inline constexpr std::uint32_t kZipLocalHeader = 0x04034b50, kZipDirectoryEntry = 0x02014b50,
                               kZipDirectoryEnd = 0x06054b50, kZip64DirectoryEnd = 0x06064b50,
                               kZip64Locator = 0x07064b50;

/// The extra field with the numbers that take more than 32 bits.
inline constexpr std::uint16_t kZip64Extra = 1;

// What stands in place of such a number.
inline constexpr std::uint32_t kZipAll32 = std::numeric_limits<std::uint32_t>::max();
inline constexpr std::uint16_t kZipAll16 = std::numeric_limits<std::uint16_t>::max();

// How a member is compressed.
inline constexpr std::uint16_t kZipStored = 0, kZipDeflated = 8;

}  // namespace espalier::io

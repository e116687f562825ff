// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

// Compressed files of the program gzip (RFC 1952).

namespace espalier::io {

/// Returns true if bytes begin as a file of gzip.
bool isGzip(std::string_view bytes);

/// Returns the bytes of a compressed file, which may have several members, one after the other.
/// Zeros behind the last member are padding.
/// \throws CodingError if it is damaged or ends too early; MemoryError if it holds more bytes than
/// a
///         MemoryLimit allows
std::string gunzip(std::string_view file);

/// Returns a compressed file with these bytes, without a name and a time: the same bytes always
/// give the same file.
std::string gzip(std::string_view bytes);

}  // namespace espalier::io

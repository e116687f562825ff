// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace espalier::io {

/// Deflate makes at most so many bytes of one (a symbol of 2 bits stands for up to 258 bytes).
inline constexpr std::uint64_t kMostInflation = 1032;

/// What is round a deflate stream: zlib's head and checksum (RFC 1950), or nothing (RFC 1951).
enum class DeflateForm { Zlib, Raw };

/// Appends what a deflate stream holds to `bytes`.
///
/// \param stream begins with the stream, and may go on beyond it
/// \param size number of bytes that it holds
/// \throws CodingError if it is damaged or holds another number of bytes; before memory is taken,
///         if no stream of this length could hold so many
void appendInflated(std::string_view stream, std::uint64_t size, DeflateForm form,
                    std::string& bytes);

}  // namespace espalier::io

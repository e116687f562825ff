// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace espalier::io {

/// Decodes base64 text step by step. White space is ignored. After padding a new stream begins, so
/// that consecutive streams read as one.
class Base64Reader {
public:
    /// \param text must outlive the reader
    explicit Base64Reader(std::string_view text) : text_(text) {}

    /// Returns an upper bound of the number of bytes that are left.
    std::size_t maxLeft() const { return left_.size() + (text_.size() - position_) / 4 * 3; }

    /// Reads `count` bytes.
    /// \throws CodingError at a character that is not base64, or at the end of the text
    std::string read(std::size_t count);

private:
    void readQuad();
    char nextCharacter();

    std::string_view text_;
    std::size_t position_ = 0;
    std::string left_;  ///< bytes that are decoded but not yet read
};

/// The largest number of bytes that deflate can make of one byte: a code of 2 bits gives up to 258.
inline constexpr std::uint64_t kMaxInflation = 1032;

/// The wrapper around a deflate stream: zlib's head and checksum (RFC 1950), or none (RFC 1951).
enum class DeflateForm { Zlib, Raw };

/// Inflates a deflate stream and appends the result to `bytes`.
///
/// \param stream begins with the stream, and may go on beyond it
/// \param size number of bytes that the stream holds
/// \throws CodingError if the stream is damaged or holds another number of bytes; before memory is
///         allocated, if a stream of this length cannot hold `size` bytes
void appendInflated(std::string_view stream, std::uint64_t size, DeflateForm form,
                    std::string& bytes);

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace espalier::io {

/// Base64 with padding, in one line.
std::string encodeBase64(std::string_view bytes);

/// Reads bytes from base64 text as they are asked for. White space does not count. After padding a
/// new stream begins, so that streams written one behind the other read as one.
class Base64Reader {
public:
    /// \param text must outlive the reader
    explicit Base64Reader(std::string_view text) : text_(text) {}

    /// No more bytes than these are left.
    std::size_t mostLeft() const { return left_.size() + (text_.size() - position_) / 4 * 3; }

    /// \throws CodingError at a character that is not of base64, or at the end
    std::string read(std::size_t count);

private:
    void readQuad();
    char nextCharacter();

    std::string_view text_;
    std::size_t position_ = 0;
    std::string left_;  ///< decoded, and not yet handed out
};

/// Deflate makes at most so many bytes of one (a symbol of 2 bits stands for up to 258 bytes).
inline constexpr std::uint64_t kMaxInflation = 1032;

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

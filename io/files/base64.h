// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
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

}  // namespace espalier::io

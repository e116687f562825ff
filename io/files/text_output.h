// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <charconv>
#include <cstddef>
#include <ostream>
#include <string>
#include <string_view>

namespace espalier::io {

/// Gathers text and hands it to a stream in large blocks; the last when it is destroyed.
class TextOutput {
public:
    explicit TextOutput(std::ostream& out) : out_(out) { buffer_.reserve(kBlockSize); }
    TextOutput(const TextOutput&) = delete;
    TextOutput& operator=(const TextOutput&) = delete;
    ~TextOutput() { flush(); }

    void text(std::string_view text) {
        if (buffer_.size() + text.size() > kBlockSize) flush();
        if (text.size() > kBlockSize)
            out_.write(text.data(), static_cast<std::streamsize>(text.size()));
        else
            buffer_ += text;
    }

    /// The shortest text that reads back as the same number.
    template <class Number>
    void number(Number number) {
        std::array<char, 32> digits;
        const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
        text({digits.data(), static_cast<std::size_t>(end - digits.data())});
    }

private:
    static constexpr std::size_t kBlockSize = 1 << 16;

    void flush() {
        out_.write(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
        buffer_.clear();
    }

    std::ostream& out_;
    std::string buffer_;
};

/// Writes a text again with some of its numbers replaced, some text added, and all else as it was.
class TextPatch {
public:
    /// \param text must outlive the patch
    TextPatch(std::ostream& out, std::string_view text) : out_(out), text_(text) {}

    /// Replaces `old`, a part of the text; parts ascend from call to call.
    template <class Number>
    void replace(std::string_view old, Number number) {
        const auto begin = static_cast<std::size_t>(old.data() - text_.data());
        out_.text(text_.substr(position_, begin - position_));
        out_.number(number);
        position_ = begin + old.size();
    }

    /// Puts text in between, before the byte at `place`, which is not before what was replaced
    /// last.
    void insert(std::size_t place, std::string_view added) {
        out_.text(text_.substr(position_, place - position_));
        out_.text(added);
        position_ = place;
    }

    /// Copies what follows the last change.
    void finish() {
        out_.text(text_.substr(position_));
        position_ = text_.size();
    }

private:
    TextOutput out_;
    std::string_view text_;
    std::size_t position_ = 0;
};

}  // namespace espalier::io

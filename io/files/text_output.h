// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/number_text.h>
#include <espalier/base/progress.h>

#include <algorithm>
#include <cstddef>
#include <ostream>
#include <string_view>
#include <type_traits>
#include <vector>

namespace espalier::io {

/// Collects text and writes it to a stream in large blocks; the last block on destruction.
class TextOutput {
public:
    explicit TextOutput(std::ostream& out) : out_(out), block_(kBlockSize), end_(block_.data()) {}
    TextOutput(const TextOutput&) = delete;
    TextOutput& operator=(const TextOutput&) = delete;
    ~TextOutput() { flush(); }

    /// Writes texts as they are, and numbers as the shortest text that reads back as the same
    /// number.
    template <class... Parts>
    void put(const Parts&... parts) {
        (putOne(parts), ...);
    }

    /// Writes numbers, `rowLength` per line.
    template <class Value>
    void rows(const std::vector<Value>& values, std::size_t rowLength) {
        for (std::size_t i = 0; i < values.size(); ++i)
            put(values[i], (i + 1) % rowLength == 0 ? "\n" : " ");
    }

private:
    static constexpr std::size_t kBlockSize = 1 << 16;

    template <class Part>
    void putOne(const Part& part) {
        if constexpr (std::is_arithmetic_v<Part>) {
            if (room() < kMaxNumberText) makeRoom();
            end_ = writeNumber(end_, part);
        } else {
            putText(part);
        }
    }

    void putText(std::string_view text) {
        if (text.size() > room()) makeRoom();
        if (text.size() > room())
            out_.write(text.data(), static_cast<std::streamsize>(text.size()));
        else
            end_ = std::copy(text.begin(), text.end(), end_);
    }

    std::size_t room() const { return block_.data() + block_.size() - end_; }

    /// \throws Cancelled, unlike flush(), which the destructor calls, too
    void makeRoom() {
        checkCancelled();
        flush();
    }

    void flush() {
        out_.write(block_.data(), end_ - block_.data());
        end_ = block_.data();
    }

    std::ostream& out_;
    std::vector<char> block_;
    char* end_;  ///< the end of the text in block_
};

/// Copies a text to a stream, with some numbers replaced and some text inserted.
class TextPatch {
public:
    /// \param text must outlive the patch
    TextPatch(std::ostream& out, std::string_view text) : out_(out), text_(text) {}

    /// Replaces `old`, a part of the text. Successive calls must go forward in the text.
    template <class Number>
    void replace(std::string_view old, Number number) {
        const std::size_t begin = old.data() - text_.data();
        out_.put(text_.substr(position_, begin - position_));
        out_.put(number);
        position_ = begin + old.size();
    }

    /// Inserts text before the byte at `offset`, which must not precede the last replaced part.
    void insert(std::size_t offset, std::string_view added) {
        out_.put(text_.substr(position_, offset - position_));
        out_.put(added);
        position_ = offset;
    }

    /// Copies the rest of the text.
    void finish() {
        out_.put(text_.substr(position_));
        position_ = text_.size();
    }

private:
    TextOutput out_;
    std::string_view text_;
    std::size_t position_ = 0;
};

}  // namespace espalier::io

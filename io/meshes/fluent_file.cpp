// SPDX-License-Identifier: Apache-2.0
#include "fluent_file.h"

#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <bit>
#include <charconv>

#include "../files/bytes.h"

namespace espalier::io {
namespace {

constexpr std::string_view kEndOfBinary = "End of Binary Section";

bool isFluentSpace(char c) {
    return c == ' ' || (c >= '\t' && c <= '\r');
}

}  // namespace

std::size_t FluentFile::line() const {
    return 1 + static_cast<std::size_t>(std::count(
                   bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(position_), '\n'));
}

void FluentFile::fail(const std::string& cause) const {
    if (isInBody_ && isBinary()) throw FileError(path_, concat("byte ", position_, ": ", cause));
    throw FileError(path_, line(), cause);
}

void FluentFile::skipSpace() {
    while (position_ < bytes_.size() && isFluentSpace(bytes_[position_])) ++position_;
}

/// Returns the next word, which ends at white space, a parenthesis or a quotation mark; empty if
/// one of these follows.
std::string_view FluentFile::word() {
    skipSpace();
    const std::size_t begin = position_;
    while (position_ < bytes_.size() && !isFluentSpace(bytes_[position_]) &&
           bytes_[position_] != '(' && bytes_[position_] != ')' && bytes_[position_] != '"')
        ++position_;
    return bytes_.substr(begin, position_ - begin);
}

/// Goes behind the section.
void FluentFile::skipSection() {
    if (isBinary()) {
        // "End of Binary Section   3010)". The bytes before it may be any.
        while (true) {
            const std::size_t end = bytes_.find(kEndOfBinary, position_);
            if (end == std::string_view::npos)
                fail(concat("the section ", fullKind_, " does not end; expected ",
                            inQuotes(kEndOfBinary)));
            position_ = end + kEndOfBinary.size();
            std::int64_t ofKind = 0;
            if (parseNumber(word(), ofKind) && ofKind == fullKind_) break;
        }
        skipSpace();
        position_ += position_ < bytes_.size() && bytes_[position_] == ')' ? 1 : 0;
        return;
    }
    std::size_t depth = isInBody_ ? 2 : 1;
    bool isText = false;
    for (; position_ < bytes_.size(); ++position_) {
        checkCancelledEvery(position_, 20);
        const char c = bytes_[position_];
        if (c == '\\' && isText) {
            ++position_;
        } else if (c == '"') {
            isText = !isText;
        } else if (!isText && c == '(') {
            ++depth;
        } else if (!isText && c == ')' && --depth == 0) {
            ++position_;
            return;
        }
    }
    fail(concat("the file ends in a section of the kind ", fullKind_));
}

bool FluentFile::next() {
    if (std::exchange(isOpen_, false)) skipSection();
    isInBody_ = false;
    numberSize_ = 0;
    skipSpace();
    if (position_ == bytes_.size()) return false;
    if (bytes_[position_] != '(')
        fail("expected a section such as (10 …), got " +
             inQuotes(bytes_.substr(position_, bytes_.find('\n', position_) - position_)));
    ++position_;
    const std::string_view kind = word();
    if (!parseNumber(kind, fullKind_)) fail(inQuotes(kind) + " is not the number of a section");
    kind_ = fullKind_ % 1000;
    if (fullKind_ / 1000 == 2) numberSize_ = 4;
    if (fullKind_ / 1000 == 3) numberSize_ = 8;
    isOpen_ = true;
    head_.clear();
    skipSpace();
    const bool hasHead = position_ < bytes_.size() && bytes_[position_] == '(';
    const std::size_t begin = position_;
    position_ += hasHead ? 1 : 0;
    for (std::string_view next = word(); !next.empty(); next = word()) head_.push_back(next);
    if (hasHead) {
        if (position_ < bytes_.size() && bytes_[position_] == ')') {
            ++position_;
        } else {
            position_ = begin;  // a list in a list, which is no head
            head_.clear();
        }
    }
    return true;
}

std::int64_t FluentFile::number(std::size_t index, int base) const {
    if (index >= head_.size()) return 0;
    const std::string_view text = head_[index];
    std::int64_t result = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), result, base);
    if (error != std::errc() || end != text.data() + text.size())
        fail(concat(inQuotes(text), " is not a number in the head of a section of the kind ",
                    fullKind_));
    return result;
}

bool FluentFile::beginBody() {
    skipSpace();
    if (position_ == bytes_.size() || bytes_[position_] != '(') return false;
    ++position_;
    isInBody_ = true;
    return true;
}

std::string_view FluentFile::take(std::size_t count, const char* what) {
    if (bytes_.size() - position_ < count) fail(concat("the file ends; expected ", what));
    position_ += count;
    return bytes_.substr(position_ - count, count);
}

std::int64_t FluentFile::integer(const char* what) {
    if (isBinary())
        return loadNumber<std::int32_t>(take(sizeof(std::int32_t), what).data(),
                                        std::endian::little);
    const std::string_view text = word();
    std::int64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, 16);
    if (text.empty() || error != std::errc() || end != text.data() + text.size())
        fail(text.empty() ? concat("the section ends; expected ", what)
                          : concat(inQuotes(text), " is not ", what));
    return number;
}

std::string_view FluentFile::realWord(const char* what) {
    const std::string_view text = word();
    if (text.empty()) fail(concat("the section ends; expected ", what));
    return text;
}

std::size_t FluentFile::realOffset(const char* what) {
    return offsetOf(take(numberSize_, what));
}

void FluentFile::checkRoom(std::int64_t count, std::size_t minBytes, const char* what) const {
    const std::size_t left = bytes_.size() - position_;
    if (count < 0 || static_cast<std::uint64_t>(count) > left / minBytes + 1)
        fail(concat("the section claims ", count, " ", what, ", but ", left, " bytes are left"));
}

}  // namespace espalier::io

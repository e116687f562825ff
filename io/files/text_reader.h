// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace espalier::io {

/// Takes the next word, a longest run without white space, off a line; empty when there is none.
inline std::string_view takeWord(std::string_view& line) {
    constexpr std::string_view kSpace = " \t\r\v\f";
    line.remove_prefix(std::min(line.find_first_not_of(kSpace), line.size()));
    const std::string_view word = line.substr(0, line.find_first_of(kSpace));
    line.remove_prefix(word.size());
    return word;
}

/// Walks through a text by tokens or by lines, and knows where it is: every error is a FileError
/// with path and line.
class ESPALIER_API TextReader {
public:
    /// \param path for messages
    /// \param text must outlive the reader
    /// \param firstLine number of the first line of `text` in its file
    TextReader(std::filesystem::path path, std::string_view text, std::size_t firstLine = 1);

    /// From now on `mark` opens a comment wherever a token could begin or end. It runs to the end
    /// of its line, and counts as white space. Lines and bytes are not affected.
    void skipComments(char mark) { commentMark_ = mark; }

    /// Line of the last token or line that was read, from 1.
    std::size_t line() const { return line_; }

    /// Position of the next byte to be read.
    std::size_t position() const { return position_; }

    /// Number of bytes that are left.
    std::size_t remaining() const { return text_.size() - position_; }

    /// Whether nothing but white space is left.
    bool atEnd();

    /// The next token: a longest run without white space.
    /// \throws FileError at the end, which says that `what` was expected
    std::string_view token(const char* what);

    /// The next token as a number; "inf" and "nan" are numbers.
    template <class Number>
    Number number(const char* what);

    /// The next token as the number of things that follow, each of at least `leastBytes` bytes.
    /// \throws FileError if it is not a whole number, or more than the rest of the text can hold:
    ///         so it is safe to take memory for them
    std::size_t count(const char* what, std::size_t leastBytes);

    /// \throws FileError if the rest of the text cannot hold so many things of at least
    ///         `leastBytes` bytes each; the last one may lack its separator
    void checkRoom(std::size_t count, std::size_t leastBytes, const char* what) const;

    /// Reads to the end of the line, and returns what was left of it, without its end ("\n" or
    /// "\r\n"). At the end of the text, returns an empty line.
    std::string_view restOfLine();

    /// Moves on by `count` bytes (binary data); they do not count as lines.
    /// \throws FileError if so many are not left, which says that `what` was expected
    std::string_view bytes(std::size_t count, const char* what);

    [[noreturn]] void fail(const std::string& cause) const;

private:
    void skipSpace();
    bool opensComment(char c) const { return commentMark_ && c == *commentMark_; }

    std::filesystem::path path_;
    std::string_view text_;
    std::optional<char> commentMark_;
    std::size_t position_ = 0;
    std::size_t line_;
    std::size_t nextLine_;
};

/// A whole token as a number. A real number that is too close to 0 for the type reads as 0 or -0.
/// \return false if it is not one, or too large for the type
template <class Number>
ESPALIER_API bool parseNumber(std::string_view token, Number& number);

/// The shortest text that reads back as the same number.
ESPALIER_API std::string formatNumber(double number);
ESPALIER_API std::string formatNumber(float number);

/// A text in lower case (ASCII letters only), for keywords that may be written either way.
ESPALIER_API std::string lowerCase(std::string_view text);

}  // namespace espalier::io

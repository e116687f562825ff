// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/io/files/text_reader.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "odd_lines.h"

// Splits the text of an OBJ into statements, and statements into words. A statement is one line, or
// several lines that backslashes join.

namespace espalier::io {

/// The words of a statement, up to a comment.
class ObjWords {
public:
    /// \param statement without its last line end, but with line ends after a backslash
    explicit ObjWords(std::string_view statement) : rest_(statement) {}

    /// Returns the next word; empty if there is none.
    std::string_view next();

    /// Returns the next word, and reads it as parseNumber() does; as NaN if it is no number.
    std::string_view nextNumber(double& number);

    /// Returns the rest of the statement.
    std::string_view rest() const { return rest_; }

    /// Returns the end of the statement, behind its comment.
    const char* end() const { return rest_.data() + rest_.size(); }

private:
    std::size_t blankAt(std::size_t at) const;

    std::string_view rest_;
};

/// Reads a statement, which may go on over several lines.
std::string_view readObjStatement(TextReader& reader);

/// Calls visit(words, line) for each statement of a file; the statement begins on `line`. Skips a
/// byte order mark.
template <class Visit>
void forEachObjStatement(const std::filesystem::path& path, std::string_view text, Visit visit) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    TextReader reader(path, text);
    if (text.starts_with(kByteOrderMark)) reader.bytes(kByteOrderMark.size(), "a mark");
    for (std::size_t line = 1; reader.remaining() > 0; line = reader.line() + 1) {
        ObjWords words(readObjStatement(reader));
        visit(words, line);
    }
}

/// Reads the first words of statements. Known are the keywords of the OBJ specification (version
/// 3.0, including superseded ones), and the `t` of OpenSubdiv's tags.
class ObjKeywords {
public:
    explicit ObjKeywords(const std::filesystem::path& path) : path_(path) {}

    /// Reads the first word of a statement; empty if there is none. Counts words that are not
    /// known. \param words words of the whole statement \throws FileError if the word is not known
    /// and cannot be one that a program has added: if it
    ///         is a number or a keyword in upper case, or if the statement is not text
    std::string_view read(ObjWords& words, std::size_t line);

    /// Throws the error of the first unknown word if there is one and the file has no points: it is
    /// no OBJ then.
    void checkFile(bool havePoints) const;

    /// Returns "3 lines whose first word no OBJ has ('foo' in line 7)"; empty if all are known.
    std::string unknown() const;

private:
    [[noreturn]] void fail(std::string_view word, std::size_t line) const;

    const std::filesystem::path& path_;
    OddLines odd_;
    std::string firstOdd_;
    std::size_t firstOddLine_ = 0;
};

/// Returns the number of lines that begin with "v ", as most points do. It takes 5 % of the time of
/// reading.
std::size_t expectedPoints(std::string_view text);

struct ObjPoint {
    Point3 position;
    std::array<std::string_view, 3> words;  ///< the text of x, y and z
};

/// Reads the point of a `v` statement. The words after it, w or a colour, must be numbers and are
/// not kept.
/// \param words the words after the `v`
/// \return coordinates that may be not finite
/// \throws FileError if a word is not a number, or a coordinate is missing
ObjPoint readObjPoint(ObjWords& words, const std::filesystem::path& path, std::size_t line);

/// A number in a corner, and the point or normal that it names.
struct ObjReference {
    std::int64_t number;  ///< the number in the file; negative numbers count back
    std::size_t index;    ///< number of the point or normal, from 0
};

/// Resolves a number in a corner.
/// \param before number of points (or normals) before the statement
/// \param total number of points (or normals) in the file
/// \return nothing if the word is no number, or names no point (or normal) of the file
std::optional<ObjReference> referenceOf(std::string_view word, std::size_t before,
                                        std::size_t total);

/// The numbers of a corner that names a normal.
struct ObjCorner {
    std::string_view point;
    std::string_view normal;
};

/// Splits a corner such as "1//3" or "1/2/3". Returns nothing if it names no normal.
std::optional<ObjCorner> cornerOf(std::string_view word);

/// The numbers of points and normals that precede a statement.
struct CountsBefore {
    std::size_t points = 0;
    std::size_t normals = 0;
};

/// Reads the words after a `vn`. A word that is no number is NaN.
Point3 readObjNormal(ObjWords& words);

}  // namespace espalier::io

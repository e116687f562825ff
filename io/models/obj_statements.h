// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/io/files/text_reader.h>

#include <array>
#include <cstddef>
#include <filesystem>
#include <string_view>

// How the text of an OBJ is cut up: into statements, of a line or of several that a backslash
// joins, and these into words.

namespace espalier::io {

/// The words of a statement, up to a comment.
class ObjWords {
public:
    /// \param statement without its line end, but with those that a backslash continues
    explicit ObjWords(std::string_view statement) : rest_(statement) {}

    /// The next word; empty when there is none.
    std::string_view next();

    /// The end of the statement, comment included.
    const char* end() const { return rest_.data() + rest_.size(); }

private:
    std::size_t blankAt(std::size_t at) const;

    std::string_view rest_;
};

/// Reads lines to the end of a statement.
std::string_view readObjStatement(TextReader& reader);

/// Calls visit(words, line) for each statement of a file; `line` is that on which it begins. Passes
/// over a byte order mark.
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

/// The first word of a statement; empty if there is none.
/// \param words of the whole statement
/// \throws FileError if it is no keyword of the OBJ specification (version 3.0, those that it
///         supersedes included), and not the `t` of OpenSubdiv's tags
std::string_view readObjKeyword(ObjWords& words, const std::filesystem::path& path,
                                std::size_t line);

struct ObjPoint {
    Point3 position;
    std::array<std::string_view, 3> words;  ///< what gave x, y and z
};

/// The point of a `v`. What follows it, w or a colour, is checked to be numbers and not kept.
/// \param words those after the `v`
/// \throws FileError if one is not a number, or a coordinate is missing or not finite
ObjPoint readObjPoint(ObjWords& words, const std::filesystem::path& path, std::size_t line);

}  // namespace espalier::io

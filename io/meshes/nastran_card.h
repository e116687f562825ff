// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/files/text_reader.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

// The entries of Nastran's bulk data ("cards"). An entry is a line and its continuations. A line
// has a name or a mark of continuation, and then fields: eight of 8 characters, four of 16
// characters if the name or the mark has an asterisk, or any if commas separate them.

namespace espalier::io {

/// A line of an entry.
struct NastranLine {
    std::string_view text;  ///< without its end and its comment
    bool isFree;            ///< whether commas separate the fields
    bool isLarge;           ///< whether there are 4 fields (of 16 characters), and not 8 (of 8)

    std::size_t fieldCount() const { return isLarge ? 4 : 8; }

    /// Number of characters of a field; 0 if commas separate them.
    std::size_t width() const { return isFree ? 0 : isLarge ? 16 : 8; }

    /// Returns the characters of a field without spaces around it; empty if the line is shorter.
    /// \param field from 0, after the name
    std::string_view field(std::size_t field) const;

    /// Returns the line with another text in a field. All other characters stay, unless the field
    /// is beyond the end of the line.
    std::string withField(std::size_t field, std::string_view text) const;
};

/// Returns the line that begins at an offset of a file.
NastranLine nastranLineAt(std::string_view bytes, std::size_t offset);

/// Reads the entries of a file, from BEGIN BULK, if the file has it, to ENDDATA.
class NastranReader {
public:
    NastranReader(const std::filesystem::path& path, std::string_view bytes);

    /// Goes to the next entry.
    /// \return false at the end of the entries
    bool next();

    /// The name of the entry in upper case, without an asterisk: "GRID".
    const std::string& name() const { return name_; }

    /// The first line of the entry, and its continuations.
    const std::vector<NastranLine>& lines() const { return lines_; }

    /// Number of the first line of the entry.
    std::size_t line() const { return line_; }

    /// Returns a field of the entry, whose continuations have the fields from 8 on; empty if the
    /// entry is shorter.
    std::string_view field(std::size_t field) const;

    /// Reads a field as a whole number; nothing if it is empty.
    /// \throws FileError if it is no number
    std::optional<std::int64_t> integer(std::size_t field, const char* what) const;

    /// Reads a field as a coordinate; 0 if it is empty.
    /// \throws FileError if it is no finite number
    double coordinate(std::size_t field, std::size_t axis) const;

    [[noreturn]] void fail(const std::string& cause) const;

private:
    /// Returns the next line without its comment that is not empty.
    std::optional<std::string_view> nextLine();
    void seekBulk();

    const std::filesystem::path& path_;
    std::string_view bytes_;
    TextReader text_;
    std::optional<std::string_view> pending_;  ///< the line after the entry
    std::size_t pendingLine_ = 0;
    std::string name_;
    std::vector<NastranLine> lines_;
    std::size_t line_ = 0;
};

/// Parses a real number of Nastran, "1.5", "1.5E-3", "1.5D-3" or "1.5-3"; nothing if it is none.
std::optional<double> parseNastranReal(std::string_view word);

/// Returns the text of a number with as many digits as fit, up to the shortest text that reads back
/// as the same number. It has a decimal point, as Nastran needs it.
/// \param width the largest number of characters, at least 8; 0 for any number
std::string nastranText(double number, std::size_t width);

/// Returns the number that nastranText() leaves.
double roundedToField(double number, std::size_t width);

/// Returns an upper bound of the difference between a number and roundedToField(), for all numbers
/// of at most this size, apart from the rounding of doubles.
/// \param width 8 or 16
double largestRounding(double size, std::size_t width);

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/files/text_reader.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "vtk_numbers.h"

namespace espalier::io {

/// Reads the parts that legacy VTK files are made of: words, and arrays of numbers that are text or
/// big-endian binary data. Every error is a FileError with path and line.
class LegacyData {
public:
    /// \param text must outlive the reader
    LegacyData(const std::filesystem::path& path, std::string_view text) : text_(path, text) {}

    TextReader& text() { return text_; }
    void setBinary(bool isBinary) { isBinary_ = isBinary; }

    /// The next keyword, in lower case.
    std::string keyword(const char* what) { return lowerCase(text_.token(what)); }

    /// \throws FileError if the next word is another one, in upper or lower case
    void expect(const char* word);

    /// A name, with its "%20" and the like resolved.
    std::string name();

    /// `count` numbers of a type in lower case: "float".
    /// \throws FileError if the type is unknown, or not of this kind, or so many are not there
    template <class Value>
    std::vector<Value> numbers(const std::string& type, std::size_t count, const char* what);

    /// `count` numbers of any type; nothing if they are bits or strings, which are skipped.
    std::optional<std::vector<double>> values(const std::string& type, std::size_t count,
                                              const char* what);

    /// Skips colours: unsigned bytes if binary, else fractions.
    void skipColours(std::size_t count);

    /// Skips METADATA, whose keyword has been read, to the empty line at its end.
    void skipMetadata();

private:
    void skipBits(std::size_t count);
    void skipStrings(std::size_t count);
    void skipBinaryString();
    void beginBinary() { text_.restOfLine(); }

    TextReader text_;
    bool isBinary_ = false;
};

}  // namespace espalier::io

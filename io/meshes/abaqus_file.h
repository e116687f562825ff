// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/files/text_reader.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

// The lines of an input file of Abaqus or CalculiX: keywords with parameters, "*ELEMENT, TYPE=S3",
// each followed by lines of data with commas.

namespace espalier::io {

/// Removes the text up to the next comma from the front of a line, and the comma; nothing if the
/// line has no more entries.
std::optional<std::string_view> takeAbaqusEntry(std::string_view& line);

/// A keyword and its parameters.
struct AbaqusKeyword {
    std::string name;  ///< in lower case, without white space and the asterisk: "endpart"
    std::vector<std::pair<std::string, std::string_view>> parameters;  ///< names in lower case

    /// Returns a parameter, which is empty if it has no value; nothing if the keyword does not have
    /// it.
    std::optional<std::string_view> parameter(std::string_view wanted) const;

    /// Returns a parameter that is a name, without quotation marks; empty if there is none.
    std::string_view nameIn(std::string_view wanted) const;
};

/// The parts, instances and assemblies around a line, by number. Each numbers its nodes on its own.
/// 0 is the whole file.
class AbaqusScopes {
public:
    std::size_t current() const { return open_.back(); }
    std::size_t count() const { return count_; }
    void update(std::string_view keyword);

private:
    std::vector<std::size_t> open_ = {0};
    std::size_t count_ = 1;
};

/// Reads a file keyword by keyword. Errors are FileErrors with the line.
class AbaqusFile {
public:
    AbaqusFile(const std::filesystem::path& path, std::string_view bytes)
        : bytes_(bytes), text_(path, bytes) {}

    /// Goes to the next keyword. The rest of the data of the last one is skipped, and so are lines
    /// before the first one.
    /// \return false at the end of the file
    bool next();

    const AbaqusKeyword& keyword() const { return keyword_; }
    const AbaqusScopes& scopes() const { return scopes_; }

    /// Returns the next line of data of the keyword; nothing if there is none.
    std::optional<std::string_view> nextData();

    /// Reads an entry of a line as a whole number.
    std::int64_t integer(std::optional<std::string_view> entry, const char* what) const;

    std::size_t line() const { return text_.line(); }
    std::size_t offsetOf(std::string_view word) const { return word.data() - bytes_.data(); }
    [[noreturn]] void fail(const std::string& cause) const { text_.fail(cause); }

private:
    std::optional<std::string_view> nextLine();
    bool addParameters(std::string_view line);

    std::string_view bytes_;
    TextReader text_;
    std::optional<std::string_view> pending_;  ///< a line that was read, and is to be read again
    AbaqusKeyword keyword_;
    AbaqusScopes scopes_;
};

}  // namespace espalier::io

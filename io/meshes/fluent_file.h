// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

// The sections of a mesh or a case of Fluent: "(10 (1 1 2f 1 3)(…))". The first number is the kind
// of the section, in decimal. The numbers of its head are hexadecimal. Then comes its body, which
// is text, or binary in little-endian order.

namespace espalier::io {

/// Reads a file section by section. Errors are FileErrors with the line, or with the byte in a
/// binary body.
class FluentFile {
public:
    FluentFile(const std::filesystem::path& path, std::string_view bytes)
        : path_(path), bytes_(bytes) {}

    /// Goes to the next section. The rest of the last one is skipped.
    /// \return false at the end of the file
    bool next();

    /// The kind of the section without its thousands, which tell how the body is written: 13 of
    /// "(3013 …".
    std::int64_t kind() const { return kind_; }

    bool isBinary() const { return numberSize_ > 0; }

    /// Number of bytes of a real number of a binary section: 4 or 8.
    std::size_t numberSize() const { return numberSize_; }

    /// Returns the words of the head, "1 1 2f 1 3". Of the section (2 3), which has none, the word
    /// after the kind.
    const std::vector<std::string_view>& head() const { return head_; }

    /// Returns a number of the head; 0 if the head is shorter.
    /// \param base 10 or 16
    std::int64_t number(std::size_t index, int base = 16) const;

    /// Begins to read the body. Returns false if the section has none.
    bool beginBody();

    /// Reads a number of the body: in text a hexadecimal one.
    std::int64_t integer(const char* what);

    /// Returns the word of the next real number, which is in a body of text.
    std::string_view realWord(const char* what);

    /// Returns the offset of the next real number, which is in a binary body.
    std::size_t realOffset(const char* what);

    /// Throws if the rest of the file is too short for `count` items of at least `minBytes` bytes.
    void checkRoom(std::int64_t count, std::size_t minBytes, const char* what) const;

    std::size_t offsetOf(std::string_view word) const { return word.data() - bytes_.data(); }
    std::size_t line() const;
    [[noreturn]] void fail(const std::string& cause) const;

private:
    void skipSpace();
    void skipSection();
    std::string_view word();
    std::string_view take(std::size_t count, const char* what);

    const std::filesystem::path& path_;
    std::string_view bytes_;
    std::size_t position_ = 0;
    bool isOpen_ = false;  ///< whether position_ is inside a section
    bool isInBody_ = false;
    std::int64_t fullKind_ = 0, kind_ = 0;
    std::size_t numberSize_ = 0;
    std::vector<std::string_view> head_;
};

}  // namespace espalier::io

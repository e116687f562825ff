// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/printable.h>
#include <espalier/io/numbered_path.h>

#include <cstddef>
#include <optional>
#include <string>

namespace espalier::io {
namespace {

std::string padded(int number, std::size_t width) {
    const std::string digits = std::to_string(number);
    return std::string(width > digits.size() ? width - digits.size() : 0, '0') + digits;
}

bool isDigit(char c) {
    return c >= '0' && c <= '9';
}

/// A %d or %0Nd in a text.
struct NumberPattern {
    std::size_t begin;
    std::size_t size;
    std::size_t width;
};

/// Returns the pattern whose % is at `begin`; nothing if the % begins neither %d nor %0Nd.
std::optional<NumberPattern> patternAt(const std::string& text, std::size_t begin) {
    std::size_t end = begin + 1;
    std::size_t width = 0;
    if (text.compare(end, 1, "0") == 0) {
        // Reads one or two digits after the zero. At the end of the text, text[end] is '\0'.
        for (++end; end < begin + 4 && isDigit(text[end]); ++end)
            width = 10 * width + (text[end] - '0');
        if (width == 0) return std::nullopt;
    }
    if (text.compare(end, 1, "d") != 0) return std::nullopt;
    return NumberPattern{begin, end + 1 - begin, width};
}

}  // namespace

std::filesystem::path numberedPath(const std::filesystem::path& pattern, int number, int count) {
    const std::string text = pattern.string();
    const auto refuse = [&](const char* why) {
        throw Error(std::string("'").append(printable(text)).append("' ").append(why));
    };
    // A slash at the end names a folder, which is numbered like a file.
    if (!pattern.has_filename()) {
        const std::filesystem::path folder = pattern.parent_path();
        if (!folder.has_filename()) refuse("names no file");
        return numberedPath(folder, number, count) / "";
    }
    if (number < 0) refuse("cannot be numbered with a number below 0");
    const std::size_t percent = text.find('%');
    if (percent == std::string::npos) {
        if (count <= 1) return pattern;
        const std::string name = pattern.stem().string() + "." + padded(number, 4);
        return pattern.parent_path() / (name + pattern.extension().string());
    }
    const std::optional<NumberPattern> found = patternAt(text, percent);
    if (!found) refuse("has a % that does not begin %d, or %04d for four digits");
    if (text.find('%', found->begin + found->size) != std::string::npos)
        refuse("has more than one %; expected one place for the number of a pose");
    return text.substr(0, found->begin) + padded(number, found->width) +
           text.substr(found->begin + found->size);
}

}  // namespace espalier::io

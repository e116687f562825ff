// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/number_text.h>
#include <espalier/base/progress.h>
#include <espalier/io/files/file.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <system_error>

#include "coordinates.h"
#include "obj_statements.h"

namespace espalier::io {

std::string_view ObjWords::next() {
    while (const std::size_t length = blankAt(0)) rest_.remove_prefix(length);
    std::size_t end = 0;
    // Most characters are no white space, comment or backslash.
    const auto isPlain = [](char c) { return c > ' ' && c != '#' && c != '\\'; };
    while (end < rest_.size() && (isPlain(rest_[end]) || (rest_[end] != '#' && blankAt(end) == 0)))
        ++end;
    const std::string_view word = rest_.substr(0, end);
    rest_.remove_prefix(end);
    return word;
}

std::string_view ObjWords::nextNumber(double& number) {
    while (const std::size_t length = blankAt(0)) rest_.remove_prefix(length);
    // Most words are numbers as scanNumber() reads them, which finds their end too.
    const auto [end, error] = scanNumber(rest_, number);
    const std::size_t length = end - rest_.data();
    if (error == std::errc() &&
        (length == rest_.size() || rest_[length] == '#' || blankAt(length) > 0)) {
        const std::string_view word = rest_.substr(0, length);
        rest_.remove_prefix(length);
        return word;
    }
    const std::string_view word = next();
    if (!parseNumber(word, number)) number = std::numeric_limits<double>::quiet_NaN();
    return word;
}

/// Returns the length of the white space character or of the continued line end at `at`; 0 if there
/// is neither.
std::size_t ObjWords::blankAt(std::size_t at) const {
    if (at == rest_.size()) return 0;
    const char c = rest_[at];
    if (c == ' ' || (c >= '\t' && c <= '\r')) return 1;
    if (c != '\\') return 0;
    const std::string_view after = rest_.substr(at + 1);
    return after.starts_with('\n') ? 2 : after.starts_with("\r\n") ? 3 : 0;
}

std::string_view readObjStatement(TextReader& reader) {
    const std::string_view first = reader.restOfLine();
    std::string_view last = first;
    // A comment may end in a backslash, as in a path; it does not continue on the next line.
    while (last.ends_with('\\') && last.find('#') == std::string_view::npos)
        last = reader.restOfLine();
    return std::string_view(first.data(), last.data() + last.size() - first.data());
}

std::string_view ObjKeywords::read(ObjWords& words, std::size_t line) {
    static constexpr std::string_view kKeywords[] = {
        "v", "f", "fo", "vt", "vn", "t", "l", "p", "vp", "g", "s", "o", "mg", "usemtl", "mtllib",
        // free-form curves and surfaces
        "cstype", "deg", "bmat", "step", "curv", "curv2", "surf", "parm", "trim", "hole", "scrv",
        "sp", "end", "con", "bsp", "bzp", "cdc", "cdp", "res",
        // display, and others
        "bevel", "c_interp", "d_interp", "lod", "shadow_obj", "trace_obj", "ctech", "stech",
        "maplib", "usemap", "call", "csh"};
    const auto isKnown = [](std::string_view word) {
        return std::ranges::find(kKeywords, word) != std::end(kKeywords);
    };
    const std::string_view statement = words.rest();
    const std::string_view word = words.next();
    if (word.empty() || isKnown(word)) return word;
    if (!canBeOdd(word, statement) || isKnown(lowerCase(word))) fail(word, line);
    if (odd_.empty()) {
        firstOdd_ = word;
        firstOddLine_ = line;
    }
    odd_.add(word, line);
    return word;
}

void ObjKeywords::checkFile(bool havePoints) const {
    if (!havePoints && !odd_.empty()) fail(firstOdd_, firstOddLine_);
}

std::string ObjKeywords::unknown() const {
    return odd_.empty() ? std::string() : odd_.phrase("whose first word no OBJ has");
}

void ObjKeywords::fail(std::string_view word, std::size_t line) const {
    throw FileError(path_, line,
                    inQuotes(word) +
                        " is not a keyword of OBJ files; expected v, f, vn or another one, in "
                        "lower case, or # and a comment");
}

std::size_t expectedPoints(std::string_view text) {
    std::uint32_t count = text.starts_with("v ");
    // Without branches, so that the compiler uses vector instructions.
    const auto is = [&](std::size_t at, char c) { return std::uint32_t{text[at] == c}; };
    constexpr std::size_t kAtOnce = 1 << 20;  // less than a millisecond
    forEachBlock(text.size(), kAtOnce, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = std::max<std::size_t>(first, 2); i < last; ++i)
            count += is(i - 2, '\n') & is(i - 1, 'v') & is(i, ' ');
    });
    return count;
}

ObjPoint readObjPoint(ObjWords& words, const std::filesystem::path& path, std::size_t line) {
    ObjPoint point;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::string_view word = words.nextNumber(point.position[axis]);
        if (!std::isfinite(point.position[axis]))  // "nan", or no number: an error
            point.position[axis] = parseCoordinate(word, axis, Precision::Double, path, line);
        point.words[axis] = word;
    }
    double ignored = 0;
    for (std::string_view word = words.next(); !word.empty(); word = words.next())
        if (!parseNumber(word, ignored))
            throw FileError(
                path, line,
                inQuotes(word) + " is not a number; expected w or a colour after x y z");
    return point;
}

std::optional<ObjReference> referenceOf(std::string_view word, std::size_t before,
                                        std::size_t total) {
    std::int64_t number = 0;
    if (!parseNumber(word, number)) return std::nullopt;
    const std::int64_t index = number < 0 ? static_cast<std::int64_t>(before) + number : number - 1;
    if (index < 0 || index >= static_cast<std::int64_t>(total)) return std::nullopt;
    return ObjReference{number, static_cast<std::size_t>(index)};
}

std::optional<ObjCorner> cornerOf(std::string_view word) {
    const std::size_t first = word.find('/');
    if (first == std::string_view::npos) return std::nullopt;
    const std::size_t second = word.find('/', first + 1);
    if (second == std::string_view::npos) return std::nullopt;
    return ObjCorner{word.substr(0, first), word.substr(second + 1)};
}

Point3 readObjNormal(ObjWords& words) {
    Point3 normal{};
    for (double& component : normal) component = parseReal(words.next(), Precision::Double);
    return normal;
}

}  // namespace espalier::io

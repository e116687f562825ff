// SPDX-License-Identifier: Apache-2.0
#include "nastran_card.h"

#include <espalier/base/error.h>
#include <espalier/io/files/file.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "../models/coordinates.h"
#include "decimal_digits.h"

namespace espalier::io {
namespace {

constexpr std::string_view kSpace = " \t\r\v\f";

/// Number of characters of a name, or of a mark of continuation.
constexpr std::size_t kNameWidth = 8;

std::string upperCase(std::string_view text) {
    std::string result(text);
    for (char& c : result)
        if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
    return result;
}

bool isLetterOfName(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

/// Returns the column after one, where a tab goes to the next multiple of 8.
std::size_t columnAfter(std::size_t column, char c) {
    constexpr std::size_t kTab = 8;
    return c == '\t' ? (column / kTab + 1) * kTab : column + 1;
}

std::size_t columnCount(std::string_view line) {
    std::size_t column = 0;
    for (const char c : line) column = columnAfter(column, c);
    return column;
}

/// Returns the position of a column in a line; its size if it ends before. No tab goes beyond the
/// begin of a field, since fields begin at multiples of 8.
std::size_t positionOf(std::string_view line, std::size_t wanted) {
    if (line.substr(0, wanted).find('\t') == std::string_view::npos)
        return std::min(wanted, line.size());
    std::size_t position = 0;
    for (std::size_t column = 0; position < line.size() && column < wanted; ++position)
        column = columnAfter(column, line[position]);
    return position;
}

/// Returns the name or the mark of continuation of a line, and whether commas separate its fields.
std::pair<std::string_view, bool> headOf(std::string_view line) {
    const std::size_t comma = line.find(',');
    if (comma != std::string_view::npos) return {trimmed(line.substr(0, comma)), true};
    return {trimmed(line.substr(0, positionOf(line, kNameWidth))), false};
}

NastranLine lineOf(std::string_view text) {
    const auto [head, isFree] = headOf(text);
    return {text, isFree, head.find('*') != std::string_view::npos};
}

/// Where a field of a line with commas is: begin and end of the text between its commas; nothing if
/// the line has fewer fields.
std::optional<std::pair<std::size_t, std::size_t>> freeField(std::string_view text,
                                                             std::size_t field) {
    std::size_t comma = text.find(',');
    for (std::size_t i = 0; i < field && comma != std::string_view::npos; ++i)
        comma = text.find(',', comma + 1);
    if (comma == std::string_view::npos) return std::nullopt;
    return std::pair(comma + 1, std::min(text.find(',', comma + 1), text.size()));
}

/// Returns the shorter one of "123.4" and "1.234+2".
std::string shortText(const DecimalDigits& number) {
    const int size = static_cast<int>(number.digits.size());
    const std::string power = std::to_string(number.power - 1);
    std::string scientific = number.digits;
    scientific.insert(1, 1, '.');
    scientific += (number.power > 0 ? "+" : "") + power;
    const int zeros = number.power < 0 ? -number.power : std::max(number.power - size, 0);
    if (size + 1 + zeros > static_cast<int>(scientific.size())) return scientific;
    std::string fixed = number.digits;
    if (number.power <= 0)
        fixed.insert(0, "." + std::string(static_cast<std::size_t>(zeros), '0'));
    else
        fixed.append(static_cast<std::size_t>(zeros), '0')
            .insert(static_cast<std::size_t>(number.power), 1, '.');
    return fixed;
}

}  // namespace

std::string_view NastranLine::field(std::size_t field) const {
    if (!isFree) {
        const std::size_t column = kNameWidth + field * width();
        const std::size_t begin = positionOf(text, column);
        return trimmed(text.substr(begin, positionOf(text, column + width()) - begin));
    }
    const auto place = freeField(text, field);
    return place ? trimmed(text.substr(place->first, place->second - place->first))
                 : std::string_view();
}

std::string NastranLine::withField(std::size_t field, std::string_view value) const {
    std::string result(text);
    if (isFree) {
        const auto place = freeField(text, field);
        if (!place) {
            result.erase(result.find_last_not_of(kSpace) + 1);
            const auto commas = static_cast<std::size_t>(std::ranges::count(result, ','));
            return result.append(field + 1 - commas, ',').append(value);
        }
        const std::string_view old = this->field(field);
        if (old.empty()) return result.replace(place->first, place->second - place->first, value);
        return result.replace(static_cast<std::size_t>(old.data() - text.data()), old.size(),
                              value);
    }
    const std::size_t column = kNameWidth + field * width(), columns = columnCount(text);
    if (columns < column + width()) result.append(column + width() - columns, ' ');
    const std::size_t begin = positionOf(result, column);
    const std::size_t length = positionOf(result, column + width()) - begin;
    std::string padded(value);
    const std::size_t spaces = width() - std::min(value.size(), width());
    // The number stays at the right or at the left of its field.
    if (columns > column && result[begin] != ' ' && result[begin] != '\t')
        padded.append(spaces, ' ');
    else
        padded.insert(0, spaces, ' ');
    return result.replace(begin, length, padded);
}

NastranLine nastranLineAt(std::string_view bytes, std::size_t offset) {
    std::string_view text = bytes.substr(offset);
    text = text.substr(0, text.find_first_of("$\n"));
    if (text.ends_with('\r')) text.remove_suffix(1);
    return lineOf(text);
}

NastranReader::NastranReader(const std::filesystem::path& path, std::string_view bytes)
    : path_(path), bytes_(bytes), text_(path, bytes) {
    seekBulk();
}

/// Goes behind the line BEGIN BULK, if the file has it. A file without it has bulk data only.
void NastranReader::seekBulk() {
    TextReader text(path_, bytes_);
    while (!text.atEnd()) {
        std::string_view line = text.restOfLine();
        if (upperCase(takeWord(line)) != "BEGIN") continue;
        const std::string what = upperCase(takeWord(line));
        if (!what.starts_with("BULK") && !what.starts_with("SUPER")) continue;
        text_ = text;
        return;
    }
}

std::optional<std::string_view> NastranReader::nextLine() {
    if (pending_) return std::exchange(pending_, std::nullopt);
    while (text_.remaining() > 0) {
        std::string_view line = text_.restOfLine();
        line = line.substr(0, line.find('$'));
        if (line.find_first_not_of(kSpace) == std::string_view::npos) continue;
        pendingLine_ = text_.line();
        return line;
    }
    return std::nullopt;
}

bool NastranReader::next() {
    lines_.clear();
    while (const auto line = nextLine()) {
        if (lines_.empty()) {
            std::string_view head = headOf(*line).first;
            // A continuation without an entry before it, and other lines, such as INCLUDE with a
            // long name, are no entries.
            if (head.empty() || !isLetterOfName(head.front())) continue;
            head = head.substr(0, head.find_first_of("* \t="));
            name_ = upperCase(head);
            if (name_ == "ENDDATA") return false;
            lines_.push_back(lineOf(*line));
            line_ = pendingLine_;
            continue;
        }
        const std::string_view head = headOf(*line).first;
        if (!head.empty() && head.front() != '+' && head.front() != '*') {
            pending_ = line;
            break;
        }
        lines_.push_back(lineOf(*line));
    }
    return !lines_.empty();
}

std::string_view NastranReader::field(std::size_t field) const {
    std::size_t begin = 0;
    for (const NastranLine& line : lines_) {
        // Eight fields are one line, or two lines of four.
        if (!line.isLarge) begin = (begin + 7) / 8 * 8;
        if (field < begin) return {};
        if (field < begin + line.fieldCount()) return line.field(field - begin);
        begin += line.fieldCount();
    }
    return {};
}

std::optional<std::int64_t> NastranReader::integer(std::size_t index, const char* what) const {
    const std::string_view word = field(index);
    if (word.empty()) return std::nullopt;
    std::int64_t number = 0;
    if (!parseNumber(word, number))
        fail(concat(inQuotes(word), " is not a number; expected ", what));
    return number;
}

double NastranReader::coordinate(std::size_t index, std::size_t axis) const {
    const std::string_view word = field(index);
    if (word.empty()) return 0;
    const auto number = parseNastranReal(word);
    if (!number)
        fail(concat(inQuotes(word), " is not a number; expected ", axisName(axis), " of a point"));
    return *number;
}

void NastranReader::fail(const std::string& cause) const {
    throw FileError(path_, line_, cause);
}

std::optional<double> parseNastranReal(std::string_view word) {
    double number = 0;
    if (!parseNumber(word, number)) {
        // The exponent begins with a sign alone, or with a D.
        std::string text(word);
        const std::size_t letter = text.find_first_of("dDeE");
        const std::size_t sign = text.find_first_of("+-", 1);
        if (letter != std::string::npos)
            text[letter] = 'e';
        else if (sign != std::string::npos)
            text.insert(sign, 1, 'e');
        if (!parseNumber(text, number)) return std::nullopt;
    }
    return std::isfinite(number) ? std::optional(number) : std::nullopt;
}

std::string nastranText(double number, std::size_t width) {
    if (number == 0) return std::signbit(number) ? "-0." : "0.";
    const DecimalDigits all = digitsOf(std::abs(number));
    const std::string sign = number < 0 ? "-" : "";
    for (std::size_t count = all.digits.size(); count > 1; --count) {
        std::string text = sign + shortText(rounded(all, count));
        if (width == 0 || text.size() <= width) {
            if (parseNastranReal(text)) return text;
            // Rounding has exceeded the largest number.
            DecimalDigits cut = all;
            cut.digits.resize(count);
            return sign + shortText(cut);
        }
    }
    return sign + shortText(rounded(all, 1));
}

double roundedToField(double number, std::size_t width) {
    return width == 0 ? number : *parseNastranReal(nastranText(number, width));
}

double largestRounding(double size, std::size_t width) {
    // A negative number has the fewest digits: "-1234.56" or "-1.235+9" in 8 characters.
    int places = 0;  ///< before the decimal point
    for (double rest = std::abs(size); rest >= 1 && places < 400; rest /= 10) ++places;
    const int room = static_cast<int>(width) - 2;
    int digits = room;
    if (places > room) digits = room - 1 - static_cast<int>(std::to_string(places - 1).size());
    return 0.5 * std::pow(10.0, places - digits);
}

}  // namespace espalier::io

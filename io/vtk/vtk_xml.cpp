// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/memory.h>
#include <espalier/base/number_text.h>
#include <espalier/base/progress.h>
#include <espalier/base/utf8.h>
#include <espalier/io/files/file.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>

#include "../files/bytes.h"
#include "vtk_xml.h"

namespace espalier::io {

const VtkDataArray* VtkSection::find(std::string_view name) const {
    const auto at = std::find_if(arrays.begin(), arrays.end(),
                                 [&](const VtkDataArray& array) { return array.name == name; });
    return at == arrays.end() ? nullptr : &*at;
}

std::size_t VtkXmlFile::count(const VtkPiece& piece, const std::string& name) const {
    const auto at = piece.counts.find(name);
    if (at == piece.counts.end()) fail(piece.line, "the Piece has no " + name);
    return at->second;
}

const VtkSection& VtkXmlFile::section(const VtkPiece& piece, const std::string& name) const {
    const auto at = piece.sections.find(name);
    if (at == piece.sections.end()) fail(piece.line, "the Piece has no " + name);
    return at->second;
}

const VtkDataArray& VtkXmlFile::array(const VtkSection& section, const std::string& name) const {
    const VtkDataArray* array = section.find(name);
    if (!array) fail(section.line, "there is no array " + inQuotes(name));
    return *array;
}

template <class Value>
std::vector<Value> VtkXmlFile::inlineText(const VtkDataArray& array) const {
    const std::string_view bytes = bytes_;
    const std::string_view tag = bytes.substr(array.begin, array.contentBegin - array.begin);
    const std::size_t tagLines = std::count(tag.begin(), tag.end(), '\n');
    TextReader text(path_, bytes.substr(array.contentBegin, array.contentEnd - array.contentBegin),
                    array.line + tagLines);
    const std::string what = "a number of the array " + inQuotes(array.name);
    std::vector<Value> values;
    while (!text.atEnd()) values.push_back(readNumber<Value>(text, *array.type, what.c_str()));
    return values;
}

/// Returns true if the text of an inline array has exactly the bytes of a header and `size` bytes
/// that are not compressed. OpenFOAM 1912 writes four times the right size into the headers of
/// Int32 arrays; VTK reads them.
bool VtkXmlFile::isWholePayload(std::string_view text, std::size_t size) const {
    constexpr std::size_t kMaxSize = std::numeric_limits<std::size_t>::max() / 16;
    if (coding_.isCompressed || size > kMaxSize) return false;
    const std::size_t withHeader = size + (coding_.has64BitHeader ? 8 : 4);
    const auto isSpace = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
    const std::size_t characters = text.size() - std::ranges::count_if(text, isSpace);
    return characters == (withHeader + 2) / 3 * 4;
}

std::string VtkXmlFile::payload(const VtkDataArray& array, const Expected& expected) const {
    if (!unknownCompressor_.empty())
        failIn(array, "is compressed with " + inQuotes(unknownCompressor_) +
                          "; only vtkZLibDataCompressor and no compressor can be read");
    const std::string_view bytes = bytes_;
    const bool isAppended = array.format == VtkDataArray::Format::Appended;
    if (isAppended && array.offset > appendedEnd_ - appendedBegin_)
        failIn(array,
               concat("begins at offset ", array.offset, " of the appended data, which have ",
                      appendedEnd_ - appendedBegin_, " bytes"));
    const std::size_t begin = isAppended ? appendedBegin_ + array.offset : array.contentBegin;
    const std::size_t end = isAppended ? appendedEnd_ : array.contentEnd;
    const std::string_view text = bytes.substr(begin, end - begin);
    // Some writers omit the header of an empty array.
    if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) return {};
    try {
        const PayloadForm form = isAppended ? appendedForm_ : PayloadForm::Base64;
        const std::uint64_t claimed = claimedSize(text, form, coding_);
        const std::size_t size = saturatingProduct(
            saturatingProduct(expected.maxTuples, expected.components), byteSize(*array.type));
        if (claimed != size && !isAppended && isWholePayload(text, size))
            return decodePayloadOfSize(text, size, form, coding_);
        // A small file can claim a large array, so the claimed size is checked before inflating.
        checkCount(array, sizeInMemory(claimed / byteSize(*array.type)), expected);
        return decodePayload(text, form, coding_);
    } catch (const CodingError& error) {
        failIn(array, std::string("cannot be decoded: ") + error.what());
    } catch (const MemoryError& error) {
        throw MemoryError(nameOf(array) + ": " + error.what());
    }
}

template <class Value>
std::vector<Value> VtkXmlFile::values(const VtkDataArray& array, const Expected& expected) const {
    if (!array.type) failIn(array, "does not hold numbers that can be read");
    if (std::is_integral_v<Value> && !isInteger(*array.type))
        failIn(array, std::string("holds ") + xmlName(*array.type) + "; expected integers");
    std::vector<Value> values;
    if (array.format == VtkDataArray::Format::Ascii) {
        values = inlineText<Value>(array);
    } else {
        const std::string bytes = payload(array, expected);
        if (bytes.size() % byteSize(*array.type) != 0)
            failIn(array, concat("has ", bytes.size(), " bytes, which are not a whole number of ",
                                 xmlName(*array.type)));
        requireMemory(bytes.size() / byteSize(*array.type) * sizeof(Value), nameOf(array));
        values = decodeNumbers<Value>(bytes, *array.type, coding_.byteOrder);
    }
    if (values.size() % array.components != 0)
        failIn(array,
               concat("has ", values.size(), " numbers, which are not a whole number of tuples of ",
                      array.components));
    checkCount(array, values.size(), expected);
    return values;
}

void VtkXmlFile::checkCount(const VtkDataArray& array, std::size_t got,
                            const Expected& expected) const {
    const std::size_t tuples = got / expected.components;
    if (tuples >= expected.minTuples && tuples <= expected.maxTuples) return;
    std::string text = concat("has ", got, " numbers; expected ");
    if (expected.minTuples < expected.maxTuples) text += "at most ";
    text += std::to_string(expected.maxTuples);
    if (expected.components > 1) text += concat(" times ", expected.components);
    if (!expected.reason.empty()) text += ", " + std::string(expected.reason);
    failIn(array, text);
}

std::vector<double> VtkXmlFile::reals(const VtkDataArray& array, std::size_t tuples,
                                      std::string_view reason) const {
    return values<double>(array, {tuples, tuples, array.components, reason});
}

std::vector<std::int64_t> VtkXmlFile::integers(const VtkDataArray& array, std::size_t tuples,
                                               std::string_view reason) const {
    return values<std::int64_t>(array, {tuples, tuples, array.components, reason});
}

std::vector<std::int64_t> VtkXmlFile::list(const VtkDataArray& array, std::size_t count,
                                           std::string_view reason) const {
    return values<std::int64_t>(array, {count, count, 1, reason});
}

std::vector<std::int64_t> VtkXmlFile::integersUpTo(const VtkDataArray& array, std::size_t maxTuples,
                                                   std::string_view reason) const {
    return values<std::int64_t>(array, {0, maxTuples, array.components, reason});
}

void VtkXmlFile::fail(std::size_t line, const std::string& cause) const {
    throw FileError(path_, line, cause);
}

std::string VtkXmlFile::nameOf(const VtkDataArray& array) const {
    return concat(shownPath(path_), ":", array.line, ": the array ", inQuotes(array.name));
}

void VtkXmlFile::failIn(const VtkDataArray& array, const std::string& cause) const {
    fail(array.line, "the array " + inQuotes(array.name) + " " + cause);
}

namespace {

template <class Number>
void append(std::string& text, Number number) {
    text.append(NumberText(number).view());
}

/// Returns numbers as lines of text, with one tuple per line, or 12 numbers if a tuple is a single
/// number.
template <class Value>
std::string asciiLines(const VtkArrayHead& head, std::span<const Value> values,
                       std::string_view indent) {
    constexpr std::size_t kNumbersOnALine = 12;
    const std::size_t onALine = head.components > 1 ? head.components : kNumbersOnALine;
    std::string text;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (i % onALine == 0)
            text.append("\n").append(indent).append("  ");
        else
            text += ' ';
        if (std::is_floating_point_v<Value> && head.type == NumberType::Float32)
            append(text, static_cast<float>(values[i]));
        else if (std::is_integral_v<Value> && head.type == NumberType::UInt64)
            append(text, static_cast<std::uint64_t>(values[i]));
        else
            append(text, values[i]);
    }
    return text;
}

}  // namespace

template <class Value>
std::string dataArrayElement(const VtkArrayHead& head, std::span<const Value> values,
                             VtkArrayForm form, const VtkCoding& coding, std::string_view indent) {
    const bool isAscii = form == VtkArrayForm::Ascii;
    std::string text = std::string("<DataArray type=\"") + xmlName(head.type) + "\" Name=\"" +
                       xmlEscaped(head.name) + "\"";
    if (head.components != 1) text += concat(" NumberOfComponents=\"", head.components, "\"");
    if (head.hasTupleCount)
        text += concat(" NumberOfTuples=\"", values.size() / head.components, "\"");
    text += isAscii ? " format=\"ascii\">" : " format=\"binary\">";
    if (isAscii) {
        text += asciiLines(head, values, indent);
    } else {
        text.append("\n").append(indent).append("  ");
        appendPayload(text, values, head.type, coding);
    }
    return text.append("\n").append(indent).append("</DataArray>");
}

bool isXmlText(std::string_view text) {
    while (!text.empty()) {
        const CodePoint point = firstCodePoint(text);
        const std::uint32_t value = point.value;
        const bool isSpace = value == '\t' || value == '\n' || value == '\r';
        if (!point.isCharacter || (value < 0x20 && !isSpace) || value == 0xFFFE || value == 0xFFFF)
            return false;
        text.remove_prefix(point.size);
    }
    return true;
}

std::string xmlEscaped(std::string_view text) {
    std::string result;
    for (const char c : text) {
        const auto code = static_cast<unsigned char>(c);
        if (code < 0x20 || c == '&' || c == '<' || c == '>' || c == '"')
            result += concat("&#", code, ";");
        else
            result += c;
    }
    return result;
}

#define ESPALIER_INSTANTIATE(Value)                                                    \
    template std::string dataArrayElement(const VtkArrayHead&, std::span<const Value>, \
                                          VtkArrayForm, const VtkCoding&, std::string_view);
ESPALIER_INSTANTIATE(double)
ESPALIER_INSTANTIATE(std::int64_t)
ESPALIER_INSTANTIATE(Index)
ESPALIER_INSTANTIATE(std::uint8_t)
#undef ESPALIER_INSTANTIATE

std::vector<Point3> pointsOf(std::span<const double> coordinates) {
    std::vector<Point3> points(coordinates.size() / 3);
    for (std::size_t i = 0; i < points.size(); ++i)
        points[i] = {coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]};
    return points;
}

std::vector<double> coordinatesOf(std::span<const Point3> points) {
    std::vector<double> coordinates;
    coordinates.reserve(3 * points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        checkCancelledEvery(i, 16);
        coordinates.insert(coordinates.end(), points[i].begin(), points[i].end());
    }
    return coordinates;
}

void checkFinite(const std::filesystem::path& path, std::span<const Point3> points) {
    for (std::size_t i = 0; i < points.size(); ++i)
        for (const double coordinate : points[i])
            if (!std::isfinite(coordinate))
                throw FileError(path, concat("point ", i, " is not finite"));
}

const VtkDataArray& pointArray(const VtkXmlFile& file, const VtkPiece& piece) {
    const VtkSection& section = file.section(piece, "Points");
    if (section.arrays.size() != 1 || section.arrays[0].components != 3)
        file.fail(section.line, concat("Points has ", section.arrays.size(),
                                       " arrays; expected one, of 3 components"));
    return section.arrays[0];
}

std::vector<Point3> readPoints(const VtkXmlFile& file, const VtkPiece& piece) {
    const std::size_t count = file.count(piece, "NumberOfPoints");
    if (count == 0) return {};
    return pointsOf(file.reals(pointArray(file, piece), count));
}

VtkRows::VtkRows(const VtkXmlFile& file, const VtkSection& section, const char* values,
                 const char* offsets, std::size_t count, std::string_view reason)
    : ends_(file.list(file.array(section, offsets), count, reason)) {
    std::int64_t before = 0;
    for (const std::int64_t end : ends_) {
        if (end < before)
            file.fail(file.array(section, offsets).line,
                      concat("the array ", inQuotes(offsets), " has ", end, " after ", before,
                             "; expected ascending offsets"));
        before = end;
    }
    values_ =
        file.list(file.array(section, values), sizeInMemory(static_cast<std::uint64_t>(before)),
                  "the last of " + inQuotes(offsets));
}

}  // namespace espalier::io

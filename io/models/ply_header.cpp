// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <cstdint>

#include "../files/text_reader.h"
#include "ply_header.h"

namespace espalier::io {
namespace {

struct TypeName {
    std::string_view name;
    NumberType type;
};

constexpr TypeName kTypeNames[] = {
    {"char", NumberType::Int8},      {"int8", NumberType::Int8},
    {"uchar", NumberType::UInt8},    {"uint8", NumberType::UInt8},
    {"short", NumberType::Int16},    {"int16", NumberType::Int16},
    {"ushort", NumberType::UInt16},  {"uint16", NumberType::UInt16},
    {"int", NumberType::Int32},      {"int32", NumberType::Int32},
    {"uint", NumberType::UInt32},    {"uint32", NumberType::UInt32},
    {"float", NumberType::Float32},  {"float32", NumberType::Float32},
    {"double", NumberType::Float64}, {"float64", NumberType::Float64}};

class HeaderParser {
public:
    HeaderParser(const std::filesystem::path& path, std::string_view bytes) : lines_(path, bytes) {}

    PlyHeader parse() {
        std::string_view first = nextLine();
        if (takeWord(first) != "ply") lines_.fail("not a PLY file; expected 'ply'");
        while (parseLine()) {
        }
        if (!format_) lines_.fail("the header has no line 'format'");
        header_.format = *format_;
        findPoints();
        header_.size = lines_.position();
        header_.lineCount = lines_.line();
        return std::move(header_);
    }

private:
    std::string_view nextLine() {
        if (lines_.remaining() == 0) lines_.fail("the file ends in its header");
        return lines_.restOfLine();
    }

    /// \return false for the last line of the header
    bool parseLine() {
        std::string_view line = nextLine();
        const std::string_view whole = line;
        const std::string_view keyword = takeWord(line);
        if (keyword == "comment" || keyword == "obj_info") return true;
        if (keyword == "format")
            parseFormat(line);
        else if (keyword == "element")
            parseElement(line);
        else if (keyword == "property")
            parseProperty(line);
        else if (keyword != "end_header")
            return keepOddLine(keyword, whole);
        if (const std::string_view more = takeWord(line); !more.empty())
            lines_.fail("expected the end of the line, got " + inQuotes(more));
        return keyword != "end_header";
    }

    /// Counts a line that is not of the format, such as the stamp of an exporter.
    bool keepOddLine(std::string_view keyword, std::string_view line) {
        constexpr std::string_view kKeywords[] = {"format", "element", "property", "end_header"};
        // A keyword in upper case is no stamp: without it, the rows would be misread.
        if (!canBeOdd(keyword, line) || std::ranges::count(kKeywords, lowerCase(keyword)) > 0)
            lines_.fail(inQuotes(keyword) + " does not begin a line of a PLY header");
        header_.oddLines.add(keyword, lines_.line());
        return true;
    }

    void parseFormat(std::string_view& line) {
        if (format_) lines_.fail("a second line 'format'");
        const std::string_view name = takeWord(line);
        if (name == "ascii")
            format_ = PlyFormat::Ascii;
        else if (name == "binary_little_endian")
            format_ = PlyFormat::BinaryLittleEndian;
        else if (name == "binary_big_endian")
            format_ = PlyFormat::BinaryBigEndian;
        else
            lines_.fail(inQuotes(name) +
                        " is not a format; expected ascii, binary_little_endian or "
                        "binary_big_endian");
        if (const std::string_view version = takeWord(line); version != "1.0")
            lines_.fail("version " + inQuotes(version) + " is not known; expected 1.0");
    }

    void parseElement(std::string_view& line) {
        PlyElement& element = header_.elements.emplace_back();
        element.name = takeWord(line);
        if (element.name.empty()) lines_.fail("the line ends; expected the name of an element");
        const std::string_view count = takeWord(line);
        if (!parseNumber(count, element.count))
            lines_.fail(inQuotes(count) + " is not a number of rows of the element " +
                        inQuotes(element.name));
    }

    void parseProperty(std::string_view& line) {
        if (header_.elements.empty()) lines_.fail("a property before the first element");
        PlyProperty& property = header_.elements.back().properties.emplace_back();
        std::string_view type = takeWord(line);
        if (type == "list") {
            property.lengthType = typeOf(takeWord(line));
            if (!isInteger(*property.lengthType))
                lines_.fail("the length of a list is not an integer");
            type = takeWord(line);
        }
        property.type = typeOf(type);
        property.name = takeWord(line);
        if (property.name.empty()) lines_.fail("the line ends; expected the name of a property");
    }

    NumberType typeOf(std::string_view word) const {
        for (const TypeName& entry : kTypeNames)
            if (entry.name == word) return entry.type;
        lines_.fail(inQuotes(word) +
                    " is not a type; expected char, uchar, short, ushort, int, "
                    "uint, float, double, or int8 to float64");
    }

    void findPoints() {
        const auto isVertex = [](const PlyElement& element) { return element.name == "vertex"; };
        const auto& elements = header_.elements;
        const auto found = std::find_if(elements.begin(), elements.end(), isVertex);
        if (found == elements.end()) lines_.fail("the header has no element 'vertex'");
        if (std::count_if(elements.begin(), elements.end(), isVertex) > 1)
            lines_.fail("the header has several elements 'vertex'");
        header_.vertexElement = found - elements.begin();
        for (std::size_t axis = 0; axis < 3; ++axis) header_.axes[axis] = findAxis(*found, axis);
        addDirection(*found, {"nx", "ny", "nz"}, carryNormal);
        addDirection(*found, {"tx", "ty", "tz"}, carryTangent);
        findSplats(*found);
    }

    /// Returns the number of the property of this name; nothing unless it exists exactly once and
    /// holds a real number.
    static std::optional<std::size_t> realColumn(const PlyElement& vertex, std::string_view name) {
        const auto isNamed = [&](const PlyProperty& property) { return property.name == name; };
        const auto& properties = vertex.properties;
        const auto found = std::find_if(properties.begin(), properties.end(), isNamed);
        if (std::count_if(properties.begin(), properties.end(), isNamed) != 1) return {};
        if (found->lengthType || isInteger(found->type)) return {};
        return found - properties.begin();
    }

    /// Adds a direction if the vertices have exactly one property of each name, and it holds a real
    /// number.
    void addDirection(const PlyElement& vertex, const std::array<std::string_view, 3>& names,
                      Carry carry) {
        PlyDirection direction{{}, carry};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto column = realColumn(vertex, names[axis]);
            if (!column) return;
            direction.columns[axis] = *column;
        }
        header_.directions.push_back(direction);
    }

    /// Finds the properties of splats. A vertex with lists is no splat, since its numbers would not
    /// be at the same place in each row.
    void findSplats(const PlyElement& vertex) {
        if (vertex.hasLists()) return;
        std::vector<std::size_t> columns;
        for (const char* name :
             {"scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"}) {
            const auto column = realColumn(vertex, name);
            if (!column) return;
            columns.push_back(*column);
        }
        const std::size_t harmonics = std::ranges::count_if(
            vertex.properties,
            [](const PlyProperty& property) { return property.name.starts_with("f_rest_"); });
        header_.splats = {columns, harmonics};
        if (!isHarmonicCount(harmonics)) return;
        for (std::size_t i = 0; i < harmonics; ++i) {
            const auto column = realColumn(vertex, concat("f_rest_", i));
            if (!column) return;
            columns.push_back(*column);
        }
        header_.splats = {columns, 0};
    }

    std::size_t findAxis(const PlyElement& vertex, std::size_t axis) const {
        const std::string name = axisName(axis);
        const auto isAxis = [&](const PlyProperty& property) { return property.name == name; };
        const auto& properties = vertex.properties;
        const auto found = std::find_if(properties.begin(), properties.end(), isAxis);
        if (found == properties.end())
            lines_.fail("the vertices have no property " + inQuotes(name));
        if (std::count_if(properties.begin(), properties.end(), isAxis) > 1)
            lines_.fail("the vertices have several properties " + inQuotes(name));
        if (found->lengthType || isInteger(found->type))
            lines_.fail("the property " + inQuotes(name) + " of the vertices is " +
                        (found->lengthType ? "a list" : "an integer") +
                        ", and cannot hold a deformed position; expected float or double");
        return found - properties.begin();
    }

    TextReader lines_;
    std::optional<PlyFormat> format_;
    PlyHeader header_;
};

}  // namespace

std::size_t PlyElement::smallestRow() const {
    std::size_t bytes = 0;
    for (const PlyProperty& property : properties)
        bytes += byteSize(property.lengthType.value_or(property.type));
    return bytes;
}

bool PlyElement::hasLists() const {
    return std::any_of(properties.begin(), properties.end(),
                       [](const PlyProperty& property) { return property.lengthType.has_value(); });
}

std::array<Precision, 3> PlyHeader::precisions(const std::array<std::size_t, 3>& columns) const {
    std::array<Precision, 3> result{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const bool isFloat = vertices().properties[columns[axis]].type == NumberType::Float32;
        result[axis] = isFloat ? Precision::Float : Precision::Double;
    }
    return result;
}

FileSplats PlyHeader::fileSplats() const {
    FileSplats result;
    result.keptHarmonics = splats.keptHarmonics;
    const auto& properties = vertices().properties;
    for (std::size_t number = 0; number < splats.columns.size(); ++number) {
        const std::size_t column = splats.columns[number];
        std::size_t bytes = 0;
        for (std::size_t i = 0; i < column; ++i) bytes += byteSize(properties[i].type);
        const bool isFloat = properties[column].type == NumberType::Float32;
        result.columns.push_back({format == PlyFormat::Ascii ? column : bytes, number,
                                  isFloat ? Precision::Float : Precision::Double});
    }
    std::ranges::sort(result.columns,
                      [](const auto& a, const auto& b) { return a.place < b.place; });
    return result;
}

std::endian PlyHeader::byteOrder() const {
    return format == PlyFormat::BinaryBigEndian ? std::endian::big : std::endian::little;
}

PlyHeader parsePlyHeader(const std::filesystem::path& path, std::string_view bytes) {
    return HeaderParser(path, bytes).parse();
}

}  // namespace espalier::io

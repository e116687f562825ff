// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>
#include <espalier/base/memory.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <bit>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "../files/number_types.h"
#include "vtk_cells.h"

namespace espalier::io {

/// Rows of vertices: CELLS, POLYGONS and the like.
struct LegacyRows {
    std::vector<std::int64_t> offsets;  ///< row i begins in `values` at offsets[i]; one for the end
    std::vector<std::int64_t> values;

    std::size_t count() const { return offsets.empty() ? 0 : offsets.size() - 1; }
    std::span<const std::int64_t> operator[](std::size_t row) const {
        const std::size_t begin = offsets[row], end = offsets[row + 1];
        return std::span(values).subspan(begin, end - begin);
    }
};

/// Cells of an unstructured grid, and their types.
struct LegacyCells {
    LegacyRows rows;
    std::vector<std::int64_t> types;

    /// Adds a cell.
    void add(std::int64_t type, std::span<const Index> points) {
        if (rows.offsets.empty()) rows.offsets.push_back(0);
        rows.values.insert(rows.values.end(), points.begin(), points.end());
        rows.offsets.push_back(static_cast<std::int64_t>(rows.values.size()));
        types.push_back(type);
    }
};

/// Passes the cells of CELLS and CELL_TYPES to a reader.
/// \throws FileError if the numbers of cells and types differ; as VtkCellReader
inline void addLegacyCells(const std::filesystem::path& path, const LegacyCells& from,
                           VtkCellReader& cells) {
    const auto& [rows, types] = from;
    if (types.size() != rows.count())
        throw FileError(path,
                        concat("has ", rows.count(), " cells and ", types.size(), " cell types"));
    for (std::size_t cell = 0; cell < types.size(); ++cell) {
        if (types[cell] == kVtkPolyhedron)
            cells.addPolyhedron(rows[cell]);
        else
            cells.add(types[cell], rows[cell]);
    }
}

/// Reads words and arrays of numbers from a legacy VTK file; the numbers are text or big-endian
/// binary data. Every error is a FileError with path and line.
class LegacyData {
public:
    /// \param text must outlive the reader
    LegacyData(const std::filesystem::path& path, std::string_view text) : text_(path, text) {}

    TextReader& text() { return text_; }
    const TextReader& text() const { return text_; }
    bool isBinary() const { return isBinary_; }

    /// Reads the head of the file, and returns the kind of data set: "unstructured_grid",
    /// "structured_grid" or "polydata".
    std::string readHeader() {
        constexpr std::string_view kMagic = "# vtk datafile version ";
        const std::string first = lowerCase(text_.restOfLine());
        if (!first.starts_with(kMagic))
            text_.fail("is not a legacy VTK file: it does not begin with '# vtk DataFile Version'");
        const std::string_view version = std::string_view(first).substr(kMagic.size());
        if (!parseNumber(version.substr(0, version.find_first_of(". \t")), version_) ||
            version_ < 1 || version_ > 5)
            text_.fail("is of version " + inQuotes(version) + "; 1 to 5 can be read");
        text_.restOfLine();  // the title
        const std::string encoding = keyword("ASCII or BINARY");
        if (encoding != "ascii" && encoding != "binary")
            text_.fail("expected ASCII or BINARY, got " + inQuotes(encoding));
        isBinary_ = encoding == "binary";
        expect("DATASET");
        const std::string dataSet = keyword("UNSTRUCTURED_GRID");
        const char* const expected = "expected UNSTRUCTURED_GRID, POLYDATA or STRUCTURED_GRID";
        if (dataSet == "rectilinear_grid" || dataSet == "structured_points")
            text_.fail("holds " + inQuotes(dataSet) +
                       ", which has no list of points that could be moved; " + expected);
        if (dataSet != "unstructured_grid" && dataSet != "polydata" && dataSet != "structured_grid")
            text_.fail("holds " + inQuotes(dataSet) + "; " + expected);
        return dataSet;
    }

    /// Reads the next keyword, and returns it in lower case.
    std::string keyword(const char* what) { return lowerCase(text_.token(what)); }

    /// Reads the next word.
    /// \throws FileError if the word is not `word`, in upper or lower case
    void expect(const char* word) {
        const std::string got(text_.token(word));
        if (lowerCase(got) != lowerCase(word))
            text_.fail("expected " + std::string(word) + ", got " + inQuotes(got));
    }

    /// Reads a name, and decodes "%20" and the like.
    std::string name() {
        const std::string_view token = text_.token("a name");
        std::string name;
        for (std::size_t i = 0; i < token.size(); ++i) {
            unsigned code = 0;
            const char* digits = token.data() + i + 1;
            if (token[i] == '%' && i + 2 < token.size() &&
                std::from_chars(digits, digits + 2, code, 16).ptr == digits + 2) {
                name += static_cast<char>(code);
                i += 2;
            } else {
                name += token[i];
            }
        }
        return name;
    }

    /// Reads `count` numbers.
    /// \param type in lower case: "float"
    /// \throws FileError if the type is unknown or not of this kind, or if fewer numbers are left
    template <class Value>
    std::vector<Value> numbers(const std::string& type, std::size_t count, const char* what) {
        const NumberType number = numberTypeOf(type);
        if (std::is_integral_v<Value> && !isInteger(number))
            text_.fail(inQuotes(type) + " is not a type of integers");
        if (isBinary_) {
            beginBinary();
            return decodeNumbers<Value>(
                text_.bytes(saturatingProduct(count, byteSize(number)), what), number,
                std::endian::big);
        }
        checkRoom(count, what);
        std::vector<Value> values;
        values.reserve(count);
        for (std::size_t i = 0; i < count; ++i)
            values.push_back(readNumber<Value>(text_, number, what));
        return values;
    }

    /// Reads `count` numbers of any type. Skips bits and strings, and returns nothing for them.
    /// \param what name of a number in messages
    std::optional<std::vector<double>> values(const std::string& type, std::size_t count,
                                              const char* what) {
        if (skipNonNumbers(type, count)) return std::nullopt;
        return numbers<double>(type, count, what);
    }

    /// Skips `count` numbers, bits or strings, without memory for them.
    void skipValues(const std::string& type, std::size_t count, const char* what) {
        if (skipNonNumbers(type, count)) return;
        const NumberType number = numberTypeOf(type);
        if (isBinary_) {
            beginBinary();
            text_.bytes(saturatingProduct(count, byteSize(number)), what);
            return;
        }
        checkRoom(count, what);
        for (std::size_t i = 0; i < count; ++i) text_.token(what);
    }

    /// Reads CELLS, POLYGONS or the like after their keyword. In the layout before version 5, each
    /// row is the number of its vertices and then the vertices. Since then there is an offset per
    /// row and one for the end, and then the vertices of all rows.
    /// \param name name of the section for messages
    LegacyRows rows(const std::string& name) {
        return version_ >= 5 ? rowsByOffsets() : rowsBySizes(name);
    }

    /// Skips CELLS, POLYGONS or the like after their keyword, without memory for them.
    void skipRows() {
        const std::size_t count = text_.count("the number of cells", 1);
        const std::size_t size = text_.count("the number of their vertices", 1);
        if (version_ < 5) return skipValues("int", size, "a number of a cell");
        expect("OFFSETS");
        skipValues(keyword("the type of OFFSETS"), count, "an offset");
        expect("CONNECTIVITY");
        skipValues(keyword("the type of CONNECTIVITY"), size, "a vertex of a cell");
    }

    /// Reads a FIELD after its keyword. Calls readArray(name, type, components, tuples) for each
    /// array, which reads its numbers.
    template <class ReadArray>
    void readField(ReadArray readArray) {
        text_.token("the name of a field");
        const std::size_t count = text_.count("the number of arrays", 1);
        for (std::size_t i = 0; i < count; ++i) {
            std::string name = this->name();
            while (name == "METADATA") {
                skipMetadata();
                name = this->name();
            }
            if (name == "NULL_ARRAY") continue;
            const std::size_t components = text_.count("the number of components", 1);
            const std::size_t tuples =
                sizeInMemory(text_.number<std::uint64_t>("the number of tuples"));
            readArray(name, keyword("a type"), components, tuples);
        }
    }

    /// Throws if the rest of the text is too short for `count` numbers.
    void checkRoom(std::size_t count, const char* what) const {
        // A number and its separator have at least two bytes.
        if (count > (text_.remaining() + 1) / 2)
            text_.fail(concat("the file ends; expected ", count, " times ", what, ", got ",
                              text_.remaining(), " bytes"));
    }

    /// Goes on to the first byte of binary numbers.
    void beginBinary() { text_.restOfLine(); }

    /// Returns the type of the numbers of colours: bytes if binary, else fractions.
    const char* typeOfColours() const { return isBinary_ ? "unsigned_char" : "float"; }

    /// Skips METADATA after its keyword, up to the empty line at its end.
    void skipMetadata() {
        text_.restOfLine();
        while (text_.remaining() > 0 &&
               text_.restOfLine().find_first_not_of(" \t") != std::string::npos) {
        }
    }

private:
    NumberType numberTypeOf(const std::string& type) const {
        const std::optional<NumberType> number = numberOfLegacyName(type);
        if (!number) text_.fail(inQuotes(type) + " is not a type of numbers");
        return *number;
    }

    /// Skips bits or strings. Returns false if `type` is neither.
    bool skipNonNumbers(const std::string& type, std::size_t count) {
        if (type == "bit")
            skipBits(count);
        else if (type == "string" || type == "utf8_string")
            skipStrings(count);
        else
            return false;
        return true;
    }

    void skipBits(std::size_t count) {
        if (!isBinary_) {
            numbers<double>("int", count, "a bit");
            return;
        }
        beginBinary();
        text_.bytes(count / 8 + (count % 8 != 0 ? 1 : 0), "bits");
    }

    void skipStrings(std::size_t count) {
        text_.restOfLine();
        text_.checkRoom(count, 1, "strings");
        for (std::size_t i = 0; i < count; ++i) {
            if (isBinary_)
                skipBinaryString();
            else
                text_.restOfLine();
        }
    }

    /// Skips a string with its length. The two highest bits of the first byte give the size of the
    /// length: 8, 4, 2 or 1 bytes. The other bits of these bytes are the length.
    void skipBinaryString() {
        const auto byte = [](std::string_view bytes) {
            return static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[0]));
        };
        const std::uint64_t first = byte(text_.bytes(1, "a string"));
        const int lengthBytes = 8 >> (first >> 6);
        std::uint64_t length = first & 0x3f;
        for (int i = 1; i < lengthBytes; ++i)
            length = length << 8 | byte(text_.bytes(1, "the length of a string"));
        text_.bytes(sizeInMemory(length), "a string");
    }

    LegacyRows rowsBySizes(const std::string& name) {
        const std::size_t count = text_.count("the number of cells", 1);
        const std::string size = "the size of " + name;
        const std::string number = "a number of " + name;
        const auto list =
            numbers<std::int64_t>("int", text_.count(size.c_str(), 1), number.c_str());
        LegacyRows rows{{0}, {}};
        std::size_t at = 0;
        for (std::size_t cell = 0; cell < count; ++cell) {
            if (at == list.size() || list[at] < 0 ||
                static_cast<std::uint64_t>(list[at]) > list.size() - at - 1)
                text_.fail(concat("the numbers of ", name, " end inside cell ", cell));
            const auto length = static_cast<std::ptrdiff_t>(list[at]);
            const auto begin = list.begin() + static_cast<std::ptrdiff_t>(at) + 1;
            rows.values.insert(rows.values.end(), begin, begin + length);
            rows.offsets.push_back(static_cast<std::int64_t>(rows.values.size()));
            at += length + 1;
        }
        if (at != list.size())
            text_.fail(
                concat(name, " has ", list.size(), " numbers, of which ", at, " belong to cells"));
        return rows;
    }

    LegacyRows rowsByOffsets() {
        LegacyRows rows;
        const std::size_t offsetCount = text_.count("the number of offsets", 1);
        const std::size_t size = text_.count("the size of CONNECTIVITY", 1);
        expect("OFFSETS");
        const std::string offsetType = keyword("the type of OFFSETS");
        rows.offsets = numbers<std::int64_t>(offsetType, offsetCount, "an offset");
        expect("CONNECTIVITY");
        const std::string type = keyword("the type of CONNECTIVITY");
        rows.values = numbers<std::int64_t>(type, size, "a vertex of a cell");
        std::int64_t before = 0;
        for (const std::int64_t offset : rows.offsets) {
            if (offset < before || offset > static_cast<std::int64_t>(size))
                text_.fail(concat("OFFSETS has ", offset, " after ", before, "; CONNECTIVITY has ",
                                  size, " numbers"));
            before = offset;
        }
        return rows;
    }

    TextReader text_;
    bool isBinary_ = false;
    int version_ = 0;
};

}  // namespace espalier::io

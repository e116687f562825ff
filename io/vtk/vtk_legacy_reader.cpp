// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>
#include <espalier/io/vtk/vtk_legacy.h>

#include <bit>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "../files/number_types.h"
#include "../lattices/lattice_parts.h"
#include "vtk_cells.h"
#include "vtk_xml.h"

namespace espalier::io {
namespace {

/// Reads words and arrays of numbers from a legacy VTK file; the numbers are text or big-endian
/// binary data. Every error is a FileError with path and line.
class LegacyData {
public:
    /// \param text must outlive the reader
    LegacyData(const std::filesystem::path& path, std::string_view text) : text_(path, text) {}

    TextReader& text() { return text_; }
    void setBinary(bool isBinary) { isBinary_ = isBinary; }

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
        const std::optional<NumberType> number = numberOfLegacyName(type);
        if (!number) text_.fail(inQuotes(type) + " is not a type of numbers");
        if (std::is_integral_v<Value> && !isInteger(*number))
            text_.fail(inQuotes(type) + " is not a type of integers");
        if (isBinary_) {
            beginBinary();
            return decodeNumbers<Value>(
                text_.bytes(saturatingProduct(count, byteSize(*number)), what), *number,
                std::endian::big);
        }
        text_.checkRoom(count, 2, what);
        std::vector<Value> values;
        values.reserve(count);
        for (std::size_t i = 0; i < count; ++i)
            values.push_back(readNumber<Value>(text_, *number, what));
        return values;
    }

    /// Reads `count` numbers of any type. Skips bits and strings, and returns nothing for them.
    std::optional<std::vector<double>> values(const std::string& type, std::size_t count,
                                              const char* what) {
        if (type == "bit")
            skipBits(count);
        else if (type == "string" || type == "utf8_string")
            skipStrings(count);
        else
            return numbers<double>(type, count, what);
        return std::nullopt;
    }

    /// Skips colours: unsigned bytes if binary, else fractions.
    void skipColours(std::size_t count) {
        numbers<double>(isBinary_ ? "unsigned_char" : "float", count, "a colour");
    }

    /// Skips METADATA after its keyword, up to the empty line at its end.
    void skipMetadata() {
        text_.restOfLine();
        while (text_.remaining() > 0 &&
               text_.restOfLine().find_first_not_of(" \t") != std::string::npos) {
        }
    }

private:
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
        text_.bytes(length, "a string");
    }

    void beginBinary() { text_.restOfLine(); }

    TextReader text_;
    bool isBinary_ = false;
};

class LegacyReader {
public:
    LegacyReader(const std::filesystem::path& path, std::string_view bytes)
        : path_(path), data_(path, bytes) {}

    Lattice read(ReadNotes* notes) {
        readHeader();
        while (!text().atEnd()) readPart(data_.keyword("a keyword"));
        VtkCellReader cells(path_, checkedIndex(path_, lattice_.positions.size(), "points"));
        addCells(cells);
        lattice_.marks.vertices = vertexMarksFromFile(path_, vertexSharpness_);
        addEdgeMarks();
        return finishLattice(path_, cells.takeBuilder(), std::move(lattice_), notes);
    }

private:
    /// The owner of the arrays that follow.
    enum class Owner { DataSet, Points, Cells };

    TextReader& text() { return data_.text(); }

    void readHeader() {
        constexpr std::string_view kMagic = "# vtk datafile version ";
        const std::string first = lowerCase(text().restOfLine());
        if (!first.starts_with(kMagic))
            text().fail(
                "is not a legacy VTK file: it does not begin with '# vtk DataFile Version'");
        const std::string_view version = std::string_view(first).substr(kMagic.size());
        if (!parseNumber(version.substr(0, version.find_first_of(". \t")), version_) ||
            version_ < 1 || version_ > 5)
            text().fail("is of version " + inQuotes(version) + "; 1 to 5 can be read");
        text().restOfLine();  // the title
        const std::string encoding = data_.keyword("ASCII or BINARY");
        if (encoding != "ascii" && encoding != "binary")
            text().fail("expected ASCII or BINARY, got " + inQuotes(encoding));
        data_.setBinary(encoding == "binary");
        data_.expect("DATASET");
        const std::string dataSet = data_.keyword("UNSTRUCTURED_GRID");
        if (dataSet != "unstructured_grid")
            text().fail("holds " + inQuotes(dataSet) + "; expected UNSTRUCTURED_GRID");
    }

    void readPart(const std::string& keyword) {
        if (keyword == "metadata")
            data_.skipMetadata();
        else if (keyword == "points")
            readPoints();
        else if (keyword == "cells")
            version_ >= 5 ? readCellsByOffsets() : readCellsBySizes();
        else if (keyword == "cell_types")
            readCellTypes();
        else if (keyword == "point_data")
            beginData(Owner::Points, lattice_.positions.size(), "points");
        else if (keyword == "cell_data")
            beginData(Owner::Cells, cellOffsets_.empty() ? 0 : cellOffsets_.size() - 1, "cells");
        else if (keyword == "field")
            readField();
        else if (owner_ != Owner::DataSet)
            readAttribute(keyword);
        else
            failAt(keyword);
    }

    void readPoints() {
        const std::size_t count = text().count("the number of points", 3);
        const std::string type = data_.keyword("the type of the points");
        lattice_.positions =
            pointsOf(data_.numbers<double>(type, saturatingProduct(3, count), "a coordinate"));
    }

    /// Reads CELLS in the layout before version 5: for each cell, the number of its vertices, then
    /// the vertices.
    void readCellsBySizes() {
        const std::size_t count = text().count("the number of cells", 1);
        const std::size_t size = text().count("the size of CELLS", 1);
        const auto list = data_.numbers<std::int64_t>("int", size, "a number of CELLS");
        cellOffsets_ = {0};
        connectivity_.clear();
        std::size_t at = 0;
        for (std::size_t cell = 0; cell < count; ++cell) {
            if (at == list.size() || list[at] < 0 ||
                static_cast<std::uint64_t>(list[at]) > list.size() - at - 1)
                text().fail(concat("the numbers of CELLS end inside cell ", cell));
            const auto length = static_cast<std::ptrdiff_t>(list[at]);
            const auto begin = list.begin() + static_cast<std::ptrdiff_t>(at) + 1;
            connectivity_.insert(connectivity_.end(), begin, begin + length);
            cellOffsets_.push_back(static_cast<std::int64_t>(connectivity_.size()));
            at += static_cast<std::size_t>(length) + 1;
        }
        if (at != list.size())
            text().fail(
                concat("CELLS has ", list.size(), " numbers, of which ", at, " belong to cells"));
    }

    /// Reads CELLS in the layout since version 5: one offset per cell and one for the end, then the
    /// vertices.
    void readCellsByOffsets() {
        const std::size_t offsetCount = text().count("the number of offsets", 1);
        const std::size_t size = text().count("the size of CONNECTIVITY", 1);
        data_.expect("OFFSETS");
        const std::string offsetType = data_.keyword("the type of OFFSETS");
        cellOffsets_ = data_.numbers<std::int64_t>(offsetType, offsetCount, "an offset");
        data_.expect("CONNECTIVITY");
        const std::string type = data_.keyword("the type of CONNECTIVITY");
        connectivity_ = data_.numbers<std::int64_t>(type, size, "a vertex of a cell");
        std::int64_t before = 0;
        for (const std::int64_t offset : cellOffsets_) {
            if (offset < before || offset > static_cast<std::int64_t>(size))
                text().fail(concat("OFFSETS has ", offset, " after ", before, "; CONNECTIVITY has ",
                                   size, " numbers"));
            before = offset;
        }
    }

    void readCellTypes() {
        const std::size_t count = text().count("the number of cell types", 1);
        types_ = data_.numbers<std::int64_t>("int", count, "a cell type");
    }

    void beginData(Owner owner, std::size_t expected, const char* what) {
        owner_ = owner;
        tupleCount_ = text().number<std::uint64_t>(what);
        if (tupleCount_ != expected)
            text().fail(
                concat("the data are for ", tupleCount_, " ", what, ", but there are ", expected));
    }

    void readAttribute(const std::string& keyword) {
        if (keyword == "scalars") {
            const std::string name = data_.name();
            const std::string type = data_.keyword("the type of SCALARS");
            const std::size_t components = optionalCount(1);
            data_.expect("LOOKUP_TABLE");
            text().token("the name of a lookup table");
            readArray(name, type, components, tupleCount_);
        } else if (keyword == "color_scalars") {
            data_.name();
            data_.skipColours(
                saturatingProduct(text().count("the number of values", 1), tupleCount_));
        } else if (keyword == "lookup_table") {
            data_.name();
            data_.skipColours(saturatingProduct(text().count("the number of colours", 1), 4));
        } else if (keyword == "texture_coordinates") {
            const std::string name = data_.name();
            const std::size_t components = text().count("the number of coordinates", 1);
            readArray(name, data_.keyword("a type"), components, tupleCount_);
        } else if (keyword == "global_ids" || keyword == "pedigree_ids" ||
                   keyword == "edge_flags") {
            data_.name();
            data_.values(data_.keyword("a type"), tupleCount_, "an id");
        } else {
            const std::size_t components = componentsOf(keyword);
            const std::string name = data_.name();
            readArray(name, data_.keyword("a type"), components, tupleCount_);
        }
    }

    std::size_t componentsOf(const std::string& keyword) {
        if (keyword == "vectors" || keyword == "normals") return 3;
        if (keyword == "tensors6") return 6;
        if (keyword == "tensors") return 9;
        failAt(keyword);
    }

    /// Reads a number from the rest of the line; returns `otherwise` if the line is empty.
    std::size_t optionalCount(std::size_t otherwise) {
        std::string_view rest = text().restOfLine();
        const std::string_view word = takeWord(rest);
        std::size_t count = otherwise;
        if (!word.empty() && (!parseNumber(word, count) || count == 0))
            text().fail(inQuotes(word) + " is not a number of components");
        return count;
    }

    void readField() {
        text().token("the name of a field");
        const std::size_t count = text().count("the number of arrays", 1);
        for (std::size_t i = 0; i < count; ++i) {
            std::string name = data_.name();
            while (name == "METADATA") {
                data_.skipMetadata();
                name = data_.name();
            }
            if (name == "NULL_ARRAY") continue;
            const std::size_t components = text().count("the number of components", 1);
            const std::size_t tuples = text().number<std::uint64_t>("the number of tuples");
            readArray(name, data_.keyword("a type"), components, tuples);
        }
    }

    /// Reads an array, and keeps it if it is an attribute or holds marks.
    void readArray(const std::string& name, const std::string& type, std::size_t components,
                   std::size_t tuples) {
        const std::size_t line = text().line();
        const std::optional<NumberType> number = numberOfLegacyName(type);
        if (owner_ == Owner::Points && number && isInteger(*number) && name != kVertexSharpness) {
            auto integers = data_.numbers<std::int64_t>(type, saturatingProduct(components, tuples),
                                                        "an integer");
            checkTuples(line, name, components, tuples);
            if (name != kVtkGhosts)
                lattice_.integers.push_back({name, checkedIndex(path_, components, "components"),
                                             integerTypeOf(*number), std::move(integers)});
            return;
        }
        auto values = data_.values(type, saturatingProduct(components, tuples), "a number");
        if (!values) return;
        if (owner_ == Owner::DataSet) {
            if (name == kEdgeVertices && components == 2)
                edgeVertices_ = std::move(*values);
            else if (name == kEdgeSharpness && components == 1)
                edgeSharpness_ = std::move(*values);
        } else if (owner_ == Owner::Points) {
            checkTuples(line, name, components, tuples);
            if (name == kVertexSharpness && components == 1)
                vertexSharpness_ = std::move(*values);
            else
                lattice_.attributes.push_back(
                    {name, checkedIndex(path_, components, "components"), std::move(*values)});
        }
    }

    void checkTuples(std::size_t line, const std::string& name, std::size_t components,
                     std::size_t tuples) {
        if (tuples != lattice_.positions.size() || components == 0)
            throw FileError(path_, line,
                            concat("the array ", inQuotes(name), " has ", tuples, " tuples of ",
                                   components, " for ", lattice_.positions.size(), " points"));
    }

    void addCells(VtkCellReader& cells) {
        const std::size_t count = cellOffsets_.empty() ? 0 : cellOffsets_.size() - 1;
        if (types_.size() != count)
            throw FileError(path_,
                            concat("has ", count, " cells and ", types_.size(), " cell types"));
        for (std::size_t cell = 0; cell < count; ++cell) {
            const std::size_t begin = cellOffsets_[cell];
            const std::size_t end = cellOffsets_[cell + 1];
            const auto row = std::span(std::as_const(connectivity_)).subspan(begin, end - begin);
            if (types_[cell] == kVtkPolyhedron)
                cells.addPolyhedron(row);
            else
                cells.add(types_[cell], row);
        }
    }

    void addEdgeMarks() {
        if (edgeVertices_.size() != 2 * edgeSharpness_.size())
            throw FileError(path_, concat("has marks of ", edgeSharpness_.size(), " edges, and ",
                                          edgeVertices_.size(), " vertices of marked edges"));
        const auto markedVertex = [&](double vertex) {
            if (!(vertex >= 0 && vertex < static_cast<double>(lattice_.positions.size())))
                throw FileError(path_, concat("a mark names vertex ", formatNumber(vertex),
                                              "; there are ", lattice_.positions.size()));
            return static_cast<Index>(vertex);
        };
        for (std::size_t mark = 0; mark < edgeSharpness_.size(); ++mark)
            if (isMarkInFile(path_, kEdgeSharpness, mark, edgeSharpness_[mark]))
                lattice_.marks.edges.push_back({{markedVertex(edgeVertices_[2 * mark]),
                                                 markedVertex(edgeVertices_[2 * mark + 1])},
                                                sharpnessFromFile(edgeSharpness_[mark])});
    }

    [[noreturn]] void failAt(const std::string& keyword) {
        text().fail(inQuotes(keyword) + " is not a keyword that can stand here");
    }

    std::filesystem::path path_;
    LegacyData data_;
    int version_ = 0;
    Owner owner_ = Owner::DataSet;
    std::size_t tupleCount_ = 0;

    std::vector<std::int64_t> cellOffsets_;  ///< cell c begins in connectivity_ at cellOffsets_[c]
    std::vector<std::int64_t> connectivity_;
    std::vector<std::int64_t> types_;
    std::vector<double> vertexSharpness_;
    std::vector<double> edgeVertices_;
    std::vector<double> edgeSharpness_;
    Lattice lattice_;  ///< the lattice without its complex
};

}  // namespace

Lattice readVtkLegacy(const std::filesystem::path& path, std::string_view bytes, ReadNotes* notes) {
    return LegacyReader(path, bytes).read(notes);
}

}  // namespace espalier::io

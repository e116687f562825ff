// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "../files/number_types.h"
#include "vtk_payload.h"

// Reads VTK's XML files: finds their arrays, and decodes the numbers in them.
//
//     VTKFile > UnstructuredGrid > FieldData > DataArray ...
//                                  Piece ... > PointData, CellData, Points, Cells > DataArray ...
//     VTKFile > AppendedData       "_" and then the arrays of format "appended"

namespace espalier::io {

/// One DataArray (or Array) element.
struct VtkDataArray {
    enum class Format { Ascii, Binary, Appended };

    std::string name;
    std::optional<NumberType> type;  ///< none for "String" and "Bit", which cannot be read
    std::size_t components = 1;      ///< numbers per tuple, at least 1
    Format format = Format::Ascii;
    std::size_t offset = 0;  ///< offset of an appended array in the appended data
    std::size_t line = 1;    ///< line on which the element begins

    // Offsets in the bytes of the file.
    std::size_t begin = 0;         ///< the "<" of the element
    std::size_t end = 0;           ///< one past the ">" at its end
    std::size_t contentBegin = 0;  ///< begin of the numbers of an inline array
    std::size_t contentEnd = 0;
};

/// The arrays of PointData, CellData, Points or Cells.
struct VtkSection {
    std::size_t line = 1;
    std::vector<VtkDataArray> arrays;
    /// Names of the active arrays of PointData and CellData, by "Normals", "Scalars" and so on.
    std::map<std::string, std::string> active;

    /// Returns the array of this name, or null if there is none.
    const VtkDataArray* find(std::string_view name) const;
};

struct VtkPiece {
    std::size_t line = 1;
    std::map<std::string, std::size_t> counts;   ///< counts by attribute, such as "NumberOfPoints"
    std::map<std::string, VtkSection> sections;  ///< sections by the names of elements
};

/// A serial VTK XML file. Numbers are decoded when they are requested. Claimed sizes are compared
/// with the size of the file before memory is allocated for them.
class VtkXmlFile {
public:
    /// \param path for messages
    /// \param bytes the whole file
    /// \param dataSet the type of data set that is expected: "UnstructuredGrid"
    /// \throws FileError if the file is cut short, is not XML or of another type, with the line
    static VtkXmlFile read(const std::filesystem::path& path, std::string bytes,
                           const std::string& dataSet);

    const std::filesystem::path& path() const { return path_; }

    /// Returns the bytes of the whole file.
    std::string_view bytes() const { return bytes_; }

    /// Returns the encoding that all arrays of this file have.
    const VtkCoding& coding() const { return coding_; }

    const VtkSection& fieldData() const { return fieldData_; }
    const std::vector<VtkPiece>& pieces() const { return pieces_; }

    /// Returns a count of a piece.
    /// \throws FileError if the piece has no such attribute
    std::size_t count(const VtkPiece& piece, const std::string& name) const;

    /// Returns a section of a piece.
    /// \throws FileError if the piece has none of this name
    const VtkSection& section(const VtkPiece& piece, const std::string& name) const;

    /// Returns an array of a section.
    /// \throws FileError if the section has none of this name
    const VtkDataArray& array(const VtkSection& section, const std::string& name) const;

    /// Decodes all numbers of an array. The caller gives the expected number of tuples, so that a
    /// small file that claims a large array is refused before the array is decoded.
    ///
    /// \param reason why this number is expected, for the message: "one a cell"
    /// \throws FileError if the numbers cannot be decoded or have the wrong kind, or if the number
    ///         of tuples differs
    std::vector<double> reals(const VtkDataArray& array, std::size_t tuples,
                              std::string_view reason = {}) const;
    std::vector<std::int64_t> integers(const VtkDataArray& array, std::size_t tuples,
                                       std::string_view reason = {}) const;

    /// The same for a list of `count` numbers, whatever number of components its array claims.
    std::vector<std::int64_t> list(const VtkDataArray& array, std::size_t count,
                                   std::string_view reason) const;

    /// The same for an array of at most `maxTuples` tuples.
    std::vector<std::int64_t> integersUpTo(const VtkDataArray& array, std::size_t maxTuples,
                                           std::string_view reason) const;

    [[noreturn]] void fail(std::size_t line, const std::string& cause) const;

private:
    friend class VtkXmlParser;

    VtkXmlFile() = default;

    /// The size that an array must have, and the reason for it.
    struct Expected {
        std::size_t minTuples;
        std::size_t maxTuples;
        std::size_t components;
        std::string_view reason;
    };

    template <class Value>
    std::vector<Value> values(const VtkDataArray& array, const Expected& expected) const;
    template <class Value>
    std::vector<Value> inlineText(const VtkDataArray& array) const;
    std::string payload(const VtkDataArray& array, const Expected& expected) const;
    bool isWholePayload(std::string_view text, std::size_t size) const;
    void checkCount(const VtkDataArray& array, std::size_t got, const Expected& expected) const;
    std::string nameOf(const VtkDataArray& array) const;
    [[noreturn]] void failIn(const VtkDataArray& array, const std::string& cause) const;

    std::filesystem::path path_;
    std::string bytes_;
    VtkCoding coding_;
    std::string unknownCompressor_;  ///< if not empty, only ascii arrays can be read
    VtkSection fieldData_;
    std::vector<VtkPiece> pieces_;
    PayloadForm appendedForm_ = PayloadForm::Raw;
    std::size_t appendedBegin_ =
        0;  ///< place after the "_"; 0, like the end, without appended data
    std::size_t appendedEnd_ = 0;
};

/// The reason why a number of rows is expected, for messages.
inline constexpr std::string_view kOneACell = "one a cell";

/// Reads an array of rows and the array of offsets at which the rows end. The offsets are read
/// first, because they determine the number of values.
class VtkRows {
public:
    /// \param values, offsets names of the arrays
    /// \param count number of rows
    /// \param reason why this number is expected (VtkXmlFile::list())
    /// \throws FileError if the number of offsets or values differs, or the offsets descend
    VtkRows(const VtkXmlFile& file, const VtkSection& section, const char* values,
            const char* offsets, std::size_t count, std::string_view reason);

    std::span<const std::int64_t> operator[](std::size_t row) const {
        const std::size_t begin = row == 0 ? 0 : ends_[row - 1];
        return std::span(values_).subspan(begin, ends_[row] - begin);
    }

private:
    std::vector<std::int64_t> values_;
    std::vector<std::int64_t> ends_;
};

/// The encoding of an inline array.
enum class VtkArrayForm { Ascii, Base64 };

/// The attributes of a DataArray element.
struct VtkArrayHead {
    std::string name;
    NumberType type = NumberType::Float64;
    std::size_t components = 1;
    bool hasTupleCount = false;  ///< required for arrays of FieldData
};

/// Returns a DataArray element with its numbers, from "<DataArray" to "</DataArray>".
///
/// \tparam Value double for real types, std::int64_t for integers, within the range of the type
/// \param indent text before each line but the first
/// \param coding encoding of the file that will contain the element
/// \throws CodingError if the array is too large for the file's header_type
template <class Value>
std::string dataArrayElement(const VtkArrayHead& head, std::span<const Value> values,
                             VtkArrayForm form, const VtkCoding& coding, std::string_view indent);

/// Returns true if XML 1.0 can hold a text (section 2.2): UTF-8 without control characters other
/// than tabs and line ends, and without U+FFFE and U+FFFF.
bool isXmlText(std::string_view text);

/// Returns a text as the value of an XML attribute.
/// \param text a text that isXmlText() accepts
std::string xmlEscaped(std::string_view text);

/// Returns points from their coordinates, x y z x y z ...
std::vector<Point3> pointsOf(std::span<const double> coordinates);

/// Returns the coordinates of points, x y z x y z ...
std::vector<double> coordinatesOf(std::span<const Point3> points);

/// \throws FileError naming the first point that is not finite
void checkFinite(const std::filesystem::path& path, std::span<const Point3> points);

/// Returns the array that holds the points of a piece.
/// \throws FileError if Points is missing, or holds anything but one array of 3 components
const VtkDataArray& pointArray(const VtkXmlFile& file, const VtkPiece& piece);

/// Returns the points of a piece, as many as the piece claims. A piece of 0 points needs no array.
/// \throws FileError as pointArray() and VtkXmlFile::reals()
std::vector<Point3> readPoints(const VtkXmlFile& file, const VtkPiece& piece);

}  // namespace espalier::io

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

// VTK's XML files: what arrays there are, where they are, and the numbers in them.
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
    std::size_t components = 1;      ///< numbers a tuple, at least 1
    Format format = Format::Ascii;
    std::size_t offset = 0;  ///< of an appended array, in the appended data
    std::size_t line = 1;    ///< where the element begins

    // Places among the bytes of the file.
    std::size_t begin = 0;         ///< of the element, "<"
    std::size_t end = 0;           ///< one past its end, ">"
    std::size_t contentBegin = 0;  ///< of the numbers of an inline array
    std::size_t contentEnd = 0;
};

/// The arrays of PointData, CellData, Points or Cells.
struct VtkSection {
    std::size_t line = 1;
    std::vector<VtkDataArray> arrays;
    /// Which arrays are the active ones: of PointData and CellData, names by "Normals" and its
    /// like.
    std::map<std::string, std::string> active;

    /// \return null if there is none of this name
    const VtkDataArray* find(std::string_view name) const;
};

struct VtkPiece {
    std::size_t line = 1;
    std::map<std::string, std::size_t> counts;   ///< "NumberOfPoints" and its like
    std::map<std::string, VtkSection> sections;  ///< by element name
};

/// A serial VTK XML file. Its numbers are decoded when they are asked for, and sizes that it claims
/// are compared with what is there before memory is taken for them.
class VtkXmlFile {
public:
    /// \param path for messages
    /// \param bytes the whole file
    /// \param dataSet the type of data set that is expected: "UnstructuredGrid"
    /// \throws FileError if the file is cut short, is not XML or of another type, with the line
    static VtkXmlFile read(const std::filesystem::path& path, std::string bytes,
                           const std::string& dataSet);

    const std::filesystem::path& path() const { return path_; }

    /// The whole file.
    std::string_view bytes() const { return bytes_; }

    /// How to code an array so that it can stand in this file.
    const VtkCoding& coding() const { return coding_; }

    const VtkSection& fieldData() const { return fieldData_; }
    const std::vector<VtkPiece>& pieces() const { return pieces_; }

    /// A count of a piece. \throws FileError if the piece has no such attribute
    std::size_t count(const VtkPiece& piece, const std::string& name) const;

    /// A section of a piece. \throws FileError if the piece has none of this name
    const VtkSection& section(const VtkPiece& piece, const std::string& name) const;

    /// An array of a section. \throws FileError if it has none of this name
    const VtkDataArray& array(const VtkSection& section, const std::string& name) const;

    /// All numbers of an array. The caller says how many tuples there must be, so that a small file
    /// that claims a large array is refused before the array is decoded.
    ///
    /// \param reason says in the message why this number is expected: "one a cell"
    /// \throws FileError if the numbers cannot be decoded or are not of this kind, or if there is
    ///         another number of tuples
    std::vector<double> reals(const VtkDataArray& array, std::size_t tuples,
                              std::string_view reason = {}) const;
    std::vector<std::int64_t> integers(const VtkDataArray& array, std::size_t tuples,
                                       std::string_view reason = {}) const;

    /// The same of a list of `count` numbers. The components that its array claims do not count.
    std::vector<std::int64_t> list(const VtkDataArray& array, std::size_t count,
                                   std::string_view reason) const;

    /// The same of an array of at most `mostTuples`.
    std::vector<std::int64_t> integersUpTo(const VtkDataArray& array, std::size_t mostTuples,
                                           std::string_view reason) const;

    [[noreturn]] void fail(std::size_t line, const std::string& cause) const;

private:
    friend class VtkXmlParser;

    VtkXmlFile() = default;

    /// How many tuples of this number of components an array must have, and why.
    struct Expected {
        std::size_t leastTuples;
        std::size_t mostTuples;
        std::size_t components;
        std::string_view reason;
    };

    template <class Value>
    std::vector<Value> values(const VtkDataArray& array, const Expected& expected) const;
    template <class Value>
    std::vector<Value> inlineText(const VtkDataArray& array) const;
    std::string payload(const VtkDataArray& array, const Expected& expected) const;
    void checkCount(const VtkDataArray& array, std::size_t got, const Expected& expected) const;
    std::string nameOf(const VtkDataArray& array) const;
    [[noreturn]] void failIn(const VtkDataArray& array, const std::string& cause) const;

    std::filesystem::path path_;
    std::string bytes_;
    VtkCoding coding_;
    std::string unknownCompressor_;  ///< not empty: only ascii arrays can be read
    VtkSection fieldData_;
    std::vector<VtkPiece> pieces_;
    PayloadForm appendedForm_ = PayloadForm::Raw;
    std::size_t appendedBegin_ = 0;  ///< after the "_"; no appended data if both are 0
    std::size_t appendedEnd_ = 0;
};

/// How an inline array is written.
enum class VtkArrayForm { Ascii, Base64 };

/// The attributes of a DataArray element.
struct VtkArrayHead {
    std::string name;
    NumberType type = NumberType::Float64;
    std::size_t components = 1;
    bool hasTupleCount = false;  ///< as arrays of FieldData need it
};

/// A DataArray element with its numbers in it, from "<DataArray" to "</DataArray>".
///
/// \tparam Value double for real types, std::int64_t for integers, within the range of the type
/// \param indent is put before each line but the first
/// \param coding of the file that the element is for
/// \throws CodingError if the array is too large for the file's header_type
template <class Value>
std::string dataArrayElement(const VtkArrayHead& head, std::span<const Value> values,
                             VtkArrayForm form, const VtkCoding& coding, std::string_view indent);

/// Whether XML 1.0 can hold a text (section 2.2): UTF-8 without control characters, but for tabs
/// and line ends, and without U+FFFE and U+FFFF.
bool isXmlText(std::string_view text);

/// A text as the value of an XML attribute. \param text such as isXmlText() accepts
std::string xmlEscaped(std::string_view text);

/// Points from their coordinates, x y z x y z ...
std::vector<Point3> pointsOf(std::span<const double> coordinates);

/// The coordinates of points, x y z x y z ...
std::vector<double> coordinatesOf(std::span<const Point3> points);

/// \throws FileError naming the first point that is not finite
void checkFinite(const std::filesystem::path& path, std::span<const Point3> points);

/// The array that holds the points of a piece.
/// \throws FileError if Points is missing, or holds anything but one array of 3 components
const VtkDataArray& pointArray(const VtkXmlFile& file, const VtkPiece& piece);

/// The points of a piece, as many as it claims; none if that is 0.
/// \throws FileError as pointArray() and VtkXmlFile::reals()
std::vector<Point3> readPoints(const VtkXmlFile& file, const VtkPiece& piece);

}  // namespace espalier::io

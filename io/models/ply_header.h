// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../files/number_types.h"
#include "coordinates.h"
#include "odd_lines.h"
#include "splats.h"

#include <array>
#include <bit>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace espalier::io {

enum class PlyFormat { Ascii, BinaryLittleEndian, BinaryBigEndian };

/// A column of an element: one number, or a list of numbers that begins with its length.
struct PlyProperty {
    std::string name;
    NumberType type = NumberType::Float32;
    std::optional<NumberType> lengthType;  ///< integer type of the length, if this is a list
};

/// An element of a PLY file: a table with `count` rows and a column for each property.
struct PlyElement {
    std::string name;
    std::size_t count = 0;
    std::vector<PlyProperty> properties;

    /// Returns the size of a row in bytes in the binary formats, if its lists are empty.
    std::size_t smallestRow() const;
    bool hasLists() const;
};

/// Three properties of the vertices that form a direction.
struct PlyDirection {
    std::array<std::size_t, 3> columns;  ///< numbers of the properties
    Carry carry;
};

/// The properties of the vertices that make Gaussian splats of them.
struct PlySplats {
    std::vector<std::size_t> columns;  ///< numbers of the properties, as in splats.h; may be empty
    std::size_t keptHarmonics = 0;
};

/// The header of a PLY file. The file may have fewer rows than the header claims.
struct PlyHeader {
    PlyFormat format = PlyFormat::Ascii;
    std::vector<PlyElement> elements;
    std::size_t vertexElement = 0;         ///< number of the element that has the points
    std::array<std::size_t, 3> axes = {};  ///< numbers of its properties x, y and z
    std::vector<PlyDirection> directions;
    PlySplats splats;
    std::size_t size = 0;  ///< bytes of the header
    std::size_t lineCount = 0;
    OddLines oddLines = {};  ///< the lines that are not understood

    const PlyElement& vertices() const { return elements[vertexElement]; }

    /// Returns the precisions of three properties of the vertices. The properties must be real
    /// numbers.
    std::array<Precision, 3> precisions(const std::array<std::size_t, 3>& columns) const;

    /// Returns the splats without their rows.
    FileSplats fileSplats() const;

    /// Returns the byte order of a binary format.
    std::endian byteOrder() const;
};

/// Reads the header at the beginning of `bytes`.
///
/// \param path for messages
/// Lines that begin with another word than those of the format are counted and not read.
/// \throws FileError with the line, if the header is malformed, or does not have exactly one
///         element `vertex` with properties x, y and z of type float or double
PlyHeader parsePlyHeader(const std::filesystem::path& path, std::string_view bytes);

}  // namespace espalier::io

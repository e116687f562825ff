// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../files/number_types.h"
#include "coordinates.h"

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
    std::optional<NumberType> lengthType;  ///< of a list: an integer type
};

/// A table: `count` rows of the properties.
struct PlyElement {
    std::string name;
    std::size_t count = 0;
    std::vector<PlyProperty> properties;

    /// Bytes of a row in the binary formats, when its lists are empty.
    std::size_t smallestRow() const;
    bool hasLists() const;
};

/// Properties of the vertices that together are a direction.
struct PlyDirection {
    std::array<std::size_t, 3> columns;  ///< which properties
    Carry carry;
};

/// What the rows of a PLY file hold, as its header says; the file may hold less.
struct PlyHeader {
    PlyFormat format = PlyFormat::Ascii;
    std::vector<PlyElement> elements;
    std::size_t vertexElement = 0;         ///< which element has the points
    std::array<std::size_t, 3> axes = {};  ///< which of its properties are x, y and z
    std::vector<PlyDirection> directions;
    std::size_t size = 0;  ///< bytes of the header
    std::size_t lineCount = 0;

    const PlyElement& vertices() const { return elements[vertexElement]; }

    /// How properties of the vertices, of real types, are held.
    std::array<Precision, 3> precisions(const std::array<std::size_t, 3>& columns) const;

    /// Of the binary formats.
    std::endian byteOrder() const;
};

/// Reads the header at the begin of `bytes`.
///
/// \param path for messages
/// \throws FileError with the line, if it is malformed, or if it has not one element `vertex` with
/// properties x, y and z of type float or double
PlyHeader parsePlyHeader(const std::filesystem::path& path, std::string_view bytes);

}  // namespace espalier::io

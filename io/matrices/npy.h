// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/array.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "../files/bytes.h"

namespace espalier::io {

/// The first bytes of every .npy file.
inline constexpr std::string_view kNpyMagic = "\x93NUMPY";

/// Writes the head of a .npy file, NumPy's format for an array (version 1.0), little-endian. The
/// numbers must follow, in C order.
/// \param type NumPy's name of the type: "<f8", "<i4", "|S3" ...
/// \param length length of an array of one axis; nothing for a single item
void writeNpyHead(ByteOutput& out, std::string_view type, std::optional<std::uint64_t> length);

/// NumPy's names of our number types.
template <class Number>
inline constexpr std::string_view kNpyType = {};
template <>
inline constexpr std::string_view kNpyType<float> = "<f4";
template <>
inline constexpr std::string_view kNpyType<double> = "<f8";
template <>
inline constexpr std::string_view kNpyType<std::int32_t> = "<i4";
template <>
inline constexpr std::string_view kNpyType<std::int64_t> = "<i8";

/// Writes numbers as an array of one axis, of type Stored, which must hold them exactly.
template <class Stored, class Number>
void writeNpy(ByteOutput& out, std::span<const Number> numbers) {
    writeNpyHead(out, kNpyType<Stored>, numbers.size());
    out.numbersAs<Stored>(numbers);
}

/// The type of the items in a NumPy array.
struct NpyType {
    std::string name;  ///< NumPy's name: "<f8", "|S3" ...
    char kind = ' ';   ///< 'f' real, 'i' and 'u' integer, 'S' bytes, 'U' Unicode ...
    std::size_t size = 0;
    std::endian order = std::endian::native;
};

/// The array in a .npy file.
struct NpyArray {
    NpyType type;
    std::vector<std::uint64_t> shape;  ///< lengths of the axes; none for a single item
    bool isFortranOrder = false;       ///< whether the first index counts fastest
    std::string_view bytes;            ///< the items, in the bytes of the file
};

/// Reads a .npy file of version 1 to 3 with a single item or an array.
///
/// \param file bytes of the file; must outlive the array
/// \throws CodingError if the file is malformed, or has not the size that its head says
NpyArray readNpy(std::string_view file);

/// Returns the numbers of an array of one axis.
///
/// \tparam Number Index or Offset, for integers of any size; double, for integers and for reals of
/// 4 or 8 bytes
/// \throws CodingError if the array has another type, other axes, or a number that a Number cannot
///         hold exactly
template <class Number>
Array<Number> npyNumbers(const NpyArray& array);

/// Returns the numbers of an array of two axes, row by row.
/// \throws CodingError if the array has another type or other axes
Array<double> npyMatrix(const NpyArray& array);

/// Returns a shape as Python writes it: "(27, 3)".
std::string shapeText(std::span<const std::uint64_t> shape);

/// Returns the text of a single item of bytes or Unicode.
/// \throws CodingError if the array has another type, or is not ASCII
std::string npyText(const NpyArray& array);

}  // namespace espalier::io

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

#include "../files/bytes.h"

namespace espalier::io {

/// What a .npy file begins with.
inline constexpr std::string_view kNpyMagic = "\x93NUMPY";

/// Writes the head of a .npy file, NumPy's format for an array (version 1.0), little-endian; the
/// numbers follow, in C order.
/// \param type as NumPy names it: "<f8", "<i4", "|S3" ...
/// \param length of an array of one axis; nothing for a single item
void writeNpyHead(ByteOutput& out, std::string_view type, std::optional<std::uint64_t> length);

/// NumPy's names of the types of ours.
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

/// Writes an array of one axis, with numbers of another type that holds them.
template <class Stored, class Number>
void writeNpy(ByteOutput& out, std::span<const Number> numbers) {
    writeNpyHead(out, kNpyType<Stored>, numbers.size());
    out.numbersAs<Stored>(numbers);
}

/// What an array of NumPy is made of.
struct NpyType {
    std::string name;  ///< as NumPy names it: "<f8", "|S3" ...
    char kind = ' ';   ///< 'f' real, 'i' and 'u' integer, 'S' bytes, 'U' Unicode ...
    std::size_t size = 0;
    std::endian order = std::endian::native;
};

/// A .npy file.
struct NpyArray {
    NpyType type;
    std::optional<std::uint64_t> length;  ///< of one axis; nothing for a single item
    std::string_view bytes;               ///< of the items, in the file
};

/// Reads a .npy file of version 1 to 3, of a single item or an array of one axis (for which
/// fortran_order makes no difference).
///
/// \param file must outlive the array
/// \throws CodingError if it is malformed, if it has more axes, or if its size is not what its head
///         says
NpyArray readNpy(std::string_view file);

/// The numbers of an array of one axis.
///
/// \tparam Number Index or Offset, of integers of any size; double, of reals of 4 or 8
///         bytes and integers
/// \throws CodingError if it is of another type, or of a number that a Number cannot be exactly
template <class Number>
Array<Number> npyNumbers(const NpyArray& array);

/// The text of a single item of bytes or Unicode.
/// \throws CodingError if it is of another type, or not in ASCII
std::string npyText(const NpyArray& array);

}  // namespace espalier::io

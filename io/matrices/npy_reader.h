// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/array.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace espalier::io {

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

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../files/byte_output.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>

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

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "../files/number_types.h"

// Encodes and decodes the bytes of an array in VTK's XML files: a header of 32- or 64-bit words,
// then the bytes.
//
//     without compression   [number of bytes]  bytes
//     with compression      [n blocks] [bytes of a block] [bytes of the last one, 0 if whole]
//                           [compressed bytes of block 0] ... [of block n − 1]  blocks
//
// Both may be in base64. Then the header of compressed data is a separate, padded base64 stream;
// uncompressed data is one stream with its header.

namespace espalier::io {

/// The encoding that all arrays of a file share.
struct VtkCoding {
    std::endian byteOrder = std::endian::little;
    bool has64BitHeader = true;  ///< header_type UInt64, else UInt32
    bool isCompressed = true;    ///< true if zlib compresses the arrays
};

enum class PayloadForm { Raw, Base64 };

/// Returns the number of bytes that the header of an array claims. Only the header is decoded.
/// \throws CodingError if the header is malformed
std::uint64_t claimedSize(std::string_view text, PayloadForm form, const VtkCoding& coding);

/// Returns the bytes of one array.
///
/// \param text begins with the array, and may go on beyond it
/// \throws CodingError if the array is malformed, or claims more bytes than `text` can hold
/// \cost at most the memory that zlib can inflate from `text`
std::string decodePayload(std::string_view text, PayloadForm form, const VtkCoding& coding);

/// Returns `size` bytes of one array that is not compressed, whatever its header claims.
/// \throws CodingError if the array is malformed, or `text` has fewer bytes
std::string decodePayloadOfSize(std::string_view text, std::uint64_t size, PayloadForm form,
                                const VtkCoding& coding);

/// Appends the numbers of one array in base64 to a text: decodePayload() returns the bytes of
/// encodeNumbers(). Compresses blocks in parallel.
/// \tparam Value double, std::int64_t, Index or std::uint8_t
/// \throws CodingError if there are too many bytes for a 32-bit header
template <class Value>
void appendPayload(std::string& text, std::span<const Value> values, NumberType type,
                   const VtkCoding& coding);

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <string_view>

// How VTK's XML files code the bytes of an array: a header of 32- or 64-bit words, then the bytes.
//
//     without compression   [number of bytes]  bytes
//     with compression      [n blocks] [bytes of a block] [bytes of the last one, 0 if whole]
//                           [compressed bytes of block 0] ... [of block n − 1]  blocks
//
// Both may be in base64. There the header of compressed data is a stream of its own, padded; that
// of other data is not.

namespace espalier::io {

/// The choices that a file makes once, for all its arrays.
struct VtkCoding {
    std::endian byteOrder = std::endian::little;
    bool has64BitHeader = true;  ///< header_type UInt64, else UInt32
    bool isCompressed = true;    ///< with zlib
};

enum class PayloadForm { Raw, Base64 };

/// The number of bytes that the header of one array claims. Nothing behind the header is decoded.
/// \throws CodingError if the header is malformed
std::uint64_t claimedSize(std::string_view text, PayloadForm form, const VtkCoding& coding);

/// The bytes of one array.
///
/// \param text begins with the array, and may go on beyond it
/// \throws CodingError if the array is malformed, or claims more than there is
/// \cost takes no more memory than zlib can make of `text`
std::string decodePayload(std::string_view text, PayloadForm form, const VtkCoding& coding);

/// The bytes of one array in base64, as decodePayload() takes them.
/// \throws CodingError if they are too many for a 32-bit header
std::string encodePayload(std::string_view bytes, const VtkCoding& coding);

}  // namespace espalier::io

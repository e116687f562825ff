// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/files/text_reader.h>
#include <espalier/shapes/lattice.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// The number types of file formats, by VTK's names. Whatever a lattice file holds, its numbers are
// read as one of two types: double, or std::int64_t for what counts or names something.

namespace espalier::io {

enum class NumberType {
    Int8,
    UInt8,
    Int16,
    UInt16,
    Int32,
    UInt32,
    Int64,
    UInt64,
    Float32,
    Float64
};

/// Calls f(zero), with a zero of the C++ type that is stored.
template <class F>
auto visitStored(NumberType type, F f) {
    switch (type) {
        case NumberType::Int8:
            return f(std::int8_t{});
        case NumberType::UInt8:
            return f(std::uint8_t{});
        case NumberType::Int16:
            return f(std::int16_t{});
        case NumberType::UInt16:
            return f(std::uint16_t{});
        case NumberType::Int32:
            return f(std::int32_t{});
        case NumberType::UInt32:
            return f(std::uint32_t{});
        case NumberType::Int64:
            return f(std::int64_t{});
        case NumberType::UInt64:
            return f(std::uint64_t{});
        case NumberType::Float32:
            return f(float{});
        case NumberType::Float64:
            break;
    }
    return f(double{});
}

/// Bytes that one number takes in binary data.
std::size_t byteSize(NumberType type);

bool isInteger(NumberType type);

/// The name in XML files: "Float64".
const char* xmlName(NumberType type);

/// \return nothing for a name that is not of a number ("String", "Bit")
std::optional<NumberType> numberOfXmlName(std::string_view name);

/// \param name in lower case, as in legacy files: "unsigned_char", "vtkidtype" (which is 32 bits
///        wide there)
/// \return nothing for a name that is not of a number ("bit", "string")
std::optional<NumberType> numberOfLegacyName(std::string_view name);

/// The name in legacy files: "vtktypeint64".
const char* legacyName(NumberType type);

/// The number type of integers on vertices, and the inverse, for types of integers.
NumberType numberOf(IntegerType type);
IntegerType integerTypeOf(NumberType type);

/// Whether a type of integers can hold a value; UInt64 holds the bits of any.
bool canHold(NumberType type, std::int64_t value);

/// One integer in binary data. \param type one of integers; an UInt64 beyond the result comes out
/// negative
std::int64_t loadInteger(const char* bytes, NumberType type, std::endian order);

/// The numbers in binary data. Real numbers can only be read as double.
///
/// \tparam Value double or std::int64_t; an UInt64 beyond the latter comes out negative
/// \param bytes a whole number of numbers
template <class Value>
std::vector<Value> decodeNumbers(std::string_view bytes, NumberType type, std::endian order);

/// The inverse of decodeNumbers, for values that the type can hold; doubles are rounded to Float32.
template <class Value>
std::string encodeNumbers(std::span<const Value> values, NumberType type, std::endian order);

/// The next token of a text as a number of this type; Float32 is rounded as VTK would.
/// \tparam Value as in decodeNumbers(); an UInt64 too large for std::int64_t comes out negative
/// \throws FileError also if an integer is out of the range of its type
template <class Value>
Value readNumber(TextReader& text, NumberType type, const char* what);

/// a · b, or the largest number if that is more: for sizes that a file claims.
std::size_t saturatingProduct(std::size_t a, std::size_t b);

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/files/text_reader.h>
#include <espalier/shapes/lattice.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

// The number types of file formats, by VTK's names. Readers of lattices convert all numbers to one
// of two types: std::int64_t for counts and indices, double for everything else.

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

/// Calls f(zero), with a zero of the C++ type that the file stores.
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

/// Returns the size of a number in binary data, in bytes.
std::size_t byteSize(NumberType type);

bool isInteger(NumberType type);

/// Returns the name of a type in XML files: "Float64".
const char* xmlName(NumberType type);

/// Returns the type of this name in XML files; nothing if it is not a number ("String", "Bit").
std::optional<NumberType> numberOfXmlName(std::string_view name);

/// Returns the type of this name in legacy files; nothing if it is not a number ("bit", "string").
/// \param name in lower case: "unsigned_char", "vtkidtype" (which has 32 bits there)
std::optional<NumberType> numberOfLegacyName(std::string_view name);

/// Returns the name of a type in legacy files: "vtktypeint64".
const char* legacyName(NumberType type);

/// Converts between the types of Lattice::integers and number types.
NumberType numberOf(IntegerType type);
/// \param type an integer type
IntegerType integerTypeOf(NumberType type);

/// Returns true if an integer type can hold a value. UInt64 can hold all, since it stores their
/// bits.
bool canHold(NumberType type, std::int64_t value);

/// Reads one integer from binary data. A UInt64 that is too large for the result becomes negative.
/// \param type an integer type
std::int64_t loadInteger(const char* bytes, NumberType type, std::endian order);

/// Reads all numbers of binary data. Real numbers can only be read as double.
///
/// \tparam Value double or std::int64_t; a UInt64 that is too large for std::int64_t becomes
/// negative
/// \param bytes a whole number of numbers
template <class Value>
std::vector<Value> decodeNumbers(std::string_view bytes, NumberType type, std::endian order);

/// The inverse of decodeNumbers, for values that the type can hold; doubles are rounded to Float32.
/// \tparam Value double, std::int64_t or Index
template <class Value>
std::string encodeNumbers(std::span<const Value> values, NumberType type, std::endian order);

/// Reads the next token of a text as a number of this type; Float32 is rounded as in VTK.
/// \tparam Value as in decodeNumbers(), with the same rule for UInt64
/// \throws FileError as TextReader::number(), and if an integer is out of the range of its type
template <class Value>
Value readNumber(TextReader& text, NumberType type, const char* what);

/// Returns a · b, or the largest number if the product overflows; for sizes that a file claims.
template <class Size = std::size_t>
Size saturatingProduct(std::type_identity_t<Size> a, std::type_identity_t<Size> b) {
    constexpr Size kMax = std::numeric_limits<Size>::max();
    return b != 0 && a > kMax / b ? kMax : a * b;
}

}  // namespace espalier::io

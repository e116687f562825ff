// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>

#include <limits>
#include <string>
#include <type_traits>
#include <utility>

#include "../files/byte_order.h"
#include "vtk_numbers.h"

namespace espalier::io {
namespace {

struct NumberName {
    std::string_view name;
    VtkNumber type;
};

constexpr NumberName kLegacyNames[] = {{"char", VtkNumber::Int8},
                                       {"signed_char", VtkNumber::Int8},
                                       {"unsigned_char", VtkNumber::UInt8},
                                       {"short", VtkNumber::Int16},
                                       {"unsigned_short", VtkNumber::UInt16},
                                       {"int", VtkNumber::Int32},
                                       {"unsigned_int", VtkNumber::UInt32},
                                       {"vtkidtype", VtkNumber::Int32},
                                       {"long", VtkNumber::Int64},
                                       {"unsigned_long", VtkNumber::UInt64},
                                       {"vtktypeint64", VtkNumber::Int64},
                                       {"vtktypeuint64", VtkNumber::UInt64},
                                       {"float", VtkNumber::Float32},
                                       {"double", VtkNumber::Float64}};

constexpr VtkNumber kTypes[] = {
    VtkNumber::Int8,   VtkNumber::UInt8, VtkNumber::Int16,  VtkNumber::UInt16,  VtkNumber::Int32,
    VtkNumber::UInt32, VtkNumber::Int64, VtkNumber::UInt64, VtkNumber::Float32, VtkNumber::Float64};

/// Calls f with a zero of the C++ type that is stored.
template <class F>
auto visitStored(VtkNumber type, F f) {
    switch (type) {
        case VtkNumber::Int8:
            return f(std::int8_t{});
        case VtkNumber::UInt8:
            return f(std::uint8_t{});
        case VtkNumber::Int16:
            return f(std::int16_t{});
        case VtkNumber::UInt16:
            return f(std::uint16_t{});
        case VtkNumber::Int32:
            return f(std::int32_t{});
        case VtkNumber::UInt32:
            return f(std::uint32_t{});
        case VtkNumber::Int64:
            return f(std::int64_t{});
        case VtkNumber::UInt64:
            return f(std::uint64_t{});
        case VtkNumber::Float32:
            return f(float{});
        case VtkNumber::Float64:
            break;
    }
    return f(double{});
}

/// Whether Value can take what is stored: reals are never cut down to integers.
template <class Value, class Stored>
constexpr bool kFits = std::is_floating_point_v<Value> || std::is_integral_v<Stored>;

/// The next token as an integer in the range of its type.
std::int64_t readInteger(TextReader& text, VtkNumber type, const char* what) {
    if (type == VtkNumber::UInt64)
        return static_cast<std::int64_t>(text.number<std::uint64_t>(what));
    const auto number = text.number<std::int64_t>(what);
    if (!canHold(type, number))
        text.fail(std::to_string(number) + " is out of the range of " + xmlName(type) +
                  "; expected " + what);
    return number;
}

/// Rounds to float; what is beyond the largest becomes infinite, as it does in VTK.
float toFloat(double value) {
    constexpr double kLargest = std::numeric_limits<float>::max();
    if (value > kLargest) return std::numeric_limits<float>::infinity();
    if (value < -kLargest) return -std::numeric_limits<float>::infinity();
    return static_cast<float>(value);
}

template <class Stored, class Value>
Stored toStored(Value value) {
    if constexpr (std::is_same_v<Stored, float> && std::is_floating_point_v<Value>)
        return toFloat(value);
    else
        return static_cast<Stored>(value);
}

}  // namespace

std::size_t byteSize(VtkNumber type) {
    return visitStored(type, [](auto zero) { return sizeof zero; });
}

bool isInteger(VtkNumber type) {
    return visitStored(type, [](auto zero) { return std::is_integral_v<decltype(zero)>; });
}

const char* xmlName(VtkNumber type) {
    constexpr const char* kNames[] = {"Int8",   "UInt8", "Int16",  "UInt16",  "Int32",
                                      "UInt32", "Int64", "UInt64", "Float32", "Float64"};
    return kNames[static_cast<std::size_t>(type)];
}

std::optional<VtkNumber> numberOfXmlName(std::string_view name) {
    for (const VtkNumber type : kTypes)
        if (name == xmlName(type)) return type;
    return std::nullopt;
}

std::optional<VtkNumber> numberOfLegacyName(std::string_view name) {
    for (const NumberName& entry : kLegacyNames)
        if (name == entry.name) return entry.type;
    return std::nullopt;
}

const char* legacyName(VtkNumber type) {
    constexpr const char* kNames[] = {
        "signed_char",  "unsigned_char", "short",         "unsigned_short", "int",
        "unsigned_int", "vtktypeint64",  "vtktypeuint64", "float",          "double"};
    return kNames[static_cast<std::size_t>(type)];
}

static_assert(static_cast<int>(VtkNumber::Int8) == static_cast<int>(IntegerType::Int8) &&
                  static_cast<int>(VtkNumber::UInt64) == static_cast<int>(IntegerType::UInt64),
              "both types list the integers in the same order");

VtkNumber numberOf(IntegerType type) {
    return static_cast<VtkNumber>(type);
}

IntegerType integerTypeOf(VtkNumber type) {
    return static_cast<IntegerType>(type);
}

bool canHold(VtkNumber type, std::int64_t value) {
    return visitStored(type, [&](auto zero) {
        using Stored = decltype(zero);
        if constexpr (std::is_floating_point_v<Stored> || std::is_same_v<Stored, std::uint64_t>)
            return true;
        else
            return std::in_range<Stored>(value);
    });
}

template <class Value>
std::vector<Value> decodeNumbers(std::string_view bytes, VtkNumber type, std::endian order) {
    return visitStored(type, [&](auto zero) {
        using Stored = decltype(zero);
        std::vector<Value> values;
        if constexpr (kFits<Value, Stored>) {
            values.reserve(bytes.size() / sizeof zero);
            for (std::size_t at = 0; at + sizeof zero <= bytes.size(); at += sizeof zero)
                values.push_back(static_cast<Value>(loadNumber<Stored>(bytes.data() + at, order)));
        }
        return values;
    });
}

template <class Value>
std::string encodeNumbers(std::span<const Value> values, VtkNumber type, std::endian order) {
    return visitStored(type, [&](auto zero) {
        using Stored = decltype(zero);
        std::string bytes;
        if constexpr (kFits<Stored, Value>) {
            bytes.resize(values.size() * sizeof zero);
            for (std::size_t i = 0; i < values.size(); ++i)
                storeNumber(bytes.data() + i * sizeof zero, toStored<Stored>(values[i]), order);
        }
        return bytes;
    });
}

template <class Value>
Value readNumber(TextReader& text, VtkNumber type, const char* what) {
    if constexpr (std::is_integral_v<Value>) return readInteger(text, type, what);
    if (type != VtkNumber::Float32) return text.number<Value>(what);
    // Straight to float where that is in range, so that the text is rounded once.
    const std::string_view token = text.token(what);
    float number = 0;
    double wide = 0;
    if (!parseNumber(token, number)) {
        if (!parseNumber(token, wide))
            text.fail(inQuotes(token) + " is not a number; expected " + what);
        number = toFloat(wide);
    }
    return static_cast<Value>(number);
}

std::size_t saturatingProduct(std::size_t a, std::size_t b) {
    constexpr std::size_t kMost = std::numeric_limits<std::size_t>::max();
    return b != 0 && a > kMost / b ? kMost : a * b;
}

#define ESPALIER_INSTANTIATE(Value)                                                      \
    template std::vector<Value> decodeNumbers(std::string_view, VtkNumber, std::endian); \
    template std::string encodeNumbers(std::span<const Value>, VtkNumber, std::endian);  \
    template Value readNumber(TextReader&, VtkNumber, const char*);
ESPALIER_INSTANTIATE(double)
ESPALIER_INSTANTIATE(std::int64_t)
#undef ESPALIER_INSTANTIATE

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/progress.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>

#include "bytes.h"
#include "number_types.h"

namespace espalier::io {
namespace {

struct NumberName {
    std::string_view name;
    NumberType type;
};

constexpr NumberName kLegacyNames[] = {{"char", NumberType::Int8},
                                       {"signed_char", NumberType::Int8},
                                       {"unsigned_char", NumberType::UInt8},
                                       {"short", NumberType::Int16},
                                       {"unsigned_short", NumberType::UInt16},
                                       {"int", NumberType::Int32},
                                       {"unsigned_int", NumberType::UInt32},
                                       {"vtkidtype", NumberType::Int32},
                                       {"long", NumberType::Int64},
                                       {"unsigned_long", NumberType::UInt64},
                                       {"vtktypeint64", NumberType::Int64},
                                       {"vtktypeuint64", NumberType::UInt64},
                                       {"float", NumberType::Float32},
                                       {"double", NumberType::Float64}};

/// Names in the order of NumberType.
constexpr const char* kXmlNames[] = {"Int8",   "UInt8", "Int16",  "UInt16",  "Int32",
                                     "UInt32", "Int64", "UInt64", "Float32", "Float64"};

/// True if Value can be read from Stored. Reals are never converted to integers.
template <class Value, class Stored>
constexpr bool kFits = std::is_floating_point_v<Value> || std::is_integral_v<Stored>;

/// Reads the next token as an integer. Throws if it is out of the range of its type.
std::int64_t readInteger(TextReader& text, NumberType type, const char* what) {
    if (type == NumberType::UInt64)
        return static_cast<std::int64_t>(text.number<std::uint64_t>(what));
    const auto number = text.number<std::int64_t>(what);
    if (!canHold(type, number))
        text.fail(concat(number, " is out of the range of ", xmlName(type), "; expected ", what));
    return number;
}

/// Rounds to float. Values beyond the largest float become infinite, as in VTK.
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

std::size_t byteSize(NumberType type) {
    return visitStored(type, [](auto zero) { return sizeof zero; });
}

bool isInteger(NumberType type) {
    return visitStored(type, [](auto zero) { return std::is_integral_v<decltype(zero)>; });
}

const char* xmlName(NumberType type) {
    return kXmlNames[static_cast<std::size_t>(type)];
}

std::optional<NumberType> numberOfXmlName(std::string_view name) {
    const auto at = std::ranges::find(kXmlNames, name);
    if (at == std::end(kXmlNames)) return std::nullopt;
    return static_cast<NumberType>(at - std::begin(kXmlNames));
}

std::optional<NumberType> numberOfLegacyName(std::string_view name) {
    for (const NumberName& entry : kLegacyNames)
        if (name == entry.name) return entry.type;
    return std::nullopt;
}

const char* legacyName(NumberType type) {
    constexpr const char* kNames[] = {
        "signed_char",  "unsigned_char", "short",         "unsigned_short", "int",
        "unsigned_int", "vtktypeint64",  "vtktypeuint64", "float",          "double"};
    return kNames[static_cast<std::size_t>(type)];
}

static_assert(static_cast<int>(NumberType::Int8) == static_cast<int>(IntegerType::Int8) &&
                  static_cast<int>(NumberType::UInt64) == static_cast<int>(IntegerType::UInt64),
              "both types list the integers in the same order");

NumberType numberOf(IntegerType type) {
    return static_cast<NumberType>(type);
}

IntegerType integerTypeOf(NumberType type) {
    return static_cast<IntegerType>(type);
}

bool canHold(NumberType type, std::int64_t value) {
    return visitStored(type, [&](auto zero) {
        using Stored = decltype(zero);
        if constexpr (std::is_floating_point_v<Stored> || std::is_same_v<Stored, std::uint64_t>)
            return true;
        else
            return std::in_range<Stored>(value);
    });
}

std::int64_t loadInteger(const char* bytes, NumberType type, std::endian order) {
    return visitStored(type, [&](auto zero) {
        return static_cast<std::int64_t>(loadNumber<decltype(zero)>(bytes, order));
    });
}

template <class Value>
std::vector<Value> decodeNumbers(std::string_view bytes, NumberType type, std::endian order) {
    return visitStored(type, [&](auto zero) {
        using Stored = decltype(zero);
        std::vector<Value> values;
        if constexpr (kFits<Value, Stored>) {
            values.reserve(bytes.size() / sizeof zero);
            for (std::size_t at = 0; at + sizeof zero <= bytes.size(); at += sizeof zero) {
                checkCancelledEvery(values.size(), 16);
                values.push_back(static_cast<Value>(loadNumber<Stored>(bytes.data() + at, order)));
            }
        }
        return values;
    });
}

template <class Value>
std::string encodeNumbers(std::span<const Value> values, NumberType type, std::endian order) {
    return visitStored(type, [&](auto zero) {
        using Stored = decltype(zero);
        std::string bytes;
        if constexpr (kFits<Stored, Value>) {
            bytes.resize(values.size() * sizeof zero);
            for (std::size_t i = 0; i < values.size(); ++i) {
                checkCancelledEvery(i, 16);
                storeNumber(bytes.data() + i * sizeof zero, toStored<Stored>(values[i]), order);
            }
        }
        return bytes;
    });
}

template <class Value>
Value readNumber(TextReader& text, NumberType type, const char* what) {
    if constexpr (std::is_integral_v<Value>) return readInteger(text, type, what);
    if (type != NumberType::Float32) return text.number<Value>(what);
    // Parses the text as a float directly, so that it is rounded only once.
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

template std::string encodeNumbers(std::span<const Index>, NumberType, std::endian);
template std::string encodeNumbers(std::span<const std::uint8_t>, NumberType, std::endian);

#define ESPALIER_INSTANTIATE(Value)                                                       \
    template std::vector<Value> decodeNumbers(std::string_view, NumberType, std::endian); \
    template std::string encodeNumbers(std::span<const Value>, NumberType, std::endian);  \
    template Value readNumber(TextReader&, NumberType, const char*);
ESPALIER_INSTANTIATE(double)
ESPALIER_INSTANTIATE(std::int64_t)
#undef ESPALIER_INSTANTIATE

}  // namespace espalier::io

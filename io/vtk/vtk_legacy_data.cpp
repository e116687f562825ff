// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>

#include <bit>
#include <charconv>
#include <type_traits>

#include "vtk_legacy_data.h"

namespace espalier::io {

void LegacyData::expect(const char* word) {
    const std::string got(text_.token(word));
    if (lowerCase(got) != lowerCase(word))
        text_.fail("expected " + std::string(word) + ", got " + inQuotes(got));
}

std::string LegacyData::name() {
    const std::string_view token = text_.token("a name");
    std::string name;
    for (std::size_t i = 0; i < token.size(); ++i) {
        unsigned code = 0;
        const char* digits = token.data() + i + 1;
        if (token[i] == '%' && i + 2 < token.size() &&
            std::from_chars(digits, digits + 2, code, 16).ptr == digits + 2) {
            name += static_cast<char>(code);
            i += 2;
        } else {
            name += token[i];
        }
    }
    return name;
}

template <class Value>
std::vector<Value> LegacyData::numbers(const std::string& type, std::size_t count,
                                       const char* what) {
    const std::optional<VtkNumber> number = numberOfLegacyName(type);
    if (!number) text_.fail(inQuotes(type) + " is not a type of numbers");
    if (std::is_integral_v<Value> && !isInteger(*number))
        text_.fail(inQuotes(type) + " is not a type of integers");
    if (isBinary_) {
        beginBinary();
        return decodeNumbers<Value>(text_.bytes(saturatingProduct(count, byteSize(*number)), what),
                                    *number, std::endian::big);
    }
    text_.checkRoom(count, 2, what);
    std::vector<Value> values;
    values.reserve(count);
    for (std::size_t i = 0; i < count; ++i)
        values.push_back(readNumber<Value>(text_, *number, what));
    return values;
}

std::optional<std::vector<double>> LegacyData::values(const std::string& type, std::size_t count,
                                                      const char* what) {
    if (type == "bit")
        skipBits(count);
    else if (type == "string" || type == "utf8_string")
        skipStrings(count);
    else
        return numbers<double>(type, count, what);
    return std::nullopt;
}

void LegacyData::skipColours(std::size_t count) {
    numbers<double>(isBinary_ ? "unsigned_char" : "float", count, "a colour");
}

void LegacyData::skipMetadata() {
    text_.restOfLine();
    while (text_.remaining() > 0 &&
           text_.restOfLine().find_first_not_of(" \t") != std::string::npos) {
    }
}

void LegacyData::skipBits(std::size_t count) {
    if (!isBinary_) {
        numbers<double>("int", count, "a bit");
        return;
    }
    beginBinary();
    text_.bytes(count / 8 + (count % 8 != 0 ? 1 : 0), "bits");
}

void LegacyData::skipStrings(std::size_t count) {
    text_.restOfLine();
    text_.checkRoom(count, 1, "strings");
    for (std::size_t i = 0; i < count; ++i) {
        if (isBinary_)
            skipBinaryString();
        else
            text_.restOfLine();
    }
}

/// The two highest bits of the first byte say how many bytes the length takes: 8, 4, 2 or 1. The
/// other bits of those are the length.
void LegacyData::skipBinaryString() {
    const auto byte = [](std::string_view bytes) {
        return static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[0]));
    };
    const std::uint64_t first = byte(text_.bytes(1, "a string"));
    const int lengthBytes = 8 >> (first >> 6);
    std::uint64_t length = first & 0x3f;
    for (int i = 1; i < lengthBytes; ++i)
        length = length << 8 | byte(text_.bytes(1, "the length of a string"));
    text_.bytes(length, "a string");
}

template std::vector<double> LegacyData::numbers(const std::string&, std::size_t, const char*);
template std::vector<std::int64_t> LegacyData::numbers(const std::string&, std::size_t,
                                                       const char*);

}  // namespace espalier::io

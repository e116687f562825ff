// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/index.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <limits>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#include "../files/bytes.h"
#include "../files/number_types.h"
#include "npy.h"

namespace espalier::io {

void writeNpyHead(ByteOutput& out, std::string_view type, std::optional<std::uint64_t> length) {
    std::string head = "{'descr': '" + std::string(type) + "', 'fortran_order': False, 'shape': (" +
                       (length ? concat(*length, ",") : "") + "), }";
    constexpr std::string_view kFormatVersion("\x01\x00", 2);
    constexpr std::size_t kAlignment = 64;
    const std::size_t unpadded = kNpyMagic.size() + kFormatVersion.size() + 2 + head.size() + 1;
    head.append((kAlignment - unpadded % kAlignment) % kAlignment, ' ');
    head += '\n';
    out.bytes(kNpyMagic);
    out.bytes(kFormatVersion);
    out.number(static_cast<std::uint16_t>(head.size()));
    out.bytes(head);
}

namespace {

/// The head of a file.
struct Head {
    std::optional<std::string> type;
    std::optional<bool> isFortranOrder;
    std::optional<std::vector<std::uint64_t>> shape;
};

/// Reads a head: a dictionary in Python's notation, with 'descr', 'fortran_order' and 'shape'.
class HeadParser {
public:
    explicit HeadParser(std::string_view text) : text_(text) {}

    Head parse() {
        expect('{');
        Head head;
        while (!accept('}')) {
            const std::string_view key = word();
            expect(':');
            if (key == "descr")
                set(head.type, std::string(word()));
            else if (key == "fortran_order")
                set(head.isFortranOrder, readBool());
            else if (key == "shape")
                set(head.shape, shape());
            else
                fail("its keys");
            if (!accept(',')) {
                expect('}');
                break;
            }
        }
        skipSpace();
        if (!text_.empty() || !head.type || !head.isFortranOrder || !head.shape)
            fail("'descr', 'fortran_order' and 'shape'");
        return head;
    }

private:
    template <class Value>
    void set(std::optional<Value>& where, Value value) {
        if (where) fail("each key once");
        where = std::move(value);
    }

    void skipSpace() {
        text_.remove_prefix(std::min(text_.find_first_not_of(" \t\r\n"), text_.size()));
    }

    bool accept(char c) {
        skipSpace();
        if (!text_.starts_with(c)) return false;
        text_.remove_prefix(1);
        return true;
    }

    void expect(char c) {
        if (!accept(c)) fail(std::string("'") + c + "'");
    }

    std::string_view word() {
        const char quote = accept('"') ? '"' : '\'';
        if (quote == '\'' && !accept(quote)) fail("a text in quotes");
        const std::size_t end = text_.find(quote);
        if (end == std::string_view::npos) fail("a text in quotes");
        return take(end + 1).substr(0, end);
    }

    bool readBool() {
        skipSpace();
        const bool value = text_.starts_with("True");
        if (!value && !text_.starts_with("False")) fail("True or False");
        take(value ? 4 : 5);
        return value;
    }

    /// Reads the shape: a tuple of numbers, which may be empty.
    std::vector<std::uint64_t> shape() {
        expect('(');
        std::vector<std::uint64_t> result;
        while (!accept(')')) {
            skipSpace();
            const std::string_view digits =
                take(std::min(text_.find_first_not_of("0123456789"), text_.size()));
            std::uint64_t length = 0;
            if (!parseNumber(digits, length)) fail("a number of items");
            result.push_back(length);
            constexpr std::size_t kMaxAxes = 64;  // as NumPy 2
            if (result.size() > kMaxAxes) fail("at most 64 axes");
            accept('L');  // as Python 2 wrote it
            if (accept(',')) continue;
            // A tuple of one number ends with a comma.
            if (result.size() == 1) fail("','");
            expect(')');
            break;
        }
        return result;
    }

    std::string_view take(std::size_t count) {
        const std::string_view taken = text_.substr(0, count);
        text_.remove_prefix(count);
        return taken;
    }

    [[noreturn]] void fail(const std::string& expected) const {
        throw CodingError("has a malformed header; expected " + expected +
                          (text_.empty() ? " before its end" : ", got " + inQuotes(text_)));
    }

    std::string_view text_;
};

NpyType parseType(std::string name) {
    NpyType type;
    type.name = std::move(name);
    const std::string_view text = type.name;
    constexpr std::size_t kBeforeSize = 2;
    if (text.size() < kBeforeSize || std::string_view("<>|").find(text[0]) == text.npos ||
        !parseNumber(text.substr(kBeforeSize), type.size) || type.size == 0)
        throw CodingError("is of type " + inQuotes(text) + ", which is not of numbers or text");
    // '|' is used for types without a byte order.
    if (text[0] != '|') type.order = text[0] == '<' ? std::endian::little : std::endian::big;
    type.kind = text[1];
    constexpr std::size_t kCharacterSize = 4;
    if (type.kind == 'U') {
        if (type.size > std::numeric_limits<std::size_t>::max() / kCharacterSize)
            throw CodingError("is of type " + inQuotes(text) + ", which is too large");
        type.size *= kCharacterSize;
    }
    return type;
}

[[noreturn]] void failForType(const NpyArray& array, const std::string& expected) {
    throw CodingError("is of type " + inQuotes(array.type.name) + "; expected " + expected);
}

/// Returns the number type of an array; nothing unless it is an integer, or a real of 4 or 8 bytes.
std::optional<NumberType> numberTypeOf(const NpyType& type) {
    const std::string_view kind = type.kind == 'i'   ? "Int"
                                  : type.kind == 'u' ? "UInt"
                                  : type.kind == 'f' ? "Float"
                                                     : "";
    if (kind.empty() || type.size > sizeof(std::uint64_t)) return std::nullopt;
    return numberOfXmlName(concat(kind, 8 * type.size));
}

/// Returns all items as numbers, in the order of the file.
/// \param count number of items
template <class Number>
Array<Number> numbersOf(const NpyArray& array, std::uint64_t count) {
    constexpr bool kIsReal = std::is_floating_point_v<Number>;
    const std::optional<NumberType> type = numberTypeOf(array.type);
    if (!type || (!kIsReal && !isInteger(*type)))
        failForType(array, kIsReal ? "integers, or reals of 4 or 8 bytes" : "integers");
    return visitStored(*type, [&](auto zero) -> Array<Number> {
        using Stored = decltype(zero);
        if constexpr (kIsReal || std::is_integral_v<Stored>)
            return ByteInput(array.bytes, array.type.order).numbersAs<Stored, Number>(count);
        else
            return {};
    });
}

}  // namespace

NpyArray readNpy(std::string_view file) {
    ByteInput in(file, std::endian::little);
    if (!file.starts_with(kNpyMagic)) throw CodingError("is not an array of NumPy");
    in.bytes(kNpyMagic.size());
    const int version = in.number<std::uint8_t>();
    in.number<std::uint8_t>();  // minor version, which has no meaning yet
    if (version < 1 || version > 3)
        throw CodingError(concat("has version ", version, "; expected 1 to 3"));
    const std::uint32_t headSize =
        version == 1 ? in.number<std::uint16_t>() : in.number<std::uint32_t>();
    const Head head = HeadParser(in.bytes(headSize)).parse();
    NpyArray array{parseType(*head.type), *head.shape, *head.isFortranOrder, in.bytes(in.left())};
    std::uint64_t count = 1;
    for (const std::uint64_t length : array.shape) {
        if (length != 0 && count > std::numeric_limits<std::uint64_t>::max() / length)
            throw CodingError("claims more than 2^64 items");
        count *= length;
    }
    if (array.bytes.size() % array.type.size != 0 || array.bytes.size() / array.type.size != count)
        throw CodingError(concat("claims ", count, " items of ", array.type.size, " bytes, but ",
                                 array.bytes.size(), " bytes are there"));
    return array;
}

template <class Number>
Array<Number> npyNumbers(const NpyArray& array) {
    if (array.shape.empty()) throw CodingError("is a single item; expected an array");
    if (array.shape.size() > 1) throw CodingError("has several axes; expected one");
    return numbersOf<Number>(array, array.shape[0]);
}

Array<double> npyMatrix(const NpyArray& array) {
    if (array.shape.size() != 2)
        throw CodingError(concat("has ", array.shape.size(), " axes; expected two"));
    const std::size_t rows = array.shape[0], columns = array.shape[1];
    auto stored = numbersOf<double>(array, rows * columns);
    if (!array.isFortranOrder) return stored;
    Array<double> numbers(stored.size());
    for (std::size_t i = 0; i < stored.size(); ++i)
        numbers[i % rows * columns + i / rows] = stored[i];
    return numbers;
}

std::string shapeText(std::span<const std::uint64_t> shape) {
    std::string text = "(";
    for (std::size_t i = 0; i < shape.size(); ++i) text += concat(i == 0 ? "" : ", ", shape[i]);
    return text + (shape.size() == 1 ? ",)" : ")");
}

std::string npyText(const NpyArray& array) {
    if (!array.shape.empty() || (array.type.kind != 'S' && array.type.kind != 'U'))
        failForType(array, "a single text");
    const bool isUnicode = array.type.kind == 'U';
    ByteInput in(array.bytes, array.type.order);
    std::string text;
    while (in.left() > 0) {
        const std::uint32_t character =
            isUnicode ? in.number<std::uint32_t>() : in.number<std::uint8_t>();
        constexpr std::uint32_t kAsciiEnd = 128;
        if (character >= kAsciiEnd) throw CodingError("is not a text in ASCII");
        text += static_cast<char>(character);
    }
    // A text that is shorter than its type is padded with zeros.
    text.resize(text.find_last_not_of('\0') + 1);
    return text;
}

template Array<Index> npyNumbers(const NpyArray&);
template Array<Offset> npyNumbers(const NpyArray&);
template Array<double> npyNumbers(const NpyArray&);

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/number_text.h>
#include <espalier/base/progress.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <cstdint>
#include <type_traits>
#include <utility>

namespace espalier::io {
namespace {

bool isSpace(char c) {
    return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f';
}

/// Parses the exponent after the "e" of a decimal number. Huge exponents are clamped to ±2^60,
/// which no number of digits in a text can outweigh.
std::int64_t exponentIn(std::string_view text) {
    constexpr std::int64_t kHuge = std::int64_t{1} << 60;
    if (text.starts_with('+')) text.remove_prefix(1);
    std::int64_t exponent = 0;
    const auto result = scanNumber(text, exponent);
    if (result.ec != std::errc()) return text.starts_with('-') ? -kHuge : kHuge;
    return std::clamp(exponent, -kHuge, kHuge);
}

/// Returns true if the absolute value of a decimal number other than 0 is less than 1.
bool isBelowOne(std::string_view text) {
    const std::size_t end = std::min(text.find_first_of("eE"), text.size());
    const std::string_view mantissa = text.substr(0, end);
    const auto point = static_cast<std::int64_t>(std::min(mantissa.find('.'), end));
    const auto digit = static_cast<std::int64_t>(mantissa.find_first_of("123456789"));
    // The power of ten of the first nonzero digit.
    const std::int64_t power = digit < point ? point - digit - 1 : point - digit;
    return power + (end < text.size() ? exponentIn(text.substr(end + 1)) : 0) < 0;
}

}  // namespace

TextReader::TextReader(std::filesystem::path path, std::string_view text, std::size_t firstLine)
    : path_(std::move(path)), text_(text), line_(firstLine), nextLine_(firstLine) {}

void TextReader::skipSpace() {
    bool inComment = false;
    for (; position_ < text_.size(); ++position_) {
        const char c = text_[position_];
        if (c == '\n') {
            ++nextLine_;
            inComment = false;
        } else if (opensComment(c)) {
            inComment = true;
        } else if (!inComment && !isSpace(c)) {
            break;
        }
    }
}

/// Lets the host cancel the reading of a long text.
void TextReader::checkHost() {
    constexpr std::size_t kBytes = 1 << 16;  // about a millisecond
    if (position_ < nextCheck_) return;
    nextCheck_ = position_ + kBytes;
    checkCancelled();
}

bool TextReader::atEnd() {
    skipSpace();
    return position_ == text_.size();
}

std::string_view TextReader::token(const char* what) {
    checkHost();
    skipSpace();
    line_ = nextLine_;
    const std::size_t begin = position_;
    while (position_ < text_.size() && !isSpace(text_[position_]) &&
           !opensComment(text_[position_]))
        ++position_;
    if (begin == position_) fail(std::string("the file ends; expected ") + what);
    return text_.substr(begin, position_ - begin);
}

template <class Number>
Number TextReader::number(const char* what) {
    const std::string_view text = token(what);
    Number result{};
    if (!parseNumber(text, result)) fail(inQuotes(text) + " is not a number; expected " + what);
    return result;
}

std::size_t TextReader::count(const char* what, std::size_t minBytes) {
    const auto result = number<std::uint64_t>(what);
    checkRoom(result, minBytes, what);
    return result;
}

void TextReader::checkRoom(std::uint64_t count, std::size_t minBytes, const char* what) const {
    if (count > (remaining() + 1) / minBytes)
        fail(concat(what, " is ", count, ", but only ", remaining(), " bytes are left"));
}

std::string_view TextReader::restOfLine() {
    checkHost();
    line_ = nextLine_;
    const std::size_t begin = position_;
    std::size_t end = text_.find('\n', begin);
    if (end == std::string_view::npos) {
        position_ = end = text_.size();
    } else {
        position_ = end + 1;
        ++nextLine_;
    }
    if (end > begin && text_[end - 1] == '\r') --end;
    return text_.substr(begin, end - begin);
}

std::string_view TextReader::bytes(std::size_t count, const char* what) {
    checkHost();
    line_ = nextLine_;
    if (text_.size() - position_ < count)
        fail(concat("the file ends; expected ", what, " (", count, " bytes, got ",
                    text_.size() - position_, ")"));
    const std::string_view result = text_.substr(position_, count);
    position_ += count;
    return result;
}

void TextReader::fail(const std::string& cause) const {
    throw FileError(path_, line_, cause);
}

template <class Number>
bool parseNumber(std::string_view token, Number& number) {
    if (!token.empty() && token.front() == '+') token.remove_prefix(1);
    const auto [end, error] = scanNumber(token, number);
    if (end != token.data() + token.size()) return false;
    if constexpr (std::is_floating_point_v<Number>) {
        // scanNumber() reports the same error for numbers near 0 and for numbers too large.
        if (error == std::errc::result_out_of_range && isBelowOne(token)) {
            number = token.starts_with('-') ? -Number(0) : Number(0);
            return true;
        }
    }
    return error == std::errc();
}

std::string formatNumber(double number) {
    return std::string(NumberText(number).view());
}

std::string formatNumber(float number) {
    return std::string(NumberText(number).view());
}

std::string lowerCase(std::string_view text) {
    std::string result(text);
    for (char& c : result)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return result;
}

#define ESPALIER_INSTANTIATE(Number)                      \
    template Number TextReader::number(const char* what); \
    template bool parseNumber(std::string_view token, Number& number);
ESPALIER_INSTANTIATE(float)
ESPALIER_INSTANTIATE(double)
ESPALIER_INSTANTIATE(std::int8_t)
ESPALIER_INSTANTIATE(std::uint8_t)
ESPALIER_INSTANTIATE(std::int16_t)
ESPALIER_INSTANTIATE(std::uint16_t)
ESPALIER_INSTANTIATE(std::int32_t)
ESPALIER_INSTANTIATE(std::uint32_t)
ESPALIER_INSTANTIATE(std::int64_t)
ESPALIER_INSTANTIATE(std::uint64_t)
#undef ESPALIER_INSTANTIATE

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#include "base64.h"
#include "coding_error.h"

#include <array>
#include <cstdint>

namespace espalier::io {
namespace {

constexpr std::string_view kAlphabet =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
constexpr char kPadding = '=';
constexpr std::uint8_t kNoDigit = 64;

constexpr std::array<std::uint8_t, 256> makeDigits() {
    std::array<std::uint8_t, 256> digits{};
    for (auto& digit : digits) digit = kNoDigit;
    for (std::size_t i = 0; i < kAlphabet.size(); ++i)
        digits[static_cast<unsigned char>(kAlphabet[i])] = static_cast<std::uint8_t>(i);
    return digits;
}

constexpr std::array<std::uint8_t, 256> kBase64Digits = makeDigits();

bool isXmlSpace(char c) {
    return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

}  // namespace

std::string encodeBase64(std::string_view bytes) {
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    const auto byteAt = [&](std::size_t at) -> std::uint32_t {
        return at < bytes.size() ? static_cast<unsigned char>(bytes[at]) : 0;
    };
    for (std::size_t at = 0; at < bytes.size(); at += 3) {
        const std::uint32_t group = byteAt(at) << 16 | byteAt(at + 1) << 8 | byteAt(at + 2);
        for (std::size_t i = 0; i < 4; ++i)
            text += at + i > bytes.size() ? kPadding : kAlphabet[group >> (18 - 6 * i) & 63];
    }
    return text;
}

char Base64Reader::nextCharacter() {
    while (position_ < text_.size() && isXmlSpace(text_[position_])) ++position_;
    if (position_ == text_.size()) throw CodingError("the base64 data ends too early");
    return text_[position_++];
}

void Base64Reader::readQuad() {
    std::uint32_t group = 0;
    std::size_t padding = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        const char c = nextCharacter();
        const std::uint8_t digit = kBase64Digits[static_cast<unsigned char>(c)];
        if (c == kPadding && i >= 2)
            ++padding;
        else if (digit == kNoDigit || padding > 0)
            throw CodingError("character code " + std::to_string(static_cast<unsigned char>(c)) +
                              " is out of place in base64 data");
        group = group << 6 | (c == kPadding ? 0u : digit);
    }
    for (std::size_t i = 0; i < 3 - padding; ++i)
        left_ += static_cast<char>(group >> (16 - 8 * i) & 0xff);
}

std::string Base64Reader::read(std::size_t count) {
    if (count > mostLeft())
        throw CodingError("the base64 data ends too early: " + std::to_string(count) +
                          " bytes are claimed, at most " + std::to_string(mostLeft()) +
                          " are there");
    left_.reserve(count + 3);
    while (left_.size() < count) readQuad();
    std::string result = left_.substr(0, count);
    left_.erase(0, count);
    return result;
}

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/memory.h>
#include <espalier/base/progress.h>
#include <espalier/io/files/base64.h>

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <new>

#include "bytes.h"
#include "coding.h"

namespace espalier::io {
namespace {

constexpr std::uint8_t kNoDigit = 64;

constexpr std::array<std::uint8_t, 256> makeDigits() {
    std::array<std::uint8_t, 256> digits{};
    for (auto& digit : digits) digit = kNoDigit;
    for (std::size_t i = 0; i < kBase64Alphabet.size(); ++i)
        digits[static_cast<unsigned char>(kBase64Alphabet[i])] = static_cast<std::uint8_t>(i);
    return digits;
}

constexpr std::array<std::uint8_t, 256> kBase64Digits = makeDigits();

bool isXmlSpace(char c) {
    return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

}  // namespace

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
        if (c == kBase64Padding && i >= 2)
            ++padding;
        else if (digit == kNoDigit || padding > 0)
            throw CodingError(concat("character code ", static_cast<unsigned char>(c),
                                     " is out of place in base64 data"));
        group = group << 6 | (c == kBase64Padding ? 0u : digit);
    }
    for (std::size_t i = 0; i < 3 - padding; ++i)
        left_ += static_cast<char>(group >> (16 - 8 * i) & 0xff);
}

std::string Base64Reader::read(std::size_t count) {
    if (count > maxLeft())
        throw CodingError(concat("the base64 data ends too early: ", count,
                                 " bytes are claimed, at most ", maxLeft(), " are there"));
    left_.reserve(count + 3);
    for (std::size_t quad = 0; left_.size() < count; ++quad) {
        checkCancelledEvery(quad, 16);
        readQuad();
    }
    std::string result = left_.substr(0, count);
    left_.erase(0, count);
    return result;
}

namespace {

/// Removes the next part from a size and returns it. zlib's counters have 32 bits, and the host may
/// cancel between two parts, which take a few milliseconds.
uInt takePart(std::size_t& left) {
    const std::size_t part = std::min<std::size_t>(left, 1 << 20);
    left -= part;
    return static_cast<uInt>(part);
}

class Inflater {
public:
    explicit Inflater(DeflateForm form) {
        constexpr int kLargestWindow = 15;
        const int window = form == DeflateForm::Raw ? -kLargestWindow : kLargestWindow;
        if (::inflateInit2(&state_, window) != Z_OK) throw std::bad_alloc();
    }
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;
    ~Inflater() { ::inflateEnd(&state_); }

    /// Inflates a stream to `to`.
    /// \return true if the stream ends after exactly `size` bytes
    bool inflate(std::string_view stream, Bytef* to, std::size_t size) {
        // zlib takes the input without const, and does not change it.
        state_.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(stream.data()));
        state_.next_out = to;
        std::size_t inLeft = stream.size(), outLeft = size;
        int status = Z_OK;
        while (status == Z_OK) {
            checkCancelled();
            if (state_.avail_in == 0) state_.avail_in = takePart(inLeft);
            if (state_.avail_out == 0) state_.avail_out = takePart(outLeft);
            // zlib reports an error if it has neither input nor room for output.
            status = ::inflate(&state_, Z_NO_FLUSH);
        }
        if (status == Z_MEM_ERROR) throw std::bad_alloc();
        return status == Z_STREAM_END && outLeft == 0 && state_.avail_out == 0;
    }

private:
    z_stream state_ = {};
};

}  // namespace

void appendInflated(std::string_view stream, std::uint64_t size, DeflateForm form,
                    std::string& bytes) {
    if (size / kMaxInflation > stream.size())
        throw CodingError(
            concat("a stream of ", stream.size(), " compressed bytes claims to hold ", size));
    requireMemory(size, "its data");
    Inflater inflater(form);
    const std::size_t before = bytes.size();
    bytes.resize(sizeInMemory(before + size));
    // zlib refuses a null destination, which an empty result could have.
    Bytef none = 0;
    Bytef* to = size == 0 ? &none : reinterpret_cast<Bytef*>(bytes.data() + before);
    if (!inflater.inflate(stream, to, size))
        throw CodingError(
            concat("a compressed stream of ", stream.size(), " bytes is damaged (zlib)"));
}

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/memory.h>
#include <espalier/base/parallel.h>
#include <espalier/io/files/base64.h>
#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <new>
#include <optional>
#include <utility>
#include <vector>

#include "../files/bytes.h"
#include "../files/coding.h"
#include "../files/number_types.h"
#include "vtk_payload.h"

namespace espalier::io {
namespace {

/// Size of an uncompressed block in bytes; VTK's own writer uses the same.
constexpr std::size_t kBlockSize = 32768;

/// Reads the bytes and header words of one array, raw or in base64.
class PayloadReader {
public:
    PayloadReader(std::string_view text, PayloadForm form, const VtkCoding& coding)
        : coding_(coding), raw_(text, coding.byteOrder) {
        if (form == PayloadForm::Base64) base64_.emplace(text);
    }

    std::size_t maxLeft() const { return base64_ ? base64_->maxLeft() : raw_.left(); }
    std::string read(std::uint64_t count) {
        if (base64_) return base64_->read(sizeInMemory(count));
        if (count > raw_.left())
            throw CodingError(concat("the raw data ends too early: ", count, " bytes are claimed, ",
                                     raw_.left(), " are there"));
        return std::string(raw_.bytes(count));
    }
    std::size_t wordSize() const { return coding_.has64BitHeader ? 8 : 4; }
    std::uint64_t readWord() {
        if (coding_.has64BitHeader)
            return loadNumber<std::uint64_t>(read(8).data(), coding_.byteOrder);
        return loadNumber<std::uint32_t>(read(4).data(), coding_.byteOrder);
    }

private:
    VtkCoding coding_;
    ByteInput raw_;
    std::optional<Base64Reader> base64_;  ///< read instead of raw_, if present
};

std::string decodeCompressed(PayloadReader& reader) {
    const std::uint64_t blockCount = reader.readWord();
    if (blockCount == 0) return {};
    const std::uint64_t blockSize = reader.readWord();
    const std::uint64_t lastSize = reader.readWord();
    if (blockCount > reader.maxLeft() / reader.wordSize())
        throw CodingError(concat("the data claims ", blockCount, " compressed blocks; at most ",
                                 reader.maxLeft(), " bytes are left"));
    std::vector<std::uint64_t> compressedSizes(blockCount);
    for (std::uint64_t& size : compressedSizes) size = reader.readWord();
    requireMemory(std::min(saturatingProduct<std::uint64_t>(blockCount, blockSize),
                           saturatingProduct<std::uint64_t>(kMaxInflation, reader.maxLeft())),
                  "its data");
    std::string bytes;
    for (std::uint64_t block = 0; block < blockCount; ++block) {
        const bool isCut = block + 1 == blockCount && lastSize != 0;
        appendInflated(reader.read(compressedSizes[block]), isCut ? lastSize : blockSize,
                       DeflateForm::Zlib, bytes);
    }
    return bytes;
}

void appendWord(std::string& header, std::uint64_t word, const VtkCoding& coding) {
    const bool isWide = coding.has64BitHeader;
    if (!isWide && word > std::numeric_limits<std::uint32_t>::max())
        throw CodingError(
            concat("an array of ", word, " bytes is too large for the file's header_type, UInt32"));
    char bytes[8];
    if (isWide)
        storeNumber(bytes, word, coding.byteOrder);
    else
        storeNumber(bytes, static_cast<std::uint32_t>(word), coding.byteOrder);
    header.append(bytes, isWide ? 8 : 4);
}

std::string compressed(std::string_view bytes) {
    // zlib's default, level 6, takes three times as long and saves less than a tenth.
    constexpr int kLevel = 4;
    uLongf size = ::compressBound(bytes.size());
    std::string result(size, '\0');
    // The output has room for the worst case, so only a lack of memory can make this fail.
    if (::compress2(reinterpret_cast<Bytef*>(result.data()), &size,
                    reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(), kLevel) != Z_OK)
        throw std::bad_alloc();
    return result.substr(0, size);
}

template <class Value>
void appendCompressed(std::string& text, std::span<const Value> values, NumberType type,
                      const VtkCoding& coding) {
    const std::size_t blockLength = kBlockSize / byteSize(type);
    const std::size_t blockCount = (values.size() + blockLength - 1) / blockLength;
    std::vector<std::string> blocks(blockCount);
    parallelFor(static_cast<Offset>(blockCount), 16, [&](Offset first, Offset last) {
        for (Offset block = first; block < last; ++block) {
            const auto rest = values.subspan(block * blockLength);
            blocks[block] = compressed(encodeNumbers(rest.first(std::min(blockLength, rest.size())),
                                                     type, coding.byteOrder));
        }
    });
    std::string header;
    std::string bytes;
    appendWord(header, blockCount, coding);
    appendWord(header, kBlockSize, coding);
    appendWord(header, values.size() % blockLength * byteSize(type), coding);
    std::size_t size = 0;
    for (const std::string& block : blocks) {
        appendWord(header, block.size(), coding);
        size += block.size();
    }
    bytes.reserve(size);
    for (std::string& block : blocks) bytes += std::exchange(block, {});
    appendBase64(text, header);
    appendBase64(text, bytes);
}

}  // namespace

std::uint64_t claimedSize(std::string_view text, PayloadForm form, const VtkCoding& coding) {
    PayloadReader reader(text, form, coding);
    const std::uint64_t first = reader.readWord();
    if (!coding.isCompressed || first == 0) return first;
    const std::uint64_t blockSize = reader.readWord();
    const std::uint64_t lastSize = reader.readWord();
    if (lastSize == 0) return saturatingProduct<std::uint64_t>(first, blockSize);
    const std::uint64_t whole = saturatingProduct<std::uint64_t>(first - 1, blockSize);
    constexpr auto kMax = std::numeric_limits<std::uint64_t>::max();
    return whole > kMax - lastSize ? kMax : whole + lastSize;
}

std::string decodePayload(std::string_view text, PayloadForm form, const VtkCoding& coding) {
    PayloadReader reader(text, form, coding);
    if (coding.isCompressed) return decodeCompressed(reader);
    return reader.read(reader.readWord());
}

std::string decodePayloadOfSize(std::string_view text, std::uint64_t size, PayloadForm form,
                                const VtkCoding& coding) {
    PayloadReader reader(text, form, coding);
    reader.readWord();
    return reader.read(size);
}

template <class Value>
void appendPayload(std::string& text, std::span<const Value> values, NumberType type,
                   const VtkCoding& coding) {
    if (coding.isCompressed) return appendCompressed(text, values, type, coding);
    std::string payload;
    appendWord(payload, values.size() * byteSize(type), coding);
    payload += encodeNumbers(values, type, coding.byteOrder);
    appendBase64(text, payload);
}

#define ESPALIER_INSTANTIATE(Value) \
    template void appendPayload(std::string&, std::span<const Value>, NumberType, const VtkCoding&);
ESPALIER_INSTANTIATE(double)
ESPALIER_INSTANTIATE(std::int64_t)
ESPALIER_INSTANTIATE(Index)
ESPALIER_INSTANTIATE(std::uint8_t)
#undef ESPALIER_INSTANTIATE

}  // namespace espalier::io

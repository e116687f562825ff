// SPDX-License-Identifier: Apache-2.0
#include "io/vtk/vtk_payload.h"
#include <espalier/io/files/base64.h>
#include <io/model_files.h>
#include "io/files/bytes.h"
#include "io/files/coding.h"
#include "support/test.h"

namespace espalier::test {
namespace {

using io::Base64Reader;
using io::CodingError;
using io::decodePayload;
using io::encodeBase64;
using io::PayloadForm;
using io::VtkCoding;

/// The test vectors are in RFC 4648, section 10.
TEST(Base64, MatchesTheTestVectorsOfRfc4648) {
    const std::pair<std::string, std::string> vectors[] = {{"", ""},
                                                           {"f", "Zg=="},
                                                           {"fo", "Zm8="},
                                                           {"foo", "Zm9v"},
                                                           {"foob", "Zm9vYg=="},
                                                           {"fooba", "Zm9vYmE="},
                                                           {"foobar", "Zm9vYmFy"}};
    for (const auto& [bytes, text] : vectors) {
        EXPECT_EQ(encodeBase64(bytes), text);
        EXPECT_EQ(Base64Reader(text).read(bytes.size()), bytes);
    }
    EXPECT_EQ(encodeBase64("\xff\xfe\xfd\xfc"), "//79/A==");
}

TEST(Base64, ReadsInSteps) {
    Base64Reader reader("Zm9v\n  Ym\tFy");
    EXPECT_EQ(reader.read(1), "f");
    EXPECT_EQ(reader.read(0), "");
    EXPECT_EQ(reader.read(4), "ooba");
    EXPECT_EQ(reader.read(1), "r");
    EXPECT_REFUSED(CodingError, "ends too early", reader.read(1));
}

TEST(Base64, ReadsOnAfterPadding) {
    EXPECT_EQ(Base64Reader("Zm8=b2Jhcg==").read(6), "foobar");
}

TEST(Base64, RefusesOtherCharactersAndReadingBeyondTheEnd) {
    for (const char* text : {"Zm9*", "Z===", "Zm=v", "=AAA", "Zm9", "Zm9vZ"})
        EXPECT_THROW(Base64Reader(text).read(4), CodingError) << text;
    // A size beyond the memory is refused before it is allocated.
    EXPECT_THROW(Base64Reader("Zm9v").read(std::numeric_limits<std::size_t>::max()), CodingError);
}

std::vector<VtkCoding> allCodings() {
    std::vector<VtkCoding> codings;
    for (const auto order : {std::endian::little, std::endian::big})
        for (const bool isWide : {false, true})
            for (const bool isCompressed : {false, true})
                codings.push_back({order, isWide, isCompressed});
    return codings;
}

template <class Value>
std::string encoded(const std::vector<Value>& values, io::NumberType type,
                    const VtkCoding& coding) {
    std::string text = "before ";
    io::appendPayload<Value>(text, values, type, coding);
    EXPECT_EQ(text.substr(0, 7), "before ");
    return text.substr(7);
}

std::string encoded(std::string_view bytes, const VtkCoding& coding) {
    const std::vector<std::uint8_t> numbers(bytes.begin(), bytes.end());
    return encoded(numbers, io::NumberType::UInt8, coding);
}

TEST(VtkPayload, RoundTripIsExact) {
    std::string bytes;
    for (const std::size_t size : {0u, 1u, 2u, 3u, 32768u, 32769u, 100000u}) {
        while (bytes.size() < size) bytes += char(bytes.size() * bytes.size() / 7);
        for (const VtkCoding& coding : allCodings()) {
            const std::string text = encoded(bytes, coding);
            EXPECT_EQ(decodePayload(text, PayloadForm::Base64, coding), bytes) << size;
            // Text after an array is ignored.
            EXPECT_EQ(decodePayload(text + "AAAA", PayloadForm::Base64, coding), bytes) << size;
        }
    }
}

TEST(VtkPayload, EncodesNumbersOfEachSize) {
    std::vector<std::int64_t> integers;
    std::vector<double> reals;
    for (int i = 0; i < 20000; ++i) {
        integers.push_back(i % 100);
        reals.push_back(i / 8.0);
    }
    for (const VtkCoding& coding : allCodings()) {
        for (const auto type :
             {io::NumberType::UInt8, io::NumberType::Int16, io::NumberType::Int64})
            EXPECT_EQ(decodePayload(encoded(integers, type, coding), PayloadForm::Base64, coding),
                      io::encodeNumbers<std::int64_t>(integers, type, coding.byteOrder));
        for (const auto type : {io::NumberType::Float32, io::NumberType::Float64})
            EXPECT_EQ(decodePayload(encoded(reals, type, coding), PayloadForm::Base64, coding),
                      io::encodeNumbers<double>(reals, type, coding.byteOrder));
    }
}

/// VTK wrote these: 7 bytes of bits in a file with 32-bit headers, without compression.
TEST(VtkPayload, DecodesBytesWrittenByVtk) {
    const VtkCoding coding{std::endian::little, false, false};
    EXPECT_EQ(decodePayload("BwAAAFVVVVVVVUA=", PayloadForm::Base64, coding), "UUUUUU@");
    EXPECT_EQ(encoded("UUUUUU@", coding), "BwAAAFVVVVVVVUA=");
}

TEST(VtkPayload, DecodesRawData) {
    const std::string raw("\0\0\0\3abcdef", 10);
    EXPECT_EQ(decodePayload(raw, PayloadForm::Raw, {std::endian::big, false, false}), "abc");
    EXPECT_THAT(messageOf<CodingError>([&] {
                    decodePayload(raw, PayloadForm::Raw, {std::endian::little, false, false});
                }),
                // In the wrong byte order, 3 is 3 · 2²⁴.
                HasSubstr("50331648 bytes are claimed, 6 are there"));
}

TEST(VtkPayload, TruncatedDataIsRefused) {
    for (const VtkCoding& coding : allCodings()) {
        const std::string text = encoded(std::string(1000, 'x') + "y", coding);
        for (std::size_t size = 0; size < text.size(); size += 1 + text.size() / 50)
            EXPECT_THROW(decodePayload(text.substr(0, size), PayloadForm::Base64, coding),
                         CodingError)
                << size;
    }
}

/// Returns the bytes of 64-bit little-endian words.
std::string words(std::initializer_list<std::uint64_t> values) {
    std::string bytes;
    for (const std::uint64_t value : values)
        for (int i = 0; i < 8; ++i) bytes += char(value >> (8 * i));
    return bytes;
}

TEST(VtkPayload, ClaimedSizesAreCheckedBeforeAllocating) {
    constexpr std::uint64_t kLargest = std::numeric_limits<std::uint64_t>::max();
    const auto refusal = [](const std::string& raw) {
        return messageOf<CodingError>([&] { decodePayload(raw, PayloadForm::Raw, {}); });
    };
    EXPECT_THAT(refusal(words({kLargest, 1, 0})), HasSubstr("compressed blocks"));
    EXPECT_THAT(refusal(words({2, 1, 0, 1})), HasSubstr("compressed blocks"));
    EXPECT_THAT(refusal(words({1, 1, 0, kLargest})), HasSubstr("ends too early"));
    EXPECT_THAT(refusal(words({1, kLargest, 0, 8, 0})),
                HasSubstr("claims to hold 18446744073709551615"));
    EXPECT_THAT(refusal(words({1, 8, 0, 8, 0})), HasSubstr("is damaged"));
    VtkCoding plain;
    plain.isCompressed = false;
    EXPECT_REFUSED(CodingError, "18446744073709551615 bytes are claimed, 8 are there",
                   decodePayload(words({kLargest, 0}), PayloadForm::Raw, plain));
}

TEST(VtkPayload, SizeOtherThanClaimedIsRefused) {
    std::string text = encoded("abcdefgh", {});
    // The header has 4 words (44 characters): 1 block, its size, the size of the last block (8),
    // the compressed size. The third word begins with byte 16, in characters 21 to 23; it is
    // changed to 7 and 9.
    const std::string header = Base64Reader(text).read(32);
    for (const char size : {'\7', '\11'}) {
        std::string changed = header;
        changed[16] = size;
        EXPECT_REFUSED(
            CodingError, "is damaged",
            decodePayload(encodeBase64(changed) + text.substr(44), PayloadForm::Base64, {}));
    }
}

}  // namespace
}  // namespace espalier::test

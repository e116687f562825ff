// SPDX-License-Identifier: Apache-2.0
#include "io/files/bytes.h"
#include "io/vtk/vtk_payload.h"

#include "fuzz_target.h"

namespace espalier::fuzz {
namespace {

const Target kPayload("payload", [](std::string_view bytes) {
    Input input(bytes);
    const std::uint8_t choices = input.byte();
    io::VtkCoding coding;
    coding.byteOrder = (choices & 1) != 0 ? std::endian::big : std::endian::little;
    coding.has64BitHeader = (choices & 2) != 0;
    coding.isCompressed = (choices & 4) != 0;
    const auto form = (choices & 8) != 0 ? io::PayloadForm::Base64 : io::PayloadForm::Raw;
    const std::string_view text = bytes.substr(bytes.size() - input.left());
    const auto decoded = resultOf([&] { return io::decodePayload(text, form, coding); });
    if (!decoded) return;
    const std::vector<std::int64_t> numbers =
        io::decodeNumbers<std::int64_t>(*decoded, io::NumberType::UInt8, coding.byteOrder);
    std::string coded;
    io::appendPayload<std::int64_t>(coded, numbers, io::NumberType::UInt8, coding);
    require(io::decodePayload(coded, io::PayloadForm::Base64, coding) == *decoded,
            "what is coded is decoded");
});

}  // namespace
}  // namespace espalier::fuzz

// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/coding_error.h>
#include <espalier/io/vtk_payload.h>

#include "fuzz_target.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace espalier;
    fuzz::Input input(data, size);
    const std::uint8_t choices = input.byte();
    io::VtkCoding coding;
    coding.byteOrder = (choices & 1) != 0 ? std::endian::big : std::endian::little;
    coding.has64BitHeader = (choices & 2) != 0;
    coding.isCompressed = (choices & 4) != 0;
    const auto form = (choices & 8) != 0 ? io::PayloadForm::Base64 : io::PayloadForm::Raw;
    const std::string_view text = fuzz::textOf(data + size - input.left(), input.left());
    const auto bytes = fuzz::resultOf([&] { return io::decodePayload(text, form, coding); });
    if (!bytes) return 0;
    const std::string coded = io::encodePayload(*bytes, coding);
    fuzz::require(io::decodePayload(coded, io::PayloadForm::Base64, coding) == *bytes,
                  "what is coded is decoded");
    return 0;
}

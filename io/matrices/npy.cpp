// SPDX-License-Identifier: Apache-2.0
#include "npy.h"

#include <string>

namespace espalier::io {

void writeNpyHead(ByteOutput& out, std::string_view type, std::optional<std::uint64_t> length) {
    std::string head = "{'descr': '" + std::string(type) + "', 'fortran_order': False, 'shape': (" +
                       (length ? std::to_string(*length) + "," : "") + "), }";
    constexpr std::string_view kVersion("\x01\x00", 2);
    constexpr std::size_t kAlignment = 64;
    const std::size_t unpadded = kNpyMagic.size() + kVersion.size() + 2 + head.size() + 1;
    head.append((kAlignment - unpadded % kAlignment) % kAlignment, ' ');
    head += '\n';
    out.bytes(kNpyMagic);
    out.bytes(kVersion);
    out.number(static_cast<std::uint16_t>(head.size()));
    out.bytes(head);
}

}  // namespace espalier::io

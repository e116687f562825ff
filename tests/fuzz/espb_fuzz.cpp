// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/binding_file.h>
#include <zlib.h>

#include <bit>
#include <cstring>

#include "fuzz_target.h"
#include "written.h"

namespace espalier::fuzz {
namespace {

/// Replaces the checksum at the end of the bytes by the right one, which no mutation would find.
std::string withChecksum(std::string_view bytes) {
    std::string result(bytes);
    if (result.size() < sizeof(std::uint32_t)) return result;
    const std::size_t end = result.size() - sizeof(std::uint32_t);
    const auto checksum = static_cast<std::uint32_t>(
        ::crc32_z(0, reinterpret_cast<const Bytef*>(result.data()), end));
    static_assert(std::endian::native == std::endian::little);
    std::memcpy(result.data() + end, &checksum, sizeof checksum);
    return result;
}

const Target kEspb("espb", [](std::string_view bytes) {
    const std::string name = "a.espb";
    readResult(name, [&] { return io::readBoundModel(name, bytes); });
    const std::string whole = withChecksum(bytes);
    const auto model = readResult(name, [&] { return io::readBoundModel(name, whole); });
    if (!model) return;
    const std::string once =
        written(name, [&](const auto& path) { io::writeBoundModel(path, *model); });
    // All bytes are equal except four bytes without meaning, and the checksum.
    require(once.size() == whole.size(), "a bound model is written as it was");
    const io::BoundModel back = io::readBoundModel(name, once);
    const auto again = written(name, [&](const auto& path) { io::writeBoundModel(path, back); });
    require(once == again, "what comes back is written the same");
});

}  // namespace
}  // namespace espalier::fuzz

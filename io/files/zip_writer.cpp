// SPDX-License-Identifier: Apache-2.0
#include "zip_writer.h"
#include "zip_format.h"

namespace espalier::io {
namespace {

constexpr std::uint16_t kVersion = 20, kZip64Version = 45;

/// 1 January 1980: files do not depend on when they are written.
constexpr std::uint16_t kNoTime = 0, kFirstDay = (1 << 5) | 1;

}  // namespace

ZipWriter::ZipWriter(std::ostream& out, Zip64 zip64)
    : out_(out, std::endian::little), zip64_(zip64) {}

bool ZipWriter::isLarge(std::uint64_t number) const {
    return zip64_ == Zip64::Always || number >= kZipAll32;
}

/// What a local header and an entry of the directory have in common.
void ZipWriter::common(const Member& member, bool isZip64, std::uint16_t extraSize) {
    out_.number(isZip64 ? kZip64Version : kVersion);
    out_.number(std::uint16_t{0});  // flags
    out_.number(kZipStored);
    out_.number(kNoTime);
    out_.number(kFirstDay);
    out_.number(member.checksum);
    const auto size = isLarge(member.size) ? kZipAll32 : static_cast<std::uint32_t>(member.size);
    out_.number(size);  // compressed
    out_.number(size);
    out_.number(static_cast<std::uint16_t>(member.name.size()));
    out_.number(extraSize);
}

void ZipWriter::add(const std::string& name, const std::function<void(ByteOutput&)>& write) {
    std::ostream nowhere(nullptr);
    ChecksummedOutput rehearsal(nowhere, std::endian::little);
    write(rehearsal);
    const Member member{name, rehearsal.count(), out_.count(), rehearsal.checksum()};

    const bool isZip64 = isLarge(member.size);
    out_.number(kZipLocalHeader);
    common(member, isZip64, isZip64 ? 20 : 0);
    out_.bytes(name);
    if (isZip64) {
        out_.number(kZip64Extra);
        out_.number(std::uint16_t{16});
        out_.number(member.size);
        out_.number(member.size);
    }
    write(out_);
    members_.push_back(member);
}

void ZipWriter::finish() {
    const std::uint64_t begin = out_.count();
    for (const Member& member : members_) {
        const bool hasSize = isLarge(member.size), hasPlace = isLarge(member.place);
        const auto extra = static_cast<std::uint16_t>((hasSize ? 16 : 0) + (hasPlace ? 8 : 0));
        const bool isZip64 = extra > 0;
        out_.number(kZipDirectoryEntry);
        out_.number(isZip64 ? kZip64Version : kVersion);  // made by
        common(member, isZip64, isZip64 ? static_cast<std::uint16_t>(extra + 4) : 0);
        out_.number(std::uint16_t{0});  // no comment
        out_.number(std::uint16_t{0});  // disk
        out_.number(std::uint16_t{0});  // attributes
        out_.number(std::uint32_t{0});
        out_.number(hasPlace ? kZipAll32 : static_cast<std::uint32_t>(member.place));
        out_.bytes(member.name);
        if (!isZip64) continue;
        out_.number(kZip64Extra);
        out_.number(extra);
        if (hasSize) {
            out_.number(member.size);
            out_.number(member.size);
        }
        if (hasPlace) out_.number(member.place);
    }
    const std::uint64_t end = out_.count(), size = end - begin, count = members_.size();
    const bool isZip64 = isLarge(begin) || isLarge(size) || count >= kZipAll16;
    if (isZip64) {
        out_.number(kZip64DirectoryEnd);
        out_.number(std::uint64_t{44});  // bytes that follow
        out_.number(kZip64Version);
        out_.number(kZip64Version);
        out_.number(std::uint32_t{0});  // disk
        out_.number(std::uint32_t{0});
        out_.number(count);
        out_.number(count);
        out_.number(size);
        out_.number(begin);
        out_.number(kZip64Locator);
        out_.number(std::uint32_t{0});
        out_.number(end);
        out_.number(std::uint32_t{1});  // disks
    }
    out_.number(kZipDirectoryEnd);
    out_.number(std::uint16_t{0});
    out_.number(std::uint16_t{0});
    const auto count16 = isZip64 ? kZipAll16 : static_cast<std::uint16_t>(count);
    out_.number(count16);
    out_.number(count16);
    out_.number(isZip64 ? kZipAll32 : static_cast<std::uint32_t>(size));
    out_.number(isZip64 ? kZipAll32 : static_cast<std::uint32_t>(begin));
    out_.number(std::uint16_t{0});  // no comment
}

}  // namespace espalier::io

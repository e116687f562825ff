// SPDX-License-Identifier: Apache-2.0
#include <zlib.h>

#include <algorithm>
#include <cstddef>
#include <optional>

#include "bytes.h"
#include "coding.h"
#include "zip.h"

namespace espalier::io {
namespace {

constexpr std::size_t kDirectoryEndSize = 22, kZip64DirectoryEndSize = 56, kZip64LocatorSize = 20;

ByteInput inputAt(std::string_view bytes) {
    return {bytes, std::endian::little};
}

/// Returns the bytes from this offset on. Throws if the archive is shorter.
std::string_view bytesFrom(std::string_view archive, std::uint64_t offset) {
    if (offset > archive.size())
        throw CodingError(concat("is damaged: it refers to byte ", offset, " of ", archive.size()));
    return archive.substr(offset);
}

/// Returns the offset of the last record, the end of the directory. Only a comment follows it.
std::size_t findDirectoryEnd(std::string_view archive) {
    if (archive.size() >= kDirectoryEndSize) {
        const std::size_t last = archive.size() - kDirectoryEndSize;
        const std::size_t first = last - std::min<std::size_t>(last, kZipAll16);
        for (std::size_t at = last + 1; at-- > first;) {
            ByteInput in = inputAt(archive.substr(at));
            if (in.number<std::uint32_t>() != kZipDirectoryEnd) continue;
            in.bytes(kDirectoryEndSize - sizeof(std::uint32_t) - sizeof(std::uint16_t));
            const auto commentSize = in.number<std::uint16_t>();
            if (commentSize == in.left()) return at;
        }
    }
    throw CodingError("is not a ZIP archive, or is cut off: the end of its directory is missing");
}

struct Directory {
    std::uint64_t count, size, offset;
};

/// Reads where the directory is from ZIP64's record. A locator before the end of the directory
/// leads to it; without a locator, returns nothing.
std::optional<Directory> findZip64Directory(std::string_view archive, std::size_t end) {
    if (end < kZip64LocatorSize) return std::nullopt;
    ByteInput locator = inputAt(archive.substr(end - kZip64LocatorSize));
    if (locator.number<std::uint32_t>() != kZip64Locator) return std::nullopt;
    locator.number<std::uint32_t>();  // disk
    ByteInput in = inputAt(bytesFrom(archive, locator.number<std::uint64_t>()));
    if (in.left() < kZip64DirectoryEndSize || in.number<std::uint32_t>() != kZip64DirectoryEnd)
        throw CodingError("is damaged: ZIP64's end of the directory is not where it should be");
    // Skips the size, two versions, two disk numbers, and the number of members on this disk.
    in.bytes(8 + 2 + 2 + 4 + 4 + 8);
    Directory directory{};
    for (std::uint64_t* number : {&directory.count, &directory.size, &directory.offset})
        *number = in.number<std::uint64_t>();
    return directory;
}

Directory findDirectory(std::string_view archive) {
    const std::size_t end = findDirectoryEnd(archive);
    ByteInput in = inputAt(archive.substr(end));
    // Skips the signature, two disk numbers, and the number of members on this disk.
    in.bytes(4 + 2 + 2 + 2);
    Directory directory{};
    directory.count = in.number<std::uint16_t>();
    directory.size = in.number<std::uint32_t>();
    directory.offset = in.number<std::uint32_t>();
    if (directory.count == kZipAll16 || directory.size == kZipAll32 ||
        directory.offset == kZipAll32)
        return findZip64Directory(archive, end).value_or(directory);
    return directory;
}

/// Replaces numbers that need more than 32 bits by the numbers in the extra field.
void widen(std::string_view extra, std::initializer_list<std::uint64_t*> numbers) {
    ByteInput in = inputAt(extra);
    // Fewer than 4 bytes at the end are padding, which some programs write.
    while (in.left() >= 4) {
        const auto kind = in.number<std::uint16_t>();
        ByteInput field = inputAt(in.bytes(in.number<std::uint16_t>()));
        if (kind != kZip64Extra) continue;
        for (std::uint64_t* number : numbers)
            if (*number == kZipAll32) *number = field.number<std::uint64_t>();
    }
}

constexpr std::uint16_t kVersion = 20, kZip64Version = 45;

/// 1 January 1980, so that the bytes of a file do not depend on when it is written.
constexpr std::uint16_t kNoTime = 0, kFirstDay = (1 << 5) | 1;

}  // namespace

ZipReader::ZipReader(std::string_view archive) : archive_(archive) {
    const Directory directory = findDirectory(archive);
    ByteInput in = inputAt(inputAt(bytesFrom(archive, directory.offset)).bytes(directory.size));
    // Overlapping members could make a small archive inflate to a huge size.
    std::uint64_t left = archive.size();
    for (std::uint64_t i = 0; i < directory.count; ++i) {
        std::string name;
        const Member member = readMember(in, name);
        if (member.compressedSize > left)
            throw CodingError("claims more bytes in its members than the file has");
        left -= member.compressedSize;
        if (!members_.emplace(std::move(name), member).second)
            throw CodingError("has two members of the same name");
    }
}

std::vector<std::string> ZipReader::names() const {
    std::vector<std::string> names;
    for (const auto& [name, member] : members_) names.push_back(name);
    return names;
}

ZipReader::Member ZipReader::readMember(ByteInput& in, std::string& name) {
    if (in.number<std::uint32_t>() != kZipDirectoryEntry)
        throw CodingError("is damaged: its directory cannot be read");
    Member member{};
    in.bytes(2 + 2);  // versions
    member.flags = in.number<std::uint16_t>();
    member.method = in.number<std::uint16_t>();
    in.bytes(2 + 2);  // time and date
    member.checksum = in.number<std::uint32_t>();
    member.compressedSize = in.number<std::uint32_t>();
    member.size = in.number<std::uint32_t>();
    const auto nameSize = in.number<std::uint16_t>();
    const auto extraSize = in.number<std::uint16_t>();
    const auto commentSize = in.number<std::uint16_t>();
    in.bytes(2 + 2 + 4);  // disk, attributes
    member.offset = in.number<std::uint32_t>();
    name = in.bytes(nameSize);
    widen(in.bytes(extraSize), {&member.size, &member.compressedSize, &member.offset});
    in.bytes(commentSize);
    return member;
}

/// Returns the compressed bytes of a member. The member's local header precedes them; its sizes may
/// be missing, so the directory's are used.
std::string_view ZipReader::compressedBytes(std::string_view name, const Member& member) const {
    ByteInput in = inputAt(bytesFrom(archive_, member.offset));
    if (in.number<std::uint32_t>() != kZipLocalHeader)
        throw CodingError("is damaged: it is not at the place that the directory names");
    in.bytes(5 * 2 + 3 * 4);  // as in the directory
    const auto nameSize = in.number<std::uint16_t>();
    const auto extraSize = in.number<std::uint16_t>();
    if (in.bytes(nameSize) != name)
        throw CodingError("is damaged: it has another name in the directory");
    in.bytes(extraSize);
    return in.bytes(member.compressedSize);
}

const ZipReader::Member& ZipReader::member(std::string_view name) const {
    const auto found = members_.find(name);
    if (found == members_.end()) throw CodingError("is not in the archive");
    return found->second;
}

std::uint64_t ZipReader::size(std::string_view name) const {
    return member(name).size;
}

std::string_view ZipReader::read(std::string_view name, std::string& room) const {
    const Member& member = this->member(name);
    constexpr std::uint16_t kEncrypted = 1;
    if ((member.flags & kEncrypted) != 0) throw CodingError("is encrypted");

    std::string_view bytes = compressedBytes(name, member);
    if (member.method == kZipDeflated) {
        room.clear();
        appendInflated(bytes, member.size, DeflateForm::Raw, room);
        bytes = room;
    } else if (member.method != kZipStored) {
        throw CodingError(concat("is compressed by method ", member.method,
                                 "; expected 8 (deflate) or 0 (none)"));
    }
    if (bytes.size() != member.size || crc32Of(bytes) != member.checksum)
        throw CodingError("is damaged: its checksum does not match");
    return bytes;
}

ZipWriter::ZipWriter(std::ostream& out, Zip64 zip64)
    : out_(out, std::endian::little), zip64_(zip64) {}

bool ZipWriter::isLarge(std::uint64_t number) const {
    return zip64_ == Zip64::Always || number >= kZipAll32;
}

/// Writes the fields that a local header and an entry of the directory share.
void ZipWriter::writeSharedFields(const Member& member, bool isZip64, std::uint16_t extraSize) {
    constexpr std::uint16_t kFlags = 0;
    const auto size = isLarge(member.size) ? kZipAll32 : static_cast<std::uint32_t>(member.size);
    const auto compressedSize = size;
    out_.number(isZip64 ? kZip64Version : kVersion, kFlags, kZipStored, kNoTime, kFirstDay,
                member.checksum, compressedSize, size,
                static_cast<std::uint16_t>(member.name.size()), extraSize);
}

void ZipWriter::add(const std::string& name, const std::function<void(ByteOutput&)>& write) {
    std::ostream nowhere(nullptr);
    ChecksummedOutput rehearsal(nowhere, std::endian::little);
    write(rehearsal);
    const Member member{name, rehearsal.count(), out_.count(), rehearsal.checksum()};

    const bool isZip64 = isLarge(member.size);
    out_.number(kZipLocalHeader);
    writeSharedFields(member, isZip64, isZip64 ? 20 : 0);
    out_.bytes(name);
    if (isZip64) out_.number(kZip64Extra, std::uint16_t{16}, member.size, member.size);
    write(out_);
    members_.push_back(member);
}

void ZipWriter::finish() {
    constexpr std::uint16_t kNoComment = 0, kDisk = 0, kAttributes = 0;
    constexpr std::uint32_t kWideDisk = 0, kWideAttributes = 0, kDiskCount = 1;
    const std::uint64_t begin = out_.count();
    for (const Member& member : members_) {
        const bool hasSize = isLarge(member.size), hasOffset = isLarge(member.offset);
        const auto extra = static_cast<std::uint16_t>((hasSize ? 16 : 0) + (hasOffset ? 8 : 0));
        const bool isZip64 = extra > 0;
        const std::uint16_t madeBy = isZip64 ? kZip64Version : kVersion;
        out_.number(kZipDirectoryEntry, madeBy);
        writeSharedFields(member, isZip64, isZip64 ? static_cast<std::uint16_t>(extra + 4) : 0);
        out_.number(kNoComment, kDisk, kAttributes, kWideAttributes,
                    hasOffset ? kZipAll32 : static_cast<std::uint32_t>(member.offset));
        out_.bytes(member.name);
        if (isZip64) out_.number(kZip64Extra, extra);
        if (hasSize) out_.number(member.size, member.size);
        if (hasOffset) out_.number(member.offset);
    }
    const std::uint64_t end = out_.count(), size = end - begin, count = members_.size();
    const bool isZip64 = isLarge(begin) || isLarge(size) || count >= kZipAll16;
    if (isZip64) {
        constexpr std::uint64_t kBytesThatFollow = 44;
        out_.number(kZip64DirectoryEnd, kBytesThatFollow, kZip64Version, kZip64Version, kWideDisk,
                    kWideDisk, count, count, size, begin);
        out_.number(kZip64Locator, kWideDisk, end, kDiskCount);
    }
    const auto count16 = isZip64 ? kZipAll16 : static_cast<std::uint16_t>(count);
    out_.number(kZipDirectoryEnd, kDisk, kDisk, count16, count16,
                isZip64 ? kZipAll32 : static_cast<std::uint32_t>(size),
                isZip64 ? kZipAll32 : static_cast<std::uint32_t>(begin), kNoComment);
}

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "bytes.h"

// Reads and writes ZIP archives, as PKWARE's application note describes them (version 6.3.9).

namespace espalier::io {

// Signatures at the beginning of records.
inline constexpr std::uint32_t kZipLocalHeader = 0x04034b50, kZipDirectoryEntry = 0x02014b50,
                               kZipDirectoryEnd = 0x06054b50, kZip64DirectoryEnd = 0x06064b50,
                               kZip64Locator = 0x07064b50;

/// The extra field with the numbers that take more than 32 bits.
inline constexpr std::uint16_t kZip64Extra = 1;

// Values of 32- and 16-bit fields whose number is in the extra field or in ZIP64's record instead.
inline constexpr std::uint32_t kZipAll32 = std::numeric_limits<std::uint32_t>::max();
inline constexpr std::uint16_t kZipAll16 = std::numeric_limits<std::uint16_t>::max();

// Compression methods of a member.
inline constexpr std::uint16_t kZipStored = 0, kZipDeflated = 8;

class ByteInput;

/// Reads the members of a ZIP archive by its central directory. Members may be stored or deflated,
/// and ZIP64 is supported. The archive must be a single file, not encrypted, with nothing before
/// it.
class ZipReader {
public:
    /// \param archive must outlive the reader and the bytes that read() returns
    /// \throws CodingError if it is no archive, or if its directory is damaged, has duplicate names
    ///         or claims more compressed bytes than the archive has
    explicit ZipReader(std::string_view archive);

    /// Returns the names of all members, in ascending order.
    std::vector<std::string> names() const;

    /// Returns the size that the directory claims for a member; nothing is inflated.
    /// \throws CodingError if there is no such member
    std::uint64_t size(std::string_view name) const;

    /// Returns the bytes of a member.
    /// \param room receives the bytes if they must be inflated; must outlive the result
    /// \throws CodingError if there is no such member, its checksum is wrong, or it has another
    ///         compression; before memory is allocated, if it claims more bytes than it can have
    std::string_view read(std::string_view name, std::string& room) const;

private:
    struct Member {
        std::uint16_t flags, method;
        std::uint32_t checksum;
        std::uint64_t compressedSize, size, offset;
    };

    const Member& member(std::string_view name) const;
    static Member readMember(ByteInput& in, std::string& name);
    std::string_view compressedBytes(std::string_view name, const Member& member) const;

    std::string_view archive_;
    std::map<std::string, Member, std::less<>> members_;
};

/// Writes a ZIP archive of members that are not compressed. ZIP64's fields are written where a size
/// or an offset needs more than 32 bits.
class ZipWriter {
public:
    /// Tells when ZIP64's fields are written.
    enum class Zip64 { AsNeeded, Always };

    explicit ZipWriter(std::ostream& out, Zip64 zip64 = Zip64::AsNeeded);

    /// Adds a member.
    /// \param name in ASCII
    /// \param write writes the bytes of the member; called twice, because the checksum precedes the
    ///        bytes, and must write the same bytes both times
    void add(const std::string& name, const std::function<void(ByteOutput&)>& write);

    /// Writes the directory. Must be the last call.
    void finish();

private:
    struct Member {
        std::string name;
        std::uint64_t size, offset;
        std::uint32_t checksum;
    };
    bool isLarge(std::uint64_t number) const;
    void writeSharedFields(const Member& member, bool isZip64, std::uint16_t extraSize);

    ByteOutput out_;
    Zip64 zip64_;
    std::vector<Member> members_;
};

}  // namespace espalier::io

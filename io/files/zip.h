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

// Numbers of the ZIP format, as PKWARE's application note has them (version 6.3.9).

namespace espalier::io {

// What the records begin with.
inline constexpr std::uint32_t kZipLocalHeader = 0x04034b50, kZipDirectoryEntry = 0x02014b50,
                               kZipDirectoryEnd = 0x06054b50, kZip64DirectoryEnd = 0x06064b50,
                               kZip64Locator = 0x07064b50;

/// The extra field with the numbers that take more than 32 bits.
inline constexpr std::uint16_t kZip64Extra = 1;

// What stands in place of such a number.
inline constexpr std::uint32_t kZipAll32 = std::numeric_limits<std::uint32_t>::max();
inline constexpr std::uint16_t kZipAll16 = std::numeric_limits<std::uint16_t>::max();

// How a member is compressed.
inline constexpr std::uint16_t kZipStored = 0, kZipDeflated = 8;

class ByteInput;

/// Reads a ZIP archive, as PKWARE's application note describes it (version 6.3.9), by its central
/// directory: members that are stored or deflated, with ZIP64's fields. It is one file, not
/// encrypted, with nothing before it.
class ZipReader {
public:
    /// \param archive must outlive the reader, and what is read
    /// \throws CodingError if it is no archive, or if its directory is damaged, has a name twice or
    ///         claims more compressed bytes than there are
    explicit ZipReader(std::string_view archive);

    /// The number of bytes of a member that the directory claims; nothing is inflated.
    /// \throws CodingError if there is no such member
    std::uint64_t size(std::string_view name) const;

    /// The bytes of a member.
    /// \param room where they are, if they are not as such in the archive
    /// \throws CodingError if there is no such member, if it is damaged (by its checksum), or coded
    ///         in another way; before memory is taken, if it claims more than there is
    std::string_view read(std::string_view name, std::string& room) const;

private:
    struct Member {
        std::uint16_t flags, method;
        std::uint32_t checksum;
        std::uint64_t compressedSize, size, place;
    };

    const Member& member(std::string_view name) const;
    static Member readMember(ByteInput& in, std::string& name);
    std::string_view compressedBytes(std::string_view name, const Member& member) const;

    std::string_view archive_;
    std::map<std::string, Member, std::less<>> members_;
};

/// Writes a ZIP archive of members that are not compressed, as PKWARE's application note describes
/// (version 6.3.9): with ZIP64's fields where a size or a place takes more than 32 bits.
class ZipWriter {
public:
    /// When ZIP64's fields are written.
    enum class Zip64 { AsNeeded, Always };

    explicit ZipWriter(std::ostream& out, Zip64 zip64 = Zip64::AsNeeded);

    /// Adds a member.
    /// \param name in ASCII
    /// \param write writes its bytes; called twice, for the checksum goes before them, and must
    ///        write the same
    void add(const std::string& name, const std::function<void(ByteOutput&)>& write);

    /// Writes the directory; last of all.
    void finish();

private:
    struct Member {
        std::string name;
        std::uint64_t size, place;
        std::uint32_t checksum;
    };
    bool isLarge(std::uint64_t number) const;
    void common(const Member& member, bool isZip64, std::uint16_t extraSize);

    ByteOutput out_;
    Zip64 zip64_;
    std::vector<Member> members_;
};

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>

namespace espalier::io {

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

}  // namespace espalier::io

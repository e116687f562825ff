// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "byte_output.h"

#include <cstdint>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

namespace espalier::io {

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

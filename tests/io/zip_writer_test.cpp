// SPDX-License-Identifier: Apache-2.0
#include <io/model_files.h>
#include "io/files/zip.h"

#include <cstdlib>

namespace espalier::io {
namespace {

const std::vector<std::pair<std::string, std::string>> kMembers = {
    {"a.npy", "some bytes"}, {"empty", ""}, {"b.npy", std::string(100'000, 'b')}};

void writeZip(const std::filesystem::path& path, ZipWriter::Zip64 zip64) {
    writeFile(path, [&](std::ostream& stream) {
        ZipWriter zip(stream, zip64);
        for (const auto& [name, bytes] : kMembers)
            zip.add(name, [&bytes = bytes](ByteOutput& out) { out.bytes(bytes); });
        zip.finish();
    });
}

// By Python's zipfile, which checks the sums; ZIP64's fields as of archives of 4 GB.
TEST(ZipWriter, IsReadByAnother) {
    for (const auto zip64 : {ZipWriter::Zip64::AsNeeded, ZipWriter::Zip64::Always}) {
        const test::TemporaryFolder folder;
        writeZip(folder / "a.zip", zip64);
        const std::string command = "/usr/bin/python3 -m zipfile -e '" +
                                    (folder / "a.zip").string() + "' '" +
                                    (folder / "out").string() + "'";
        ASSERT_EQ(std::system(command.c_str()), 0);
        for (const auto& [name, bytes] : kMembers)
            EXPECT_EQ(readFile(folder / "out" / name), bytes) << name;
    }
}

// The same members give the same file, whenever it is written.
TEST(ZipWriter, DependsOnTheMembersOnly) {
    const test::TemporaryFolder folder;
    writeZip(folder / "a.zip", ZipWriter::Zip64::AsNeeded);
    writeZip(folder / "b.zip", ZipWriter::Zip64::AsNeeded);
    const std::string bytes = readFile(folder / "a.zip");
    EXPECT_EQ(bytes, readFile(folder / "b.zip"));
    // Local headers of 30 bytes and entries of 46, with the names; and the end.
    EXPECT_EQ(bytes.size(), 3 * (30 + 46) + 2 * 15 + 100'010 + 22);
}

}  // namespace
}  // namespace espalier::io

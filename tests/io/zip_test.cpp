// SPDX-License-Identifier: Apache-2.0
#include "io/files/zip.h"
#include <io/matrix_samples.h>
#include <io/model_files.h>
#include "io/files/bytes.h"

#include <cstdlib>
#include <sstream>

namespace espalier::io {
namespace {

/// Returns an archive with two members, "first" and "2".
std::string archive(ZipWriter::Zip64 zip64 = ZipWriter::Zip64::AsNeeded) {
    std::ostringstream stream;
    ZipWriter zip(stream, zip64);
    zip.add("first", [](ByteOutput& out) { out.bytes("some bytes"); });
    zip.add("2", [](ByteOutput& out) { out.bytes("others"); });
    zip.finish();
    return stream.str();
}

std::string read(std::string_view bytes, std::string_view name) {
    std::string room;
    return std::string(ZipReader(bytes).read(name, room));
}

template <class Number>
std::string changed(std::string bytes, std::size_t at, Number number) {
    return bytes.replace(at, sizeof number, bytesOf(number, std::endian::little));
}

void expectArchiveRefused(std::string_view bytes, const std::string& why) {
    EXPECT_REFUSED(CodingError, why, read(bytes, "first"));
}

// Offsets of fields in the directory's entry of "first", and in the record at the end of the
// directory (PKWARE's application note, 4.3.12 and 4.3.16).
constexpr std::size_t kFlags = 8, kMethod = 10, kChecksum = 16, kCompressedSize = 20, kSize = 24,
                      kExtraSize = 30, kCommentSize = 32, kPlace = 42, kName = 46;
constexpr std::size_t kCount = 10, kDirectorySize = 12, kDirectoryPlace = 16;

std::size_t entryIn(std::string_view bytes) {
    return bytes.find(bytesOf(kZipDirectoryEntry, std::endian::little));
}
std::size_t endIn(std::string_view bytes) {
    return bytes.rfind(bytesOf(kZipDirectoryEnd, std::endian::little));
}

TEST(ZipReader, RoundTripIsExact) {
    for (const auto zip64 : {ZipWriter::Zip64::AsNeeded, ZipWriter::Zip64::Always}) {
        const std::string bytes = archive(zip64);
        EXPECT_EQ(read(bytes, "first"), "some bytes");
        EXPECT_EQ(read(bytes, "2"), "others");
        EXPECT_REFUSED(CodingError, "is not in the archive", read(bytes, "no"));
    }
    std::ostringstream nothing;
    ZipWriter(nothing).finish();
    expectArchiveRefused(nothing.str(), "is not in the archive");
}

TEST(ZipReader, ReadsArchivesOfPython) {
    const std::string bytes = readFile(matrixFolder() / "scipy-compressed.npz");
    const std::string format = read(bytes, "format.npy");
    EXPECT_EQ(format.size(), 131);
    EXPECT_TRUE(format.ends_with("csr"));
}

TEST(ZipReader, AcceptsACommentAtTheEnd) {
    const std::string bytes = archive();
    const std::string said = changed(bytes, bytes.size() - 2, std::uint16_t{7});
    EXPECT_EQ(read(said + "comment", "2"), "others");
    expectArchiveRefused(said + "comments", "the end of its directory is missing");
    const std::string longest(65535, 'x');
    EXPECT_EQ(read(changed(bytes, bytes.size() - 2, std::uint16_t{65535}) + longest, "2"),
              "others");
}

TEST(ZipReader, SkipsExtraFieldsAndCommentsOfMembers) {
    const std::string plain = archive();
    const std::size_t entry = entryIn(plain), end = endIn(plain);
    // An extra field of another program, of 1 byte; two bytes of padding; and a comment.
    std::string bytes = changed(plain, entry + kExtraSize, std::uint16_t{7});
    bytes = changed(bytes, entry + kCommentSize, std::uint16_t{4});
    bytes = changed(bytes, end + kDirectorySize, std::uint32_t(end - entry + 11));
    bytes.insert(entry + kName + 5, std::string("UT\1\0x\0\0note", 11));
    EXPECT_EQ(read(bytes, "first"), "some bytes");
    EXPECT_EQ(read(bytes, "2"), "others");
    // A field like ZIP64's under another number is ignored.
    const std::string wide = archive(ZipWriter::Zip64::Always);
    expectArchiveRefused(changed(wide, entryIn(wide) + kName + 5, std::uint16_t{2}),
                         "more bytes in its members");
}

TEST(ZipReader, RefusesOtherMethodsAndEncryption) {
    const std::string bytes = archive();
    const std::size_t entry = entryIn(bytes);
    expectArchiveRefused(changed(bytes, entry + kFlags, std::uint16_t{1}), "is encrypted");
    expectArchiveRefused(changed(bytes, entry + kMethod, std::uint16_t{12}),
                         "method 12; expected 8");
    expectArchiveRefused(changed(bytes, entry + kMethod, kZipDeflated), "is damaged (zlib)");
    // The other member can still be read.
    EXPECT_EQ(read(changed(bytes, entry + kFlags, std::uint16_t{1}), "2"), "others");
}

TEST(ZipReader, RefusesDamage) {
    const std::string bytes = archive();
    const std::size_t entry = entryIn(bytes), end = endIn(bytes);
    expectArchiveRefused("", "is not a ZIP archive");
    expectArchiveRefused("%%MatrixMarket matrix coordinate real general", "is not a ZIP archive");
    expectArchiveRefused(changed(bytes, 0, std::uint32_t{0}),
                         "is not at the place that the directory names");
    expectArchiveRefused(changed(bytes, 30, 'F'), "has another name in the directory");
    expectArchiveRefused(changed(bytes, entry, std::uint32_t{0}), "its directory cannot be read");
    expectArchiveRefused(changed(bytes, entry + kName, 'F'), "is not in the archive");
    expectArchiveRefused(changed(bytes, entry + kChecksum, std::uint32_t{0}),
                         "checksum does not match");
    expectArchiveRefused(changed(bytes, bytes.find("some"), 'S'), "checksum does not match");
    expectArchiveRefused(changed(bytes, entry + kSize, std::uint32_t{9}),
                         "checksum does not match");
    expectArchiveRefused(changed(bytes, entry + kCompressedSize, std::uint32_t{9}),
                         "checksum does not match");
    expectArchiveRefused(changed(bytes, end + kCount, std::uint16_t{3}), "ends too early");
    expectArchiveRefused(changed(bytes, end + kDirectorySize, std::uint32_t{60}), "ends too early");
    expectArchiveRefused(changed(bytes, end + kCount, std::uint16_t{0}), "is not in the archive");
}

TEST(ZipReader, RefusesDuplicateNames) {
    std::ostringstream stream;
    ZipWriter zip(stream);
    for (int i = 0; i < 2; ++i) zip.add("first", [](ByteOutput& out) { out.bytes("x"); });
    zip.finish();
    expectArchiveRefused(stream.str(), "two members of the same name");
}

TEST(ZipReader, ChecksClaimedSizesAndOffsets) {
    const std::string bytes = archive();
    const std::size_t entry = entryIn(bytes), end = endIn(bytes);
    const auto size = std::uint32_t(bytes.size());
    expectArchiveRefused(changed(bytes, entry + kCompressedSize, size + 1),
                         "more bytes in its members");
    // The archive has this number of bytes, but not after the member's header.
    expectArchiveRefused(changed(bytes, entry + kCompressedSize, size - 10), "ends too early");
    expectArchiveRefused(changed(bytes, entry + kPlace, size + 1), "refers to byte");
    expectArchiveRefused(changed(bytes, entry + kPlace, size), "ends too early");
    expectArchiveRefused(changed(bytes, end + kDirectoryPlace, size + 1), "refers to byte");
    expectArchiveRefused(changed(bytes, end + kDirectorySize, size), "ends too early");
    // A bomb: 10 bytes cannot become 4 GB.
    const std::string deflated = changed(bytes, entry + kMethod, kZipDeflated);
    expectArchiveRefused(changed(deflated, entry + kSize, std::uint32_t{0xfffffffe}),
                         "10 compressed bytes claims to hold 4294967294");
    // The value says that the number is in ZIP64's field, but there is no such field.
    expectArchiveRefused(changed(bytes, entry + kPlace, kZipAll32), "refers to byte 4294967295");
    expectArchiveRefused(changed(bytes, end + kDirectoryPlace, kZipAll32),
                         "refers to byte 4294967295");
}

TEST(ZipReader, ChecksClaimedSizesOf64Bits) {
    constexpr auto kLargest = std::numeric_limits<std::uint64_t>::max();
    const std::string bytes = archive(ZipWriter::Zip64::Always);
    // The extra field of the entry has 4 bytes, then the size, the compressed size and the offset.
    const std::size_t extra = entryIn(bytes) + kName + 5 + 4;
    expectArchiveRefused(changed(bytes, extra, kLargest), "checksum does not match");
    expectArchiveRefused(changed(bytes, extra + 8, kLargest), "more bytes in its members");
    expectArchiveRefused(changed(bytes, extra + 16, kLargest),
                         "refers to byte 18446744073709551615");
    expectArchiveRefused(changed(bytes, extra - 2, std::uint16_t{16}), "ends too early");
    // ZIP64's end of the directory has 24 bytes, the count on this disk, and the total count.
    const std::size_t end = bytes.rfind(bytesOf(kZip64DirectoryEnd, std::endian::little));
    expectArchiveRefused(changed(bytes, end + 32, kLargest), "ends too early");
    expectArchiveRefused(changed(bytes, end + 40, kLargest),
                         "18446744073709551615 bytes are expected");
    expectArchiveRefused(changed(bytes, end + 48, kLargest), "refers to byte 18446744073709551615");
    const std::size_t locator = bytes.rfind(bytesOf(kZip64Locator, std::endian::little));
    expectArchiveRefused(changed(bytes, locator + 8, kLargest),
                         "refers to byte 18446744073709551615");
    expectArchiveRefused(changed(bytes, locator + 8, std::uint64_t{0}), "not where it should be");
}

// Members that share bytes could make a small archive inflate to a huge size.
TEST(ZipReader, RefusesOverlappingMembers) {
    std::ostringstream stream;
    ZipWriter zip(stream);
    zip.add("first", [](ByteOutput& out) { out.bytes(std::string(1000, 'x')); });
    zip.add("2", [](ByteOutput& out) { out.bytes("x"); });
    zip.finish();
    const std::string bytes = stream.str();
    const std::size_t second = bytes.rfind(bytesOf(kZipDirectoryEntry, std::endian::little));
    expectArchiveRefused(changed(bytes, second + kCompressedSize, std::uint32_t{1000}),
                         "more bytes in its members");
}

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

// Python's zipfile reads the archive and checks the checksums, also with the ZIP64 fields of
// archives above 4 GB.
TEST(ZipWriter, PythonReadsIt) {
    for (const auto zip64 : {ZipWriter::Zip64::AsNeeded, ZipWriter::Zip64::Always}) {
        const TemporaryFolder folder;
        writeZip(folder / "a.zip", zip64);
        const std::string command = "/usr/bin/python3 -m zipfile -e '" +
                                    (folder / "a.zip").string() + "' '" +
                                    (folder / "out").string() + "'";
        ASSERT_EQ(std::system(command.c_str()), 0);
        for (const auto& [name, bytes] : kMembers)
            EXPECT_EQ(readFile(folder / "out" / name), bytes) << name;
    }
}

// The same members give the same bytes, whenever the file is written.
TEST(ZipWriter, OutputDependsOnlyOnTheMembers) {
    const TemporaryFolder folder;
    writeZip(folder / "a.zip", ZipWriter::Zip64::AsNeeded);
    writeZip(folder / "b.zip", ZipWriter::Zip64::AsNeeded);
    const std::string bytes = readFile(folder / "a.zip");
    EXPECT_EQ(bytes, readFile(folder / "b.zip"));
    // Local headers have 30 bytes and entries 46, each with a name; the end has 22.
    EXPECT_EQ(bytes.size(), 3 * (30 + 46) + 2 * 15 + 100'010 + 22);
}

}  // namespace
}  // namespace espalier::io

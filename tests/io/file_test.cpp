// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/file.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <ostream>

#include "support/temporary_folder.h"

namespace espalier::io {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

std::size_t fileCount(const fs::path& folder) {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST(WriteFile, ReplacesTheFileWhenAllIsWritten) {
    const test::TemporaryFolder folder;
    const fs::path path = folder / "a.txt";
    writeFile(path, [](std::ostream& out) { out << "old"; });
    writeFile(path, [&](std::ostream& out) {
        out << "new";
        out.flush();
        EXPECT_EQ(readFile(path), "old") << "until the end";
    });
    EXPECT_EQ(readFile(path), "new");
    EXPECT_EQ(fileCount(folder.path()), 1u);
}

TEST(WriteFile, FailureLeavesTheOldFileAndNothingElse) {
    const test::TemporaryFolder folder;
    const fs::path path = folder / "a.txt";
    writeFile(path, [](std::ostream& out) { out << "old"; });
    EXPECT_THROW(writeFile(path,
                           [](std::ostream& out) {
                               out << "half";
                               throw std::runtime_error("no more");
                           }),
                 std::runtime_error);
    EXPECT_THROW(writeFile(path, [](std::ostream& out) { out.setstate(std::ios::badbit); }),
                 FileError);
    EXPECT_EQ(readFile(path), "old");
    EXPECT_EQ(fileCount(folder.path()), 1u);
}

TEST(WriteFile, KeepsLinksAndModes) {
    const test::TemporaryFolder folder;
    writeFile(folder / "a.txt", [](std::ostream& out) { out << "old"; });
    fs::permissions(folder / "a.txt", fs::perms::owner_read | fs::perms::owner_write);
    fs::create_symlink("a.txt", folder / "link.txt");
    writeFile(folder / "link.txt", [](std::ostream& out) { out << "new"; });
    EXPECT_TRUE(fs::is_symlink(folder / "link.txt"));
    EXPECT_EQ(readFile(folder / "a.txt"), "new");
    EXPECT_EQ(fs::status(folder / "a.txt").permissions(),
              fs::perms::owner_read | fs::perms::owner_write);
}

TEST(WriteFile, DevicesStayDevices) {
    writeFile("/dev/null", [](std::ostream& out) { out << "gone"; });
    EXPECT_TRUE(fs::is_character_file("/dev/null"));
    try {
        writeFile("/dev/full", [](std::ostream& out) { out << std::string(1 << 20, 'x'); });
        FAIL() << "written to a full disk";
    } catch (const FileError& error) {
        EXPECT_THAT(error.what(), HasSubstr("/dev/full: cannot write: No space left"));
    }
}

TEST(WriteFile, PlacesThatCannotBeWrittenAreNamed) {
    const test::TemporaryFolder folder;
    const auto expectRefused = [](const fs::path& path, const std::string& why) {
        try {
            writeFile(path, [](std::ostream&) {});
            FAIL() << "written";
        } catch (const FileError& error) {
            EXPECT_THAT(error.what(), HasSubstr(path.string() + ": " + why));
        }
    };
    expectRefused(folder / "none/a.txt", "cannot create a file beside it: No such file");
    expectRefused(folder.path(), "is a directory");
}

TEST(ReadFile, NamesWhatCannotBeRead) {
    const test::TemporaryFolder folder;
    EXPECT_THROW(readFile(folder / "none"), FileError);
    EXPECT_THROW(readFile(folder.path()), FileError);
    std::ofstream(folder / "zero", std::ios::binary) << std::string(100000, '\0');
    EXPECT_EQ(readFile(folder / "zero"), std::string(100000, '\0'));
}

}  // namespace
}  // namespace espalier::io

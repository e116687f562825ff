// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/progress.h>
#include <espalier/io/files/file.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <ostream>
#include <thread>

#include "support/folder_contents.h"
#include "support/temporary_folder.h"
#include "support/test.h"

namespace espalier::io {
namespace {

namespace fs = std::filesystem;

std::size_t fileCount(const fs::path& folder) {
    return std::size_t(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST(WriteFile, ReplacesTheFileAfterWritingEverything) {
    const TemporaryFolder folder;
    const fs::path path = folder / "a.txt";
    writeFile(path, [](std::ostream& out) { out << "old"; });
    writeFile(path, [&](std::ostream& out) {
        out << "new";
        out.flush();
        EXPECT_EQ(readFile(path), "old") << "until the end";
        EXPECT_EQ(fileCount(folder.path()), 1u) << "the new one has no name until then";
    });
    EXPECT_EQ(readFile(path), "new");
    EXPECT_EQ(fileCount(folder.path()), 1u);
}

TEST(WriteFile, FailureLeavesTheOldFileAndNothingElse) {
    const TemporaryFolder folder;
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

// A stream catches what its buffer throws, and would go on without a word.
TEST(WriteFile, CanBeCancelledWithinALargeBlock) {
    const TemporaryFolder folder;
    const fs::path path = folder / "a.txt";
    writeFile(path, [](std::ostream& out) { out << "old"; });
    const std::string block(8 << 20, 'x');
    int calls = 0;
    const auto write = [&](int allowed) {
        calls = 0;
        const ProgressScope scope([&](const Progress&) { return calls++ < allowed; },
                                  std::chrono::milliseconds(0));
        writeFile(path, [&](std::ostream& out) { out << block; });
    };
    EXPECT_THROW(write(3), Cancelled);
    EXPECT_EQ(calls, 4);
    EXPECT_EQ(readFile(path), "old");
    EXPECT_EQ(fileCount(folder.path()), 1u);
    write(100);
    EXPECT_GE(calls, 8);  // megabytes
    EXPECT_EQ(readFile(path).size(), block.size());
}

TEST(WriteFile, KeepsLinksAndModes) {
    const TemporaryFolder folder;
    writeFile(folder / "a.txt", [](std::ostream& out) { out << "old"; });
    fs::permissions(folder / "a.txt", fs::perms::owner_read | fs::perms::owner_write);
    fs::create_symlink("a.txt", folder / "link.txt");
    writeFile(folder / "link.txt", [](std::ostream& out) { out << "new"; });
    EXPECT_TRUE(fs::is_symlink(folder / "link.txt"));
    EXPECT_EQ(readFile(folder / "a.txt"), "new");
    EXPECT_EQ(fs::status(folder / "a.txt").permissions(),
              fs::perms::owner_read | fs::perms::owner_write);
}

TEST(WriteFile, DanglingLinksLeadToTheNewFile) {
    const TemporaryFolder folder;
    fs::create_directory(folder / "sub");
    fs::create_symlink("sub/second", folder / "first");
    fs::create_symlink("a.txt", folder / "sub/second");
    writeFile(folder / "first", [](std::ostream& out) { out << "new"; });
    EXPECT_TRUE(fs::is_symlink(folder / "first"));
    EXPECT_TRUE(fs::is_symlink(folder / "sub/second"));
    EXPECT_EQ(readFile(folder / "sub/a.txt"), "new");

    fs::create_symlink("loop", folder / "loop");
    EXPECT_REFUSED(FileError, "loop: cannot write: Too many levels",
                   writeFile(folder / "loop", [](std::ostream&) {}));
}

TEST(WriteFile, NewFilesFollowTheUmask) {
    const TemporaryFolder folder;
    const ::mode_t old = ::umask(027);
    writeFile(folder / "a.txt", [](std::ostream& out) { out << "new"; });
    ::umask(old);
    EXPECT_EQ(int(fs::status(folder / "a.txt").permissions()), 0640);
}

TEST(WriteFile, AcceptsNamesOfMaximalLength) {
    const TemporaryFolder folder;
    const fs::path path = folder / std::string(255, 'n');
    writeFile(path, [](std::ostream& out) { out << "new"; });
    EXPECT_EQ(readFile(path), "new");
}

/// While it lives, a process that runs as root acts as an unprivileged user.
class AsNobody {
public:
    AsNobody() {
        if (::geteuid() != 0) return;
        EXPECT_EQ(::setegid(65534), 0);
        EXPECT_EQ(::seteuid(65534), 0);
    }
    ~AsNobody() {
        if (::getuid() != 0) return;
        EXPECT_EQ(::seteuid(0), 0);
        EXPECT_EQ(::setegid(::getgid()), 0);
    }
    AsNobody(const AsNobody&) = delete;
    AsNobody& operator=(const AsNobody&) = delete;
};

TEST(WriteFile, KeepsTheOwnerIfPermitted) {
    if (::getuid() != 0) GTEST_SKIP() << "only root may give files away";
    const TemporaryFolder folder;
    writeFile(folder / "a.txt", [](std::ostream& out) { out << "old"; });
    ASSERT_EQ(::chown((folder / "a.txt").c_str(), 65534, 65533), 0);
    fs::permissions(folder / "a.txt", fs::perms::owner_read | fs::perms::set_uid);
    writeFile(folder / "a.txt", [](std::ostream& out) { out << "new"; });
    struct stat status {};
    ASSERT_EQ(::stat((folder / "a.txt").c_str(), &status), 0);
    EXPECT_EQ(status.st_uid, 65534u);
    EXPECT_EQ(status.st_gid, 65533u);
    EXPECT_EQ(status.st_mode & 07777, 04400u);
    EXPECT_EQ(readFile(folder / "a.txt"), "new");
}

// A setuid file must not get another owner.
TEST(WriteFile, RightsOfTheOldOwnerAreNotGivenToAnother) {
    if (::getuid() != 0) GTEST_SKIP() << "only root has files of others";
    const TemporaryFolder folder;
    fs::permissions(folder.path(), fs::perms::all);
    writeFile(folder / "a.txt", [](std::ostream& out) { out << "old"; });
    ASSERT_EQ(::chown((folder / "a.txt").c_str(), 0, 65533), 0);
    fs::permissions(folder / "a.txt", static_cast<fs::perms>(06776));
    const AsNobody nobody;
    writeFile(folder / "a.txt", [](std::ostream& out) { out << "new"; });
    struct stat status {};
    ASSERT_EQ(::stat((folder / "a.txt").c_str(), &status), 0);
    EXPECT_EQ(status.st_uid, 65534u);
    EXPECT_EQ(status.st_mode & 07777, 0766u) << "to the group what is for all";
}

TEST(WriteFile, ReadOnlyFilesAndFoldersAreRefusedFirst) {
    const TemporaryFolder folder;
    fs::permissions(folder.path(), fs::perms::all);
    writeFile(folder / "a.txt", [](std::ostream& out) { out << "old"; });
    fs::permissions(folder / "a.txt", static_cast<fs::perms>(0444));
    fs::create_symlink("a.txt", folder / "link");
    fs::create_directory(folder / "sub");
    fs::permissions(folder / "sub", static_cast<fs::perms>(0555));
    const auto before = contentsOf(folder.path());
    const auto expectRefused = [&](const std::string& name, const std::string& cause) {
        const fs::path path = folder / name;
        const AsNobody nobody;
        const auto message = path.string() + ": " + cause + ": Permission denied";
        EXPECT_THAT([&] { checkWritable(path); }, ThrowsMessage<FileError>(message));
        EXPECT_THAT(
            [&] { writeFile(path, [](std::ostream&) { ADD_FAILURE() << "is asked to write"; }); },
            ThrowsMessage<FileError>(message));
        EXPECT_THAT(
            [&] {
                writeFiles({{"/dev/null", [](std::ostream&) { ADD_FAILURE() << "the first is"; }},
                            {path, [](std::ostream&) {}}});
            },
            ThrowsMessage<FileError>(message));
    };
    expectRefused("a.txt", "cannot write");
    expectRefused("link", "cannot write");
    expectRefused("sub/a.txt", "cannot create a file beside it");
    EXPECT_EQ(contentsOf(folder.path()), before);
    EXPECT_EQ(int(fs::status(folder / "a.txt").permissions()), 0444);
}

TEST(WriteFile, WritesAtThePositionOfOpenDescriptors) {
    const TemporaryFolder folder;
    const fs::path path = folder / "log.txt";
    const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0666);
    ASSERT_GE(file, 0);
    EXPECT_EQ(::write(file, "before ", 7), 7);
    const std::string name = "/dev/fd/" + std::to_string(file);
    checkWritable(name);
    writeFile(name, [](std::ostream& out) { out << "new "; });
    EXPECT_EQ(::write(file, "after", 5), 5);
    ::close(file);
    EXPECT_EQ(readFile(path), "before new after");
}

TEST(WriteFile, DevicesStayDevices) {
    writeFile("/dev/null", [](std::ostream& out) { out << "gone"; });
    EXPECT_TRUE(fs::is_character_file("/dev/null"));
    EXPECT_THAT(messageOf<FileError>([&] {
                    writeFile("/dev/full",
                              [](std::ostream& out) { out << std::string(1 << 20, 'x'); });
                }),
                HasSubstr("/dev/full: cannot write: No space left"));
}

TEST(WriteFile, ErrorsNameThePath) {
    const TemporaryFolder folder;
    const auto expectRefused = [](const fs::path& path, const std::string& why) {
        EXPECT_REFUSED(FileError, path.string() + ": " + why,
                       writeFile(path, [](std::ostream&) {}));
        EXPECT_THROW(checkWritable(path), FileError);
    };
    expectRefused(folder / "none/a.txt", "cannot create a file beside it: No such file");
    expectRefused(folder.path(), "is a directory");
}

TEST(ReadFile, ErrorsNameThePath) {
    const TemporaryFolder folder;
    EXPECT_THROW(readFile(folder / "none"), FileError);
    EXPECT_THROW(readFile(folder.path()), FileError);
    std::ofstream(folder / "zero", std::ios::binary) << std::string(100000, '\0');
    EXPECT_EQ(readFile(folder / "zero"), std::string(100000, '\0'));
}

TEST(ReadFile, ErrorsGiveTheSystemsReason) {
    const TemporaryFolder folder;
    const auto expectRefused = [](const fs::path& path, const std::string& cause) {
        EXPECT_THAT([&] { readFile(path); },
                    ThrowsMessage<FileError>(path.string() + ": " + cause));
    };
    expectRefused(folder / "none", "cannot open: No such file or directory");
    expectRefused(folder / "none/a.txt", "cannot open: No such file or directory");
    expectRefused(folder.path(), "is a directory");
    expectRefused("/proc/self/mem", "cannot read: Input/output error");
    writeFile(folder / "a.txt", [](std::ostream& out) { out << "secret"; });
    fs::permissions(folder / "a.txt", fs::perms::none);
    fs::permissions(folder.path(), fs::perms::all);
    const AsNobody nobody;
    expectRefused(folder / "a.txt", "cannot open: Permission denied");
}

/// readFile() reads blocks of 2^18 bytes, and asks for large pages from 2 MB on.
TEST(ReadFile, ReadsFilesOfAnySize) {
    const TemporaryFolder folder;
    for (const std::size_t size : {0, 1, (1 << 18) - 1, 1 << 18, (1 << 18) + 1, 5 << 20}) {
        std::string bytes(size, '\0');
        for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<char>(i * i >> 7);
        writeFile(folder / "a", [&](std::ostream& out) { out << bytes; });
        EXPECT_TRUE(readFile(folder / "a") == bytes) << size;
    }
}

TEST(ReadFile, ReadsPipesAndFilesOfUnknownSize) {
    EXPECT_THAT(readFile("/proc/self/status"), HasSubstr("VmPeak"));
    const TemporaryFolder folder;
    const fs::path pipe = folder / "pipe";
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    // Writes step by step, and more than a pipe can hold.
    std::thread writer([&] {
        writeFile(pipe, [](std::ostream& out) {
            for (int i = 0; i < 100; ++i) out << std::string(3000, 'p') << std::flush;
        });
    });
    EXPECT_EQ(readFile(pipe), std::string(300'000, 'p'));
    writer.join();
}

}  // namespace
}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#include <io/every_writer.h>
#include <sys/resource.h>

#include <csignal>

#include "support/folder_contents.h"

// Simulates a full disk by a limit on the size of files.
namespace espalier::io {
namespace {

namespace fs = std::filesystem;

/// Limits the size of files until destruction.
class SizeLimit {
public:
    explicit SizeLimit(std::size_t bytes) {
        ::getrlimit(RLIMIT_FSIZE, &old_);
        const ::rlimit limit{bytes, old_.rlim_max};
        ::setrlimit(RLIMIT_FSIZE, &limit);
    }
    ~SizeLimit() { ::setrlimit(RLIMIT_FSIZE, &old_); }
    SizeLimit(const SizeLimit&) = delete;
    SizeLimit& operator=(const SizeLimit&) = delete;

private:
    ::rlimit old_{};
};

std::size_t largestFile(const fs::path& folder) {
    std::size_t largest = 0;
    for (const auto& [name, bytes] : contentsOf(folder)) largest = std::max(largest, bytes.size());
    return largest;
}

/// Lets the disk become full `times` times, each time after more bytes of the writer's output.
void expectNothingLost(const Writer& writer, std::size_t times) {
    const TemporaryFolder folder;
    const fs::path path = folder / writer.name;
    writer.write(path);
    const std::size_t size = largestFile(folder.path());
    // Old files whose content differs from the new one.
    for (const auto& entry : fs::directory_iterator(folder.path()))
        putLatticeFile(entry.path(), "old");
    const auto before = contentsOf(folder.path());
    for (std::size_t i = 0; i < times; ++i) {
        const std::size_t room = i * size / times;
        const SizeLimit limit(room);
        EXPECT_THAT([&] { writer.write(path); },
                    ThrowsMessage<FileError>(AllOf(HasSubstr((folder.path() / "").string()),
                                                   HasSubstr(": cannot write: File too large"))))
            << writer.name << ", room for " << room;
        EXPECT_EQ(contentsOf(folder.path()), before) << writer.name << ", " << room;
    }
    const SizeLimit limit(size);  // just enough
    writer.write(path);
    EXPECT_NE(contentsOf(folder.path()), before);
}

// The signal that comes with the error would end the program. The library blocks it, and restores
// its action.
TEST(FullDisk, KeepsTheOldFilesOfEveryFormat) {
    for (const Writer& writer : everyWriter(3)) expectNothingLost(writer, 40);
    struct sigaction action {};
    ::sigaction(SIGXFSZ, nullptr, &action);
    EXPECT_EQ(action.sa_handler, SIG_DFL);
    sigset_t pending, blocked;
    ::sigpending(&pending);
    EXPECT_EQ(sigismember(&pending, SIGXFSZ), 0);
    pthread_sigmask(SIG_BLOCK, nullptr, &blocked);
    EXPECT_EQ(sigismember(&blocked, SIGXFSZ), 0);
}

// The files are longer than one block written to the system.
TEST(FullDisk, KeepsTheOldFilesIfItFillsUpLater) {
    for (const Writer& writer : everyWriter(2100)) expectNothingLost(writer, 5);
}

TEST(FullDisk, IsReportedAsTheCause) {
    for (const Writer& writer : everyWriter(3000)) {
        if (writer.name == "D.npy") continue;  // three files
        // The link needs the extension, which gives the format.
        const TemporaryFolder folder;
        fs::create_symlink("/dev/full", folder / writer.name);
        EXPECT_THAT([&] { writer.write(folder / writer.name); },
                    ThrowsMessage<FileError>((folder / writer.name).string() +
                                             ": cannot write: No space left on device"));
    }
}

}  // namespace
}  // namespace espalier::io

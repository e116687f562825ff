// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <fstream>
#include <optional>

#include "support/folder_contents.h"
#include "support/system_faults.h"
#include "support/temporary_folder.h"
#include "support/test.h"

// Makes single system calls fail, one after the other, while files are read and written.
namespace espalier::io {
namespace {

namespace fs = std::filesystem;
using testing::Not;
using Contents = std::map<std::string, std::string>;

/// A text that is longer than one block written to the system.
const std::string kText(200'000, 'x');

void writeText(std::ostream& out) {
    for (std::size_t i = 0; i < kText.size(); i += 1000) out << kText.substr(i, 1000);
}

void put(const fs::path& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
}

class WriteFaults : public testing::Test {
protected:
    WriteFaults() { put(path, "old"); }

    bool holdsOnly(const std::string& text) const {
        return contentsOf(folder.path()) == Contents{{"a.txt", text}};
    }

    /// Makes the n-th such call fail with this error, and returns the message of the exception;
    /// nothing if there is no n-th call.
    std::optional<std::string> errorOf(SystemCall call, int n, int error) {
        const SystemFault fault(call, n, error);
        try {
            writeFile(path, writeText);
        } catch (const FileError& thrown) {
            EXPECT_TRUE(fault.hasHappened());
            return thrown.what();
        }
        if (fault.hasHappened()) return "";
        return std::nullopt;
    }

    const TemporaryFolder folder;
    const fs::path path = folder / "a.txt";
};

TEST_F(WriteFaults, WriteErrorsLeaveTheOldFileAndAreNamed) {
    int n = 1;
    for (; const auto error = errorOf(SystemCall::Write, n, ENOSPC); ++n) {
        EXPECT_EQ(*error, path.string() + ": cannot write: No space left on device");
        EXPECT_TRUE(holdsOnly("old"));
    }
    EXPECT_GT(n, 2) << "writes";
    EXPECT_TRUE(holdsOnly(kText));
}

TEST_F(WriteFaults, ErrorsOfLinkAndRenameLeaveTheOldFile) {
    for (const SystemCall call : {SystemCall::Link, SystemCall::Rename}) {
        EXPECT_EQ(errorOf(call, 1, EIO), path.string() + ": cannot write: Input/output error");
        EXPECT_TRUE(holdsOnly("old"));
    }
    // The last call syncs the folder, after the new file is in its place.
    int syncs = 0;
    while (holdsOnly("old")) {
        const auto error = errorOf(SystemCall::Sync, ++syncs, EIO);
        ASSERT_TRUE(error);
        EXPECT_THAT(*error, AllOf(HasSubstr("a.txt: "), HasSubstr("Input/output error")));
    }
    EXPECT_GE(syncs, 2) << "of the file, and of the folder";
    EXPECT_TRUE(holdsOnly(kText));
}

TEST_F(WriteFaults, FolderThatCannotBeSyncedIsReportedAsWrittenButNotDurable) {
    std::string last;
    for (int n = 1; const auto error = errorOf(SystemCall::Sync, n, EIO); ++n) last = *error;
    EXPECT_EQ(last, path.string() +
                        ": is written, but may be lost if power fails now: Input/output error");
    // EINVAL is ignored: the file system cannot sync folders.
    int ignored = 0;
    for (int n = 1; const auto error = errorOf(SystemCall::Sync, n, EINVAL); ++n)
        if (error->empty()) ++ignored;
    EXPECT_EQ(ignored, 1);
}

TEST_F(WriteFaults, InterruptedCallsAreRepeated) {
    for (const SystemCall call : {SystemCall::Open, SystemCall::Write, SystemCall::Sync}) {
        int n = 1;
        for (; const auto error = errorOf(call, n, EINTR); ++n) {
            EXPECT_EQ(*error, "");
            EXPECT_TRUE(holdsOnly(kText));
            put(path, "old");
        }
        EXPECT_GT(n, 1);
    }
}

// NFS, for example, has no nameless files.
TEST_F(WriteFaults, FileSystemsWithoutNamelessFilesWork) {
    const SystemFault fault(SystemCall::Open, 1, EOPNOTSUPP);
    writeFile(path, [&](std::ostream& out) {
        EXPECT_EQ(contentsOf(folder.path()).size(), 2u) << "the new one has a name";
        writeText(out);
    });
    EXPECT_TRUE(fault.hasHappened());
    EXPECT_TRUE(holdsOnly(kText));
}

TEST_F(WriteFaults, FileSystemsWithoutNamelessFilesKeepTheOldFileOnError) {
    for (const SystemCall call : {SystemCall::Write, SystemCall::Sync, SystemCall::Rename}) {
        std::optional<SystemFault> second;
        const SystemFault first(SystemCall::Open, 1, [&] {
            second.emplace(call, 1, EIO);
            return EOPNOTSUPP;
        });
        EXPECT_THAT([&] { writeFile(path, writeText); },
                    ThrowsMessage<FileError>(path.string() + ": cannot write: Input/output error"));
        EXPECT_TRUE(holdsOnly("old"));
    }
}

// Users who may not read the old file cannot read the new one while it is written.
TEST_F(WriteFaults, NamedNewFileHasTheModeOfTheOldFile) {
    fs::permissions(path, fs::perms::owner_read | fs::perms::owner_write);
    const SystemFault fault(SystemCall::Open, 1, EOPNOTSUPP);
    writeFile(path, [&](std::ostream&) {
        for (const auto& entry : fs::directory_iterator(folder.path()))
            EXPECT_EQ(entry.status().permissions(), fs::perms::owner_read | fs::perms::owner_write);
    });
}

TEST_F(WriteFaults, ErrorNamesTheFilesThatAreAlreadyReplaced) {
    std::vector<FileToWrite> files;
    for (const std::string name : {"b", "c", "d"}) {
        put(folder / name, "old");
        files.push_back({folder / name, [=](std::ostream& out) { out << "new " << name; }});
    }
    const std::string cause = "cannot write: Input/output error";
    const auto expectError = [&](int n, const std::string& message) {
        const SystemFault fault(SystemCall::Rename, n, EIO);
        EXPECT_THAT([&] { writeFiles(files); }, ThrowsMessage<FileError>(message));
    };
    const auto name = [&](const char* file) { return (folder / file).string(); };
    expectError(1, name("b") + ": " + cause);
    EXPECT_EQ(contentsOf(folder.path()),
              (Contents{{"a.txt", "old"}, {"b", "old"}, {"c", "old"}, {"d", "old"}}));
    expectError(2, name("c") + ": " + cause + "; replaced before it: " + name("b"));
    EXPECT_EQ(contentsOf(folder.path()),
              (Contents{{"a.txt", "old"}, {"b", "new b"}, {"c", "old"}, {"d", "old"}}));
    put(folder / "b", "old");
    expectError(3,
                name("d") + ": " + cause + "; replaced before it: " + name("b") + ", " + name("c"));
    // Nothing is replaced before the first rename.
    for (const SystemCall call : {SystemCall::Write, SystemCall::Link}) {
        for (const std::string old : {"b", "c", "d"}) put(folder / old, "old");
        const SystemFault fault(call, 3, EIO);
        EXPECT_THAT([&] { writeFiles(files); }, ThrowsMessage<FileError>(name("d") + ": " + cause));
        EXPECT_EQ(contentsOf(folder.path()),
                  (Contents{{"a.txt", "old"}, {"b", "old"}, {"c", "old"}, {"d", "old"}}));
    }
}

TEST_F(WriteFaults, FolderRemovedWhileWritingIsAnError) {
    const fs::path lost = folder / "sub" / "a.txt";
    fs::create_directory(folder / "sub");
    EXPECT_THAT(
        [&] {
            writeFile(lost, [&](std::ostream& out) {
                fs::remove_all(folder / "sub");
                writeText(out);
            });
        },
        ThrowsMessage<FileError>(lost.string() + ": cannot write: No such file or directory"));
    EXPECT_TRUE(holdsOnly("old"));
}

/// Runs `work` in a child process, and expects that `signal` ends it.
template <class Work>
void expectKilled(int signal, Work work) {
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        work();
        ::_exit(1);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status));
    EXPECT_EQ(WTERMSIG(status), signal);
}

TEST_F(WriteFaults, SignalWhileWritingLeavesOnlyTheOldFile) {
    for (const int signal : {SIGINT, SIGTERM, SIGKILL, SIGHUP}) {
        expectKilled(signal, [&] {
            writeFile(path, [&](std::ostream& out) {
                writeText(out);
                ::raise(signal);
            });
        });
        EXPECT_TRUE(holdsOnly("old")) << signal;
    }
}

TEST_F(WriteFaults, SignalWhileSyncingLeavesOnlyTheOldFile) {
    expectKilled(SIGKILL, [&] {
        const SystemFault fault(SystemCall::Sync, 1, [] { return ::raise(SIGKILL); });
        writeFile(path, writeText);
    });
    EXPECT_TRUE(holdsOnly("old"));
}

// While the new file has a temporary name, signals are blocked; they are delivered after the
// rename.
TEST_F(WriteFaults, SignalsAreDelayedUntilAllFilesAreRenamed) {
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT})
        for (const SystemCall call : {SystemCall::Link, SystemCall::Sync, SystemCall::Rename})
            for (const int n : {1, 2, 3, 4}) {
                if (call != SystemCall::Sync && n > 2) continue;
                put(path, "old");
                expectKilled(signal, [&] {
                    const SystemFault fault(call, n, [&] { return ::raise(signal); });
                    writeFiles({{path, writeText}, {folder / "b.txt", writeText}});
                });
                const Contents after = contentsOf(folder.path());
                const Contents all = {{"a.txt", kText}, {"b.txt", kText}};
                // Before the files have names, a signal may end it at once.
                const bool isEarly = call == SystemCall::Sync && n <= 2;
                EXPECT_EQ(after, isEarly ? (Contents{{"a.txt", "old"}}) : all)
                    << signal << ", call " << int(call) << ", number " << n;
                fs::remove(folder / "b.txt");
            }
}

// A host may go on after a file could not be renamed.
TEST_F(WriteFaults, SignalsAreDeliveredAfterAFailedRename) {
    expectKilled(SIGTERM, [&] {
        const SystemFault fault(SystemCall::Rename, 1, [&] {
            ::raise(SIGTERM);
            return EIO;
        });
        try {
            writeFile(path, writeText);
        } catch (const FileError&) {
        }
    });
    EXPECT_TRUE(holdsOnly("old"));
}

// Without protection, SIGPIPE would end the program.
TEST_F(WriteFaults, PipeWithoutReaderIsAnError) {
    int ends[2] = {};
    ASSERT_EQ(::pipe(ends), 0);
    ::close(ends[0]);
    const std::string pipe = "/dev/fd/" + std::to_string(ends[1]);
    EXPECT_THAT([&] { writeFile(pipe, writeText); },
                ThrowsMessage<FileError>(pipe + ": cannot write: Broken pipe"));
    ::close(ends[1]);
}

class ReadFaults : public testing::Test {
protected:
    ReadFaults() { put(path, kText); }

    const TemporaryFolder folder;
    const fs::path path = folder / "a.txt";
};

TEST_F(ReadFaults, ErrorsAreNamedWithTheirCause) {
    for (int n = 1; n <= 2; ++n) {
        const SystemFault fault(SystemCall::Read, n, EIO);
        EXPECT_THAT([&] { readFile(path); },
                    ThrowsMessage<FileError>(path.string() + ": cannot read: Input/output error"));
    }
    const SystemFault fault(SystemCall::Open, 1, EMFILE);
    EXPECT_THAT([&] { readFile(path); },
                ThrowsMessage<FileError>(path.string() + ": cannot open: Too many open files"));
}

TEST_F(ReadFaults, InterruptedCallsAreRepeated) {
    for (const SystemCall call : {SystemCall::Open, SystemCall::Read}) {
        const SystemFault fault(call, 1, EINTR);
        EXPECT_EQ(readFile(path), kText);
        EXPECT_TRUE(fault.hasHappened());
    }
}

TEST_F(ReadFaults, FileThatChangesWhileItIsReadIsRefused) {
    const auto expectRefused = [&](auto change) {
        put(path, kText);
        const SystemFault fault(SystemCall::Read, 2, [&] {
            change();
            return 0;
        });
        EXPECT_THAT([&] { readFile(path); },
                    ThrowsMessage<FileError>(path.string() + ": has changed while it was read"));
    };
    expectRefused([&] { fs::resize_file(path, 0); });
    expectRefused([&] { fs::resize_file(path, 100'000); });
    expectRefused([&] { std::ofstream(path, std::ios::app) << "more"; });
}

TEST_F(ReadFaults, FileRemovedOrReplacedWhileItIsReadIsReadToItsEnd) {
    const SystemFault fault(SystemCall::Read, 1, [&] { return ::unlink(path.c_str()); });
    EXPECT_EQ(readFile(path), kText);
    EXPECT_FALSE(fs::exists(path));
}

}  // namespace
}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#include <dirent.h>
#include <espalier/base/array.h>
#include <espalier/base/memory.h>
#include <espalier/base/printable.h>
#include <espalier/base/progress.h>
#include <espalier/io/files/file.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <deque>
#include <memory>
#include <new>
#include <optional>
#include <ostream>
#include <string_view>
#include <system_error>

#include "descriptor.h"
#include "new_file.h"

namespace espalier::io {

namespace fs = std::filesystem;

std::string shownPath(const fs::path& path) {
    return printable(path.native());
}

FileError::FileError(const fs::path& path, const std::string& cause)
    : Error(shownPath(path) + ": " + printable(cause, cause.size())) {}

FileError::FileError(const fs::path& path, std::size_t line, const std::string& cause)
    : Error(concat(shownPath(path), ":", line, ": ", printable(cause, cause.size()))) {}

namespace {

[[noreturn]] void fail(const fs::path& path, const std::string& what, int error) {
    throw FileError(path, what + ": " + systemMessage(error));
}

struct ::stat statusOf(const fs::path& path, const Descriptor& file) {
    struct ::stat status {};
    if (::fstat(file.number(), &status) != 0) fail(path, "cannot read", errno);
    return status;
}

bool isSameTime(const ::timespec& a, const ::timespec& b) {
    return a.tv_sec == b.tv_sec && a.tv_nsec == b.tv_nsec;
}

/// Calls `write` with a stream to the file, and throws unless all of it was written.
void writeTo(int descriptor, const FileToWrite& toWrite) {
    DescriptorBuffer buffer(descriptor);
    std::ostream out(&buffer);
    toWrite.write(out);
    out.flush();
    buffer.rethrowCancelled();
    if (buffer.error() != 0) fail(toWrite.path, "cannot write", buffer.error());
    if (!out) throw FileError(toWrite.path, "cannot write: the stream has failed");
}

/// Calls `step`, and converts a std::system_error to a FileError for this file.
template <class Step>
void withFileErrors(const fs::path& path, const std::string& what, Step step) {
    try {
        step();
    } catch (const std::system_error& error) {
        throw FileError(path, what + ": " + error.code().message());
    }
}

void writeInPlace(const WriteTarget& to, const FileToWrite& toWrite) {
    const Descriptor file(uninterrupted([&] {
        return to.kind == WriteTarget::Kind::Descriptor
                   ? ::fcntl(to.descriptor, F_DUPFD_CLOEXEC, 0)
                   : ::open(to.path.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY);
    }));
    if (!file) fail(toWrite.path, "cannot write", errno);
    writeTo(file.number(), toWrite);
}

/// A file to write, and the new file that will replace it.
struct WrittenFile {
    WrittenFile(const FileToWrite& what, const fs::path& target) : toWrite(what), file(target) {}

    const FileToWrite& toWrite;
    NewFile file;
};

void moveToTargets(std::deque<WrittenFile>& written) {
    for (std::size_t i = 0; i < written.size(); ++i) {
        try {
            written[i].file.moveToTarget();
        } catch (const std::system_error& error) {
            std::string replaced;
            for (std::size_t j = 0; j < i; ++j)
                replaced +=
                    (j == 0 ? "; replaced before it: " : ", ") + shownPath(written[j].toWrite.path);
            throw FileError(written[i].toWrite.path,
                            "cannot write: " + error.code().message() + replaced);
        }
    }
}

}  // namespace

std::vector<std::string> namesIn(const std::filesystem::path& folder) {
    errno = 0;
    const std::unique_ptr<DIR, int (*)(DIR*)> open(opendir(folder.c_str()),
                                                   [](DIR* each) { return closedir(each); });
    if (errno == ENOMEM) throw std::bad_alloc();
    std::vector<std::string> names;
    if (!open) return names;
    while (const dirent* entry = readdir(open.get()))
        if (const std::string_view name = entry->d_name; name != "." && name != "..")
            names.emplace_back(name);
    std::ranges::sort(names);
    return names;
}

std::string readFile(const fs::path& path) {
    const Descriptor file(
        uninterrupted([&] { return ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY); }));
    if (!file) fail(path, "cannot open", errno);
    const struct ::stat before = statusOf(path, file);
    if (S_ISDIR(before.st_mode)) throw FileError(path, "is a directory");
    // resize() clears the new bytes; a block stays in the cache until read() fills it.
    constexpr std::size_t kBlock = 1 << 18;
    requireMemory(before.st_size, shownPath(path) + ":");
    // One byte larger than the file, so that the end is found before the string has to grow. Pipes
    // and files of /proc report size 0.
    std::string bytes;
    bytes.reserve(before.st_size > 0 ? static_cast<std::size_t>(before.st_size) + 1 : kBlock);
    preferLargePages(bytes.data(), bytes.capacity());
    while (true) {
        checkCancelled();
        const std::size_t size = bytes.size();
        if (size == bytes.capacity()) {
            requireMemory(2 * size, shownPath(path) + ":");  // beside the bytes read so far
            bytes.reserve(2 * size);
        }
        bytes.resize(std::min(size + kBlock, bytes.capacity()));
        const ssize_t got = uninterrupted(
            [&] { return ::read(file.number(), bytes.data() + size, bytes.size() - size); });
        if (got < 0) fail(path, "cannot read", errno);
        bytes.resize(size + got);
        if (got == 0) break;
    }
    const struct ::stat after = statusOf(path, file);
    if (S_ISREG(before.st_mode) &&
        (after.st_size != before.st_size || !isSameTime(after.st_mtim, before.st_mtim)))
        throw FileError(path, "has changed while it was read");
    return bytes;
}

void checkWritable(const fs::path& path) {
    writeTargetOf(path);
}

void writeFile(const fs::path& path, const std::function<void(std::ostream&)>& write) {
    writeFiles({{path, write}});
}

void writeFiles(const std::vector<FileToWrite>& files) {
    std::vector<WriteTarget> destinations;
    for (const FileToWrite& file : files) destinations.push_back(writeTargetOf(file.path));
    // Declared before `written`, so that signals stay blocked until failed files are removed.
    std::optional<SignalsBlocked> blocked;
    std::deque<WrittenFile> written;
    for (std::size_t i = 0; i < files.size(); ++i) {
        if (destinations[i].kind != WriteTarget::Kind::File) {
            writeInPlace(destinations[i], files[i]);
            continue;
        }
        withFileErrors(files[i].path, "cannot create a file beside it",
                       [&] { written.emplace_back(files[i], destinations[i].path); });
        writeTo(written.back().file.descriptor(), files[i]);
    }
    for (WrittenFile& each : written)
        withFileErrors(each.toWrite.path, "cannot write", [&] { each.file.complete(); });
    blocked.emplace();
    for (WrittenFile& each : written)
        withFileErrors(each.toWrite.path, "cannot write", [&] { each.file.giveName(); });
    moveToTargets(written);
    blocked.reset();
    for (const WrittenFile& each : written)
        withFileErrors(each.toWrite.path, "is written, but may be lost if power fails now",
                       [&] { each.file.syncFolder(); });
}

}  // namespace espalier::io

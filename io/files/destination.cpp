// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/file.h>
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <string>
#include <system_error>

#include "descriptor.h"
#include "destination.h"

namespace espalier::io {

namespace fs = std::filesystem;

namespace {

using Kind = Destination::Kind;

fs::path folderOf(const fs::path& path) {
    return path.has_parent_path() ? path.parent_path() : ".";
}

bool mayAccess(const fs::path& path, int mode) {
    return ::faccessat(AT_FDCWD, path.c_str(), mode, AT_EACCESS) == 0;
}

/// Follows links at the end of a path, up to one that stands for a descriptor of this process.
Destination followed(const fs::path& path) {
    constexpr int kMostLinks = 40;  // as the system has it
    std::error_code error;
    const fs::path own = fs::canonical("/proc/self/fd", error);
    fs::path at = path;
    for (int links = 0; fs::is_symlink(fs::symlink_status(at, error)); ++links) {
        if (links == kMostLinks) throw FileError(path, "cannot write: " + systemMessage(ELOOP));
        const fs::path folder = fs::canonical(folderOf(at), error);
        if (error) break;
        const std::string name = at.filename().string();
        int number = 0;
        if (folder == own &&
            std::from_chars(name.data(), name.data() + name.size(), number).ec == std::errc())
            return {Kind::Descriptor, at, number};
        at = folder / fs::read_symlink(at, error);
        if (error) break;
    }
    return {Kind::File, at};
}

}  // namespace

Destination destinationOf(const fs::path& path) {
    Destination to = followed(path);
    if (to.kind == Kind::Descriptor) return to;
    std::error_code ignored;
    const fs::file_status status = fs::status(to.path, ignored);
    if (fs::is_directory(status)) throw FileError(path, "is a directory");
    if (fs::exists(status) && !mayAccess(to.path, W_OK))
        throw FileError(path, "cannot write: " + systemMessage(errno));
    if (fs::exists(status) && !fs::is_regular_file(status)) to.kind = Kind::Special;
    if (to.kind == Kind::File && !mayAccess(folderOf(to.path), W_OK | X_OK))
        throw FileError(path, "cannot create a file beside it: " + systemMessage(errno));
    return to;
}

}  // namespace espalier::io

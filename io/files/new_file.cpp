// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/file.h>

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <charconv>
#include <string>
#include <system_error>

#include "descriptor.h"
#include "new_file.h"

namespace espalier::io {

namespace fs = std::filesystem;

namespace {

using Kind = WriteTarget::Kind;

fs::path folderOf(const fs::path& path) {
    return path.has_parent_path() ? path.parent_path() : ".";
}

bool mayAccess(const fs::path& path, int mode) {
    return ::faccessat(AT_FDCWD, path.c_str(), mode, AT_EACCESS) == 0;
}

/// Follows links at the end of a path, but not a link to a descriptor of this process.
WriteTarget followed(const fs::path& path) {
    constexpr int kMaxLinks = 40;  // the limit of Linux
    std::error_code error;
    const fs::path own = fs::canonical("/proc/self/fd", error);
    fs::path at = path;
    for (int links = 0; fs::is_symlink(fs::symlink_status(at, error)); ++links) {
        if (links == kMaxLinks) throw FileError(path, "cannot write: " + systemMessage(ELOOP));
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

WriteTarget writeTargetOf(const fs::path& path) {
    WriteTarget to = followed(path);
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

namespace {

void check(int result) {
    if (result < 0) throw std::system_error(errno, std::generic_category());
}

/// Returns the path in /proc by which linkat() can name a nameless file.
std::string procName(int descriptor) {
    return concat("/proc/self/fd/", descriptor);
}

}  // namespace

NewFile::NewFile(const fs::path& target)
    : target_(target), folder_(target.has_parent_path() ? target.parent_path() : ".") {
    struct ::stat status {};
    if (::stat(target.c_str(), &status) == 0) old_ = status;
    if (!openNameless()) openNamed();
}

NewFile::~NewFile() {
    if (name_) ::unlink(name_->c_str());
}

bool NewFile::openNameless() {
    descriptor_ = Descriptor(uninterrupted(
        [&] { return ::open(folder_.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666); }));
    // giveName() will need /proc.
    if (descriptor_ && ::access(procName(descriptor()).c_str(), F_OK) != 0)
        descriptor_ = Descriptor();
    return static_cast<bool>(descriptor_);
}

void NewFile::openNamed() {
    // mkstemp would make a private file, but a new file's mode should follow the umask. With the
    // old file's mode, users who may not read the old file cannot read this one either.
    const ::mode_t mode = old_ ? old_->st_mode & 0777 : 0666;
    while (!descriptor_) {
        std::string name = freshName();
        descriptor_ = Descriptor(uninterrupted(
            [&] { return ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode); }));
        if (descriptor_)
            name_ = std::move(name);
        else if (errno != EEXIST)
            check(-1);
    }
}

std::string NewFile::freshName() const {
    static std::atomic<unsigned> count = 0;
    // The target's name is not part of it, because it may have the maximal length already.
    return (folder_ / (concat("espalier.tmp", ::getpid(), "-", count++))).string();
}

void NewFile::takeModeOfOldFile() const {
    if (!old_) return;
    // Sets owner and group if this process may give files away, and otherwise the group alone.
    const auto anyone = static_cast<::uid_t>(-1);
    const bool isOwned = ::fchown(descriptor(), old_->st_uid, old_->st_gid) == 0;
    const bool isOfGroup = isOwned || ::fchown(descriptor(), anyone, old_->st_gid) == 0;
    // Rights of the old owner or group are not given to a different one.
    ::mode_t mode = old_->st_mode & 07777;
    if (!isOwned) mode &= ~static_cast<::mode_t>(S_ISUID);
    if (!isOfGroup)
        mode = (mode & ~static_cast<::mode_t>(S_ISGID | S_IRWXG)) | (mode & S_IRWXO) << 3;
    struct ::stat now {};
    check(::fstat(descriptor(), &now));
    // Called only if needed: it fails on file systems that have the same mode for all files.
    if ((now.st_mode & 07777) != mode) check(::fchmod(descriptor(), mode));
}

void NewFile::sync() const {
    check(uninterrupted([&] { return ::fsync(descriptor()); }));
}

void NewFile::complete() {
    takeModeOfOldFile();
    sync();
}

void NewFile::giveName() {
    if (name_) return;
    const std::string from = procName(descriptor());
    while (!name_) {
        std::string name = freshName();
        if (::linkat(AT_FDCWD, from.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0)
            name_ = std::move(name);
        else if (errno != EEXIST)
            check(-1);
    }
    // Synced again, because Btrfs does not sync all of a nameless file.
    sync();
}

void NewFile::moveToTarget() {
    check(::rename(name_->c_str(), target_.c_str()));
    name_.reset();
}

void NewFile::syncFolder() const {
    const Descriptor folder(
        uninterrupted([&] { return ::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); }));
    // A process may be allowed to write in a folder that it cannot read.
    if (!folder && errno == EACCES) return;
    check(folder.number());
    const int result = uninterrupted([&] { return ::fsync(folder.number()); });
    // Not every file system can sync folders; these return EINVAL.
    if (result != 0 && errno != EINVAL) check(result);
}

}  // namespace espalier::io

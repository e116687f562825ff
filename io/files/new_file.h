// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/stat.h>

#include <csignal>
#include <filesystem>
#include <optional>
#include <string>

#include "descriptor.h"

namespace espalier::io {

/// The file, device or descriptor that a path leads to.
struct WriteTarget {
    enum class Kind {
        File,       ///< a file, to be made or replaced
        Special,    ///< a device or a pipe, written to directly
        Descriptor  ///< a descriptor of this process (/dev/stdout), written to from its position
    };
    Kind kind;
    std::filesystem::path path;  ///< the path behind all links; the last link may lead nowhere
    int descriptor = 0;          ///< used by kind Descriptor
};

/// Follows the links of a path, and checks that it can be written.
/// \throws FileError if it is a directory or must not be written to, or if its folder does not
///         exist or must not be written to
WriteTarget writeTargetOf(const std::filesystem::path& path);

/// A new file that replaces another one atomically when it is complete. Until then it has no name,
/// so that the system drops it when the process ends in any way. On file systems without nameless
/// files it has a temporary name from the start.
///
///     NewFile file(target);
///     …                      // write to file.descriptor()
///     file.complete();       // all is on disk
///     file.giveName();       // beside the old file
///     file.moveToTarget();   // the old file is gone
///     file.syncFolder();     // that is on disk, too
///
/// All functions throw std::system_error. Up to moveToTarget() the old file is unchanged. The
/// destructor removes the new file unless moveToTarget() has succeeded.
class NewFile {
public:
    explicit NewFile(const std::filesystem::path& target);
    NewFile(const NewFile&) = delete;
    NewFile& operator=(const NewFile&) = delete;
    ~NewFile();

    int descriptor() const { return descriptor_.number(); }

    /// Puts all on disk, with the mode of the old file.
    void complete();

    /// Gives the file a temporary name, if it has none yet. If the process ends between this and
    /// moveToTarget(), the file remains under this name: see SignalsBlocked.
    void giveName();
    void moveToTarget();

    /// Puts the folder on disk. After an error here the new file is in its place nevertheless.
    void syncFolder() const;

private:
    void sync() const;
    bool openNameless();
    void openNamed();
    void takeModeOfOldFile() const;
    std::string freshName() const;

    std::filesystem::path target_, folder_;
    std::optional<struct ::stat> old_;
    Descriptor descriptor_;
    std::optional<std::string> name_;  ///< its temporary name, as long as it has one
};

/// Blocks all signals of this thread that can be blocked, until destruction. Signals that arrive
/// meanwhile are delivered then. Other threads of the process are not affected.
class SignalsBlocked {
public:
    SignalsBlocked() {
        ::sigset_t all;
        ::sigfillset(&all);
        ::pthread_sigmask(SIG_SETMASK, &all, &before_);
    }
    ~SignalsBlocked() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
    SignalsBlocked(const SignalsBlocked&) = delete;
    SignalsBlocked& operator=(const SignalsBlocked&) = delete;

private:
    ::sigset_t before_;
};

}  // namespace espalier::io

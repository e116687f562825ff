// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/stat.h>

#include <csignal>
#include <filesystem>
#include <optional>
#include <string>

#include "descriptor.h"

namespace espalier::io {

/// What is written to when a path is.
struct WriteTarget {
    enum class Kind {
        File,       ///< made, or replaced
        Special,    ///< a device or a pipe: written to as it is
        Descriptor  ///< of this process (/dev/stdout): goes on where that is
    };
    Kind kind;
    std::filesystem::path path;  ///< behind all links, those that lead nowhere too
    int descriptor = 0;          ///< if it is one
};

/// \throws FileError if it is a directory, if it must not be written to, or if its folder must not
///         be or is not there
WriteTarget writeTargetOf(const std::filesystem::path& path);

/// A file that is to take the place of another when it is complete, in one step. Until then the
/// system knows it without a name, and drops it when the process ends, however that comes; where
/// the file system has no such files it has a name of its own from the start.
///
///     NewFile file(target);
///     …                      // write to file.descriptor()
///     file.complete();       // all is on disk
///     file.giveName();       // beside the old file
///     file.moveToTarget();   // the old file is gone
///     file.syncFolder();     // that is on disk, too
///
/// Whatever fails is a std::system_error, and up to moveToTarget() the old file is as it was. What
/// has not become the target by the end is removed.
class NewFile {
public:
    explicit NewFile(const std::filesystem::path& target);
    NewFile(const NewFile&) = delete;
    NewFile& operator=(const NewFile&) = delete;
    ~NewFile();

    int descriptor() const { return descriptor_.number(); }

    /// Puts all on disk, with the mode of the old file.
    void complete();

    /// Gives the file a name, if it has none yet. A process that ends between this and
    /// moveToTarget() leaves the name behind: see SignalsBlocked.
    void giveName();
    void moveToTarget();

    /// An error of this one leaves the new file in its place.
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
    std::optional<std::string> name_;  ///< its own, as long as it has one
};

/// Blocks all signals of this thread that can be blocked, while it lives. Signals that arrive
/// meanwhile are delivered at its end. Other threads of the process are not affected.
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

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/error.h>

#include <cstddef>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

namespace espalier::io {

/// A path as messages show it: printable (base/printable.h), and shortened.
ESPALIER_API std::string shownPath(const std::filesystem::path& path);

/// A file that cannot be read or written. what() is "path: cause" or "path:line: cause", printable
/// whatever the path and the cause are.
class ESPALIER_API FileError : public Error {
public:
    FileError(const std::filesystem::path& path, const std::string& cause);

    /// \param line from 1
    FileError(const std::filesystem::path& path, std::size_t line, const std::string& cause);
};

/// The bytes of a file, a pipe or a device, up to its end.
/// \throws FileError if it cannot be opened or read to its end, with the system's reason; or if it
/// is changed meanwhile: parts of two files would be no file. MemoryError naming it, if it is
/// larger than a MemoryLimit allows
ESPALIER_API std::string readFile(const std::filesystem::path& path);

/// Calls `write` on a new file, and puts that in the place of `path` when all is on disk. The
/// stream cannot go back: it may be that of a pipe.
///
/// Whole: if anything fails, what throws or what the system refuses, the old file is as it was, and
/// there is no other. The new file has no name until it is complete, and the system drops it when
/// the process ends: a signal or a loss of power in the middle leaves the old file and nothing
/// else. The last two calls name the new file and rename it. Between them this thread blocks
/// signals; but a loss of power, SIGKILL, or a signal that another thread takes may leave a file
/// "espalier.tmp…" there. So may any signal where the file system has no files without names, as
/// NFS.
/// Durable: on return the new file is on disk, and so is its name.
///
/// A link is followed, and stays one. A file that is there gives the new one its mode, its group
/// and its owner, as far as this process may; where it may not, rights of the owner or the group
/// are not given to others. Other hard links to it stay with the old file. A new file has the mode
/// that the process gives files (umask). A device or a pipe is written to directly, and so is what
/// this process has open (/dev/stdout), where that stands; a pipe that nobody reads is an error
/// here, and no SIGPIPE, and a file beyond the limit of the process is no SIGXFSZ.
///
/// A file that this process must not write to is refused, though it might be replaced: who made it
/// read-only wants to keep it. So do `cp` and the shell's `>`; `sed -i` replaces it.
///
/// \throws FileError if the file cannot be made, written or put in its place, with the system's
/// reason; what `write` throws. One error leaves the new file in its place, and says so: that the
/// folder cannot be put on disk.
ESPALIER_API void writeFile(const std::filesystem::path& path,
                            const std::function<void(std::ostream&)>& write);

/// A file, and what writes it.
struct ESPALIER_API FileToWrite {
    std::filesystem::path path;
    std::function<void(std::ostream&)> write;
};

/// The same for files that belong together: none is put in its place before all are on disk. If the
/// system refuses that for one of them, those before it are replaced, and the error names them.
ESPALIER_API void writeFiles(const std::vector<FileToWrite>& files);

/// Refuses what writeFile() would refuse before it calls `write`, so that it can be refused before
/// long work: a directory, a read-only file, a folder that is not there or must not be written to.
/// \throws FileError
ESPALIER_API void checkWritable(const std::filesystem::path& path);

}  // namespace espalier::io

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

/// \file
/// Reads whole files, and writes files atomically.

namespace espalier::io {

/// Returns a path as messages show it: printable (base/printable.h), and shortened if it is long.
ESPALIER_API std::string shownPath(const std::filesystem::path& path);

/// Thrown when a file cannot be read or written. what() is "path: cause" or "path:line: cause", and
/// is printable whatever bytes the path and the cause contain.
class ESPALIER_API FileError : public Error {
public:
    FileError(const std::filesystem::path& path, const std::string& cause);

    /// \param line from 1
    FileError(const std::filesystem::path& path, std::size_t line, const std::string& cause);
};

/// Returns the bytes of a file, a pipe or a device, up to its end.
/// \throws FileError if it cannot be opened or read to its end, with the system's reason, or if the
///         file changes while it is read; MemoryError that names the file, if it is larger than a
///         MemoryLimit allows
ESPALIER_API std::string readFile(const std::filesystem::path& path);

/// Returns the names of the files and folders in a folder, in order; none if it cannot be read. The
/// iterators of the standard library end the program if memory runs out.
std::vector<std::string> namesIn(const std::filesystem::path& folder);

/// Calls `write` with a stream to a new file, and replaces `path` by that file when all of it is on
/// disk. The stream cannot seek, since it may write to a pipe.
///
/// Atomic: if `write` throws or the system refuses anything, the old file is unchanged and the new
/// one is gone. The new file has no name until it is complete, and the system drops it when the
/// process ends; so a signal or a loss of power before that leaves the old file and nothing else.
/// The last two system calls name the new file and rename it to `path`. Between them this thread
/// blocks signals, but a loss of power, SIGKILL, or a signal that another thread handles may leave
/// a file "espalier.tmp…" in the folder. On file systems without nameless files, such as NFS, the
/// new file has such a name from the start, and any signal may leave it.
/// Durable: on return the new file and its name are on disk.
///
/// Symbolic links are followed, and stay links. The new file gets the mode, group and owner of the
/// old one as far as this process may set them; rights of an owner or group that cannot be set are
/// not given to anyone else. Other hard links keep the old content. A file that did not exist gets
/// the usual mode (umask). Devices, pipes and open descriptors of this process (/dev/stdout) are
/// written to directly, from their current position. A pipe without a reader is an error and raises
/// no SIGPIPE; a file beyond the size limit of the process raises no SIGXFSZ.
///
/// A read-only file is refused, although it could be replaced, because its owner wants to keep it.
/// `cp` and the shell's `>` refuse it too; `sed -i` replaces it.
///
/// \throws FileError if the file cannot be made, written or renamed, with the system's reason; what
///         `write` throws. If only the folder cannot be put on disk, the new file is in its place
///         nevertheless, and the message says so.
ESPALIER_API void writeFile(const std::filesystem::path& path,
                            const std::function<void(std::ostream&)>& write);

/// A path, and the function that writes its content.
struct ESPALIER_API FileToWrite {
    std::filesystem::path path;
    std::function<void(std::ostream&)> write;
};

/// The same for files that belong together: no file is replaced before all new ones are on disk. If
/// the system refuses to replace one of them, the files before it are already replaced, and the
/// error names them.
ESPALIER_API void writeFiles(const std::vector<FileToWrite>& files);

/// Checks a path for writeFile(), so that it is refused before long work.
/// \throws FileError if the path is a directory or a read-only file, or if its folder does not
///         exist or cannot be written to
ESPALIER_API void checkWritable(const std::filesystem::path& path);

}  // namespace espalier::io

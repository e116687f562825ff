// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/api.h>
#include <espalier/far/error.h>

#include <cstddef>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

namespace espalier::io {

/// A file that cannot be read or written. what() is "path: cause" or "path:line: cause".
class ESPALIER_API FileError : public Error {
public:
    FileError(const std::filesystem::path& path, const std::string& cause);

    /// \param line from 1
    FileError(const std::filesystem::path& path, std::size_t line, const std::string& cause);
};

/// The bytes of a file.
/// \throws FileError if it cannot be opened or read to its end
ESPALIER_API std::string readFile(const std::filesystem::path& path);

/// Calls `write` on a new file beside `path`, and renames that to `path` when all is on disk. If
/// anything fails, the new file is removed and the old one is as it was. A link is followed; a
/// device or a pipe is written to directly.
///
/// \throws FileError if the file cannot be made, written or renamed; what `write` throws
ESPALIER_API void writeFile(const std::filesystem::path& path,
                            const std::function<void(std::ostream&)>& write);

/// A file, and what writes it.
struct ESPALIER_API FileToWrite {
    std::filesystem::path path;
    std::function<void(std::ostream&)> write;
};

/// The same for files that belong together: none is renamed before all are on disk.
ESPALIER_API void writeFiles(const std::vector<FileToWrite>& files);

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/file.h>

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <deque>
#include <fstream>
#include <system_error>

namespace espalier::io {

namespace fs = std::filesystem;

FileError::FileError(const fs::path& path, const std::string& cause)
    : Error(path.string() + ": " + cause) {}

FileError::FileError(const fs::path& path, std::size_t line, const std::string& cause)
    : Error(path.string() + ":" + std::to_string(line) + ": " + cause) {}

namespace {

std::string systemMessage() {
    return std::strerror(errno);
}

/// A file beside the target, removed unless it has become the target.
class TemporaryFile {
public:
    explicit TemporaryFile(const fs::path& target) : target_(target) {
        // Not mkstemp: it makes private files, and a new file's mode should follow the umask.
        for (int attempt = 0; descriptor_ < 0; ++attempt) {
            name_ = target.string() + ".tmp" + std::to_string(::getpid()) + "-" +
                    std::to_string(attempt);
            descriptor_ = ::open(name_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
            if (descriptor_ < 0 && errno != EEXIST)
                throw FileError(target, "cannot create a file beside it: " + systemMessage());
        }
    }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;
    ~TemporaryFile() {
        ::close(descriptor_);
        if (!isInPlace_) ::unlink(name_.c_str());
    }

    const std::string& name() const { return name_; }

    void moveToTarget() {
        if (::fsync(descriptor_) != 0) throw FileError(target_, "cannot write: " + systemMessage());
        std::error_code error;
        const fs::file_status old = fs::status(target_, error);
        if (fs::exists(old)) fs::permissions(name_, old.permissions(), error);
        fs::rename(name_, target_, error);
        if (error) throw FileError(target_, "cannot write: " + error.message());
        isInPlace_ = true;
    }

private:
    fs::path target_;
    std::string name_;
    int descriptor_ = -1;
    bool isInPlace_ = false;
};

}  // namespace

std::string readFile(const fs::path& path) {
    std::error_code error;
    if (fs::is_directory(path, error)) throw FileError(path, "is a directory");
    std::ifstream in(path, std::ios::binary);
    if (!in) throw FileError(path, "cannot open: " + systemMessage());
    std::string bytes;
    char block[1 << 16];
    while (in.read(block, sizeof block) || in.gcount() > 0)
        bytes.append(block, static_cast<std::size_t>(in.gcount()));
    if (in.bad()) throw FileError(path, "cannot read: " + systemMessage());
    return bytes;
}

void writeFile(const fs::path& path, const std::function<void(std::ostream&)>& write) {
    writeFiles({{path, write}});
}

void writeFiles(const std::vector<FileToWrite>& files) {
    std::error_code ignored;
    const auto writeTo = [](const fs::path& name, const FileToWrite& file) {
        std::ofstream out(name, std::ios::binary | std::ios::trunc);
        if (out) file.write(out);
        out.close();
        if (!out) throw FileError(file.path, "cannot write: " + systemMessage());
    };
    std::deque<TemporaryFile> written;
    for (const FileToWrite& file : files) {
        // A device or a pipe is written to, not replaced.
        if (fs::exists(file.path, ignored) && !fs::is_regular_file(file.path, ignored)) {
            if (fs::is_directory(file.path, ignored)) throw FileError(file.path, "is a directory");
            writeTo(file.path, file);
            continue;
        }
        // A link stays one; what it names is replaced.
        written.emplace_back(fs::is_symlink(file.path, ignored) ? fs::weakly_canonical(file.path)
                                                                : file.path);
        writeTo(written.back().name(), file);
    }
    for (TemporaryFile& file : written) file.moveToTarget();
}

}  // namespace espalier::io

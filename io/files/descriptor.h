// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <exception>
#include <ios>
#include <streambuf>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace espalier::io {

/// Owns an open file descriptor, or none, and closes it on destruction.
class Descriptor {
public:
    Descriptor() = default;
    /// \param number as system calls return it: negative if there is none
    explicit Descriptor(int number) : number_(number) {}
    Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        std::swap(number_, other.number_);
        return *this;
    }
    ~Descriptor() {
        if (number_ >= 0) ::close(number_);
    }

    explicit operator bool() const { return number_ >= 0; }
    int number() const { return number_; }

private:
    int number_ = -1;
};

/// Repeats a system call while signals interrupt it.
template <class Call>
auto uninterrupted(Call call) {
    auto result = call();
    while (result < 0 && errno == EINTR) result = call();
    return result;
}

/// Returns the system's text for an error number, such as "No such file or directory".
inline std::string systemMessage(int error) {
    return std::generic_category().message(error);
}

/// A stream buffer that writes to an open file. Unlike std::filebuf it tells why a write failed,
/// and the signals of a pipe without readers or of a file size limit do not end the program.
/// The host may cancel between two blocks of a megabyte (checkCancelled()). A stream swallows what
/// its buffer throws, so rethrowCancelled() throws it.
class DescriptorBuffer final : public std::streambuf {
public:
    /// \param descriptor must stay open while the buffer is used
    explicit DescriptorBuffer(int descriptor);

    /// Returns the error of the first write that failed; 0 if none has failed. Nothing is written
    /// after an error, or after the host has cancelled.
    int error() const { return error_; }

    /// \throws Cancelled, or the exception of the callback, if the host has cancelled a write
    void rethrowCancelled() const {
        if (cancelled_) std::rethrow_exception(cancelled_);
    }

protected:
    int_type overflow(int_type character) override;
    std::streamsize xsputn(const char* from, std::streamsize count) override;
    int sync() override;

private:
    bool write(const char* from, std::size_t count);

    int descriptor_;
    int error_ = 0;
    std::exception_ptr cancelled_;
    std::vector<char> buffer_;
};

}  // namespace espalier::io

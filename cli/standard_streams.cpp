// SPDX-License-Identifier: Apache-2.0
#include "standard_streams.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

namespace espalier::cli {

void holdStandardStreams() {
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        if (::fcntl(stream, F_GETFD) == -1 && errno == EBADF) {
            // It gets the lowest number that is free, which is this one; and the wrong direction.
            if (::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY) != stream) return;
        }
}

void flushOutput() {
    errno = 0;
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return;
    throw std::system_error(errno != 0 ? errno : EIO, std::generic_category());
}

void printError(const char* cause) noexcept {
    std::fprintf(stderr, "espalier: %s\n", cause);
}

void printError(const std::system_error& error) noexcept {
    if (std::ferror(stdout) == 0) return printError(error.what());
    std::fprintf(stderr, "espalier: cannot write to standard output: %s\n",
                 std::strerror(error.code().value()));
}

}  // namespace espalier::cli

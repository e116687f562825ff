// SPDX-License-Identifier: Apache-2.0
#include "standard_streams.h"

#include <espalier/base/printable.h>
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>
#include <string>

namespace espalier::cli {
namespace {

/// Out of memory where no exception can go: before main(), or in a destructor of a library that we
/// use (nlohmann's of JSON allocates).
class EndsWithoutMemory {
public:
    EndsWithoutMemory() { previous_ = std::set_terminate(end); }

private:
    [[noreturn]] static void end() {
        try {
            if (std::current_exception()) throw;
        } catch (const std::bad_alloc&) {
            printError("out of memory");
            std::_Exit(1);
        } catch (...) {
        }
        previous_();
        std::abort();
    }

    static inline std::terminate_handler previous_ = nullptr;
};

// Before what else is made before main().
[[gnu::init_priority(101)]] EndsWithoutMemory endsWithoutMemory;

}  // namespace

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
    // Messages of the command line and of the system hold arguments and paths as they are.
    constexpr std::size_t kMaxBytes = 2000;
    std::string text;
    try {
        text = printable(cause, kMaxBytes);
        cause = text.c_str();
    } catch (const std::bad_alloc&) {
        cause = "out of memory";
    }
    printPrintableError(cause);
}

void printPrintableError(const char* cause) noexcept {
    std::fprintf(stderr, "espalier: %s\n", cause);
}

void printError(const std::system_error& error) noexcept {
    if (std::ferror(stdout) == 0) return printError(error.what());
    std::fprintf(stderr, "espalier: cannot write to standard output: %s\n",
                 std::strerror(error.code().value()));
}

}  // namespace espalier::cli

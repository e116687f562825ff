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

#include "run.h"

namespace espalier::cli {
namespace {

/// Reports a lack of memory in places that no exception can leave: code before main(), and
/// destructors of libraries (nlohmann's destructor of JSON allocates).
class EndsWithoutMemory {
public:
    EndsWithoutMemory() { previous_ = std::set_terminate(end); }

private:
    [[noreturn]] static void end() {
        try {
            if (std::current_exception()) throw;
        } catch (const std::bad_alloc&) {
            printPrintableError(OutOfMemory().what());
            std::_Exit(1);
        } catch (...) {
        }
        previous_();
        std::abort();
    }

    static inline std::terminate_handler previous_ = nullptr;
};

// The priority constructs this object before all other static objects.
[[gnu::init_priority(101)]] EndsWithoutMemory endsWithoutMemory;

}  // namespace

void holdStandardStreams() {
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        if (::fcntl(stream, F_GETFD) == -1 && errno == EBADF) {
            // open() returns the lowest free number, which is this stream. It is opened in the
            // wrong direction, so that using it is an error.
            if (::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY) != stream) return;
        }
}

void flushOutput() {
    errno = 0;
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return;
    throw std::system_error(errno != 0 ? errno : EIO, std::generic_category());
}

void printError(const char* cause) noexcept {
    // Messages of CLI11 and of the system contain arguments and paths unescaped.
    constexpr std::size_t kMaxBytes = 2000;
    try {
        printPrintableError(printable(cause, kMaxBytes).c_str());
    } catch (const std::bad_alloc&) {
        printPrintableError(OutOfMemory().what());
    }
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

// SPDX-License-Identifier: Apache-2.0
#include "system_faults.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/types.h>

#include <cerrno>
#include <cstdarg>
#include <cstddef>
#include <utility>

// Replaces functions of the C library, as a program may do.
namespace {

using espalier::test::SystemCall;

SystemCall awaited = SystemCall::Open;
int callsLeft = 0;
std::function<int()> fault;

/// Returns true if a call must fail, and sets errno.
bool fails(SystemCall call) {
    if (call != awaited || callsLeft == 0 || --callsLeft > 0) return false;
    const std::function<int()> what = fault;  // a copy, because the call may reset `fault`
    const int error = what();
    if (error != 0) errno = error;
    return error != 0;
}

template <class Function>
Function* real(const char* name) {
    return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
    std::va_list more;
    va_start(more, flags);
    const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(more, mode_t) : 0;
    va_end(more);
    if (fails(SystemCall::Open)) return -1;
    return real<int(const char*, int, ...)>("open")(path, flags, mode);
}

ssize_t read(int file, void* to, std::size_t size) {
    return fails(SystemCall::Read) ? -1
                                   : real<ssize_t(int, void*, std::size_t)>("read")(file, to, size);
}

ssize_t write(int file, const void* from, std::size_t size) {
    return fails(SystemCall::Write)
               ? -1
               : real<ssize_t(int, const void*, std::size_t)>("write")(file, from, size);
}

int fsync(int file) {
    return fails(SystemCall::Sync) ? -1 : real<int(int)>("fsync")(file);
}

int linkat(int fromFolder, const char* from, int toFolder, const char* to, int flags) noexcept {
    return fails(SystemCall::Link) ? -1
                                   : real<int(int, const char*, int, const char*, int)>("linkat")(
                                         fromFolder, from, toFolder, to, flags);
}

int rename(const char* from, const char* to) noexcept {
    return fails(SystemCall::Rename) ? -1 : real<int(const char*, const char*)>("rename")(from, to);
}

}  // extern "C"

namespace espalier::test {

SystemFault::SystemFault(SystemCall call, int n, std::function<int()> what) {
    awaited = call;
    fault = std::move(what);
    callsLeft = n;
}

SystemFault::~SystemFault() {
    callsLeft = 0;
    fault = nullptr;
}

bool SystemFault::hasHappened() const {
    return callsLeft == 0;
}

}  // namespace espalier::test

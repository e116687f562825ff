// SPDX-License-Identifier: Apache-2.0
#include <dlfcn.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>

// For a program that is run with this library before all others (LD_PRELOAD): a signal comes to the
// process, for whichever of its threads takes it, before each rename of a file.
//
//     ESPALIER_TEST_SIGNAL=15

extern "C" int rename(const char* from, const char* to) noexcept {
    if (const char* const number = std::getenv("ESPALIER_TEST_SIGNAL")) {
        ::kill(::getpid(), std::atoi(number));
        // A thread that does not block it ends the process meanwhile.
        ::usleep(50'000);
    }
    using Rename = int(const char*, const char*);
    return reinterpret_cast<Rename*>(::dlsym(RTLD_NEXT, "rename"))(from, to);
}

// SPDX-License-Identifier: Apache-2.0
#include <dlfcn.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>

// Sends a signal to a program that is run with this library preloaded (LD_PRELOAD) before each
// rename of a file. Any thread of the process may take the signal.
//
//     ESPALIER_TEST_SIGNAL=15

extern "C" int rename(const char* from, const char* to) noexcept {
    if (const char* const number = std::getenv("ESPALIER_TEST_SIGNAL")) {
        ::kill(::getpid(), std::atoi(number));
        // If a thread does not block the signal, the process ends during this time.
        ::usleep(50'000);
    }
    using Rename = int(const char*, const char*);
    return reinterpret_cast<Rename*>(::dlsym(RTLD_NEXT, "rename"))(from, to);
}

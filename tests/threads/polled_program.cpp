// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/executor.h>
#include <espalier/base/progress.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>

// The program with a host that measures how long it could not have cancelled. The linker names the
// program's own main() __real_main(), and calls __wrap_main() instead (--wrap=main).
//
// Prints to the file that ESPALIER_TEST_POLLS names: the longest time between two polls, the time
// at its end, and the whole time, in seconds. All are times of this thread's processor, which do
// not depend on what else runs; so this thread does all work.

extern "C" int __real_main(int, char**);

namespace {

double now() {
    std::timespec time{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

struct Polls {
    double last = now(), longest = 0, end = 0;

    void add() {
        const double time = now();
        if (time - last > longest) {
            longest = time - last;
            end = time;
        }
        last = time;
    }
};

}  // namespace

extern "C" int __wrap_main(int argumentCount, char** arguments) {
    Polls polls;
    int code = 0;
    {
        espalier::SerialExecutor serial;
        const espalier::ExecutorScope onThisThread(serial);
        const espalier::ProgressScope scope(
            [&](const espalier::Progress&) {
                polls.add();
                return true;
            },
            std::chrono::milliseconds(0));
        code = __real_main(argumentCount, arguments);
    }
    polls.add();
    if (const char* path = std::getenv("ESPALIER_TEST_POLLS"))
        if (std::FILE* file = std::fopen(path, "w")) {
            std::fprintf(file, "%.6f %.6f %.6f\n", polls.longest, polls.end, polls.last);
            std::fclose(file);
        }
    return code;
}

// SPDX-License-Identifier: Apache-2.0
// Lets a host control the library: version, progress, threads and memory.
#include <espalier/base/executor.h>
#include <espalier/base/memory.h>
#include <espalier/base/parallel.h>
#include <espalier/base/progress.h>

#include <chrono>

#include "guard.h"

using namespace espalier;

static_assert(ESPALIER_VERSION_MAJOR == ESPALIER_PROJECT_MAJOR &&
                  ESPALIER_VERSION_MINOR == ESPALIER_PROJECT_MINOR &&
                  ESPALIER_VERSION_PATCH == ESPALIER_PROJECT_PATCH,
              "the version in espalier.h is not that of the project");

struct espalier_progress_scope {
    ProgressScope scope;
};

namespace espalier::c {
namespace {

using Task = FunctionRef<void(Offset)>;

void runTask(void* task, int64_t index) {
    (*static_cast<const Task*>(task))(index);
}

/// Runs loops on the threads of a host, or on the calling thread only.
class HostExecutor final : public Executor {
public:
    HostExecutor(espalier_run loop, void* user) : loop_(loop), user_(user) {}

    void run(Offset count, Task task) override {
        if (loop_ != nullptr)
            loop_(user_, count, runTask, &task);
        else
            SerialExecutor().run(count, task);
    }

private:
    espalier_run loop_;
    void* user_;
};

}  // namespace
}  // namespace espalier::c

struct espalier_executor_scope {
    espalier_executor_scope(espalier_run run, void* user) : executor(run, user), scope(executor) {}

    c::HostExecutor executor;
    ExecutorScope scope;
};

struct espalier_thread_limit {
    ThreadLimit limit;
};

struct espalier_memory_limit {
    explicit espalier_memory_limit(std::uint64_t bytes) : limit(bytes) {}

    MemoryLimit limit;
};

const char* espalier_version(void) {
    return ESPALIER_PROJECT_VERSION;
}

espalier_status espalier_progress_scope_create(espalier_progress_callback callback, void* user,
                                               int32_t milliseconds,
                                               espalier_progress_scope** scope) {
    return c::result(scope, "scope", [&] {
        if (callback == nullptr) throw Error("callback is null");
        if (milliseconds < 0)
            throw ArgumentError("", "milliseconds", std::to_string(milliseconds), "0 or more");
        const auto report = [callback, user](const Progress& progress) {
            const espalier_progress given = {progress.stage, progress.done, progress.count};
            return callback(user, &given) != 0;
        };
        return new espalier_progress_scope{
            ProgressScope(report, std::chrono::milliseconds(milliseconds))};
    });
}

void espalier_progress_scope_destroy(espalier_progress_scope* scope) {
    delete scope;
}

espalier_status espalier_executor_scope_create(espalier_run run, void* user,
                                               espalier_executor_scope** scope) {
    return c::result(scope, "scope", [&] { return new espalier_executor_scope(run, user); });
}

void espalier_executor_scope_destroy(espalier_executor_scope* scope) {
    delete scope;
}

espalier_status espalier_thread_limit_create(int32_t threads, espalier_thread_limit** limit) {
    return c::result(limit, "limit", [&] {
        if (threads < 1) throw ArgumentError("", "threads", std::to_string(threads), "1 or more");
        return new espalier_thread_limit{ThreadLimit(threads)};
    });
}

void espalier_thread_limit_destroy(espalier_thread_limit* limit) {
    delete limit;
}

espalier_status espalier_memory_limit_create(int64_t bytes, espalier_memory_limit** limit) {
    return c::result(limit, "limit", [&] {
        if (bytes < 1) throw ArgumentError("", "bytes", std::to_string(bytes), "1 or more");
        return new espalier_memory_limit(static_cast<std::uint64_t>(bytes));
    });
}

void espalier_memory_limit_destroy(espalier_memory_limit* limit) {
    delete limit;
}

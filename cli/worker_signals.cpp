// SPDX-License-Identifier: Apache-2.0
#include "worker_signals.h"

#ifdef ESPALIER_WITH_TBB
#include <tbb/task_scheduler_observer.h>

#include <csignal>
#endif

namespace espalier::cli {

#ifdef ESPALIER_WITH_TBB

class SignalsToMainThread::Observer : public tbb::task_scheduler_observer {
public:
    Observer() { observe(true); }
    ~Observer() override { observe(false); }

    /// A thread begins to work.
    void on_scheduler_entry(bool isWorker) override {
        if (!isWorker) return;
        ::sigset_t all;
        ::sigfillset(&all);
        ::pthread_sigmask(SIG_BLOCK, &all, nullptr);
    }
};

SignalsToMainThread::SignalsToMainThread() : observer_(std::make_unique<Observer>()) {}

#else

class SignalsToMainThread::Observer {};

SignalsToMainThread::SignalsToMainThread() = default;

#endif

SignalsToMainThread::~SignalsToMainThread() = default;

}  // namespace espalier::cli

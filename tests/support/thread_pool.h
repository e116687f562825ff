// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/executor.h>

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace espalier::test {

/// A thread pool of a host, independent of oneTBB. It uses a single mutex, which the thread
/// sanitizer understands.
class ThreadPool final : public Executor {
public:
    enum class Waiting {
        Blocks,        ///< a thread that waits for its loop does nothing else
        HelpsAnybody,  ///< a waiting thread runs any other work, as in many schedulers
    };

    /// Adds work of the host, for a thread that has nothing else to do.
    void post(std::function<void()> job) {
        const std::lock_guard lock(mutex_);
        posted_.push_back(std::move(job));
        changed_.notify_all();
    }

    explicit ThreadPool(int threads, Waiting waiting = Waiting::Blocks) : waiting_(waiting) {
        jobs_.reserve(1000);
        for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { work(); });
    }
    ~ThreadPool() override {
        {
            const std::lock_guard lock(mutex_);
            isEnding_ = true;
        }
        changed_.notify_all();
        for (std::thread& thread : threads_) thread.join();
    }

    void run(Offset count, FunctionRef<void(Offset)> task) override {
        Job job{task, count};
        std::unique_lock lock(mutex_);
        jobs_.push_back(&job);
        changed_.notify_all();
        while (job.next < job.count) runNext(job, lock);
        while (job.running > 0)
            if (waiting_ == Waiting::Blocks || !runAny(lock)) changed_.wait(lock);
        jobs_.erase(std::find(jobs_.begin(), jobs_.end(), &job));
    }

private:
    struct Job {
        FunctionRef<void(Offset)> task;
        Offset count;
        Offset next = 0;
        int running = 0;
    };

    Job* open() const {
        // Takes the oldest job, which is likely to belong to another loop.
        const auto job = std::find_if(jobs_.begin(), jobs_.end(),
                                      [](const Job* each) { return each->next < each->count; });
        return job == jobs_.end() ? nullptr : *job;
    }

    void runNext(Job& job, std::unique_lock<std::mutex>& lock) {
        const Offset index = job.next++;
        ++job.running;
        lock.unlock();
        job.task(index);
        lock.lock();
        --job.running;
        changed_.notify_all();
    }

    /// Runs a job, and returns true if there was one.
    bool runAny(std::unique_lock<std::mutex>& lock) {
        if (Job* job = open()) {
            runNext(*job, lock);
            return true;
        }
        if (posted_.empty()) return false;
        const std::function<void()> own = std::move(posted_.front());
        posted_.pop_front();
        lock.unlock();
        own();
        lock.lock();
        return true;
    }

    void work() {
        std::unique_lock lock(mutex_);
        while (!isEnding_)
            if (!runAny(lock)) changed_.wait(lock);
    }

    Waiting waiting_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<Job*> jobs_;
    std::deque<std::function<void()>> posted_;
    bool isEnding_ = false;
    std::vector<std::thread> threads_;
};

}  // namespace espalier::test

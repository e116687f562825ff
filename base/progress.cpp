// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/loop_context.h>
#include <espalier/base/memory.h>
#include <espalier/base/progress.h>

#include <utility>

namespace espalier {

const char* Cancelled::what() const noexcept {
    return "cancelled";
}

ProgressState::ProgressState(ProgressScope::Callback callback, std::chrono::milliseconds interval)
    : callback_(std::move(callback)), interval_(interval), lastCall_(Clock::now()) {}

void ProgressState::check() const {
    if (isEnded_.load(std::memory_order_acquire)) std::rethrow_exception(end_);
}

void ProgressState::beginStage(Offset count) {
    count_ = count;
    done_ = 0;
}

void ProgressState::endStage() {
    ++stage_;
    count_ = 0;
    done_ = 0;
}

void ProgressState::report() {
    if (isReporting_.test_and_set(std::memory_order_acquire)) return;
    if (!isEnded_ && Clock::now() - lastCall_ >= interval_) {
        // Calls of the library inside the callback are not part of the work.
        LoopContext own = loopContext();
        own.progress = nullptr;
        own.isInStage = false;
        const LoopContextScope scope(own);
        try {
            if (!callback_({stage_, done_, count_})) throw Cancelled();
        } catch (...) {
            end_ = std::current_exception();
            isEnded_.store(true, std::memory_order_release);
        }
        lastCall_ = Clock::now();
    }
    isReporting_.clear(std::memory_order_release);
}

ProgressScope::ProgressScope(Callback callback, std::chrono::milliseconds interval)
    : state_(std::make_unique<ProgressState>(std::move(callback), interval)),
      outer_(std::exchange(loopContext().progress, state_.get())),
      wasInStage_(std::exchange(loopContext().isInStage, false)) {}

ProgressScope::~ProgressScope() {
    loopContext().progress = outer_;
    loopContext().isInStage = wasInStage_;
}

void checkCancelled() {
    checkMemory();
    ProgressState* const progress = loopContext().progress;
    if (progress == nullptr) return;
    progress->report();
    progress->check();
}

}  // namespace espalier

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

namespace espalier::cli {

/// While this lives, signals that end the program come to the main thread alone: the threads that
/// work for it block them. So where the main thread blocks them too (io::SignalsBlocked), they
/// wait. Without oneTBB there are no other threads, and this does nothing.
class SignalsToMainThread {
public:
    SignalsToMainThread();
    ~SignalsToMainThread();
    SignalsToMainThread(const SignalsToMainThread&) = delete;
    SignalsToMainThread& operator=(const SignalsToMainThread&) = delete;

private:
    class Observer;
    std::unique_ptr<Observer> observer_;
};

}  // namespace espalier::cli

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <csignal>

namespace espalier::io {

/// Blocks all signals of this thread that can be blocked, while it lives. Signals that arrive
/// meanwhile are delivered at its end. Other threads of the process are not affected.
class SignalsBlocked {
public:
    SignalsBlocked() {
        ::sigset_t all;
        ::sigfillset(&all);
        ::pthread_sigmask(SIG_SETMASK, &all, &before_);
    }
    ~SignalsBlocked() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
    SignalsBlocked(const SignalsBlocked&) = delete;
    SignalsBlocked& operator=(const SignalsBlocked&) = delete;

private:
    ::sigset_t before_;
};

}  // namespace espalier::io

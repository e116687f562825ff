// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <csignal>

namespace espalier::io {

/// While this lives, no signal ends this thread, or interrupts it, but those that nobody can block.
/// What has come meanwhile comes at the end. Other threads of the process get theirs.
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

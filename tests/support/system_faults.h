// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

namespace espalier::test {

/// Calls of the system by which files are read and written.
enum class SystemCall { Open, Read, Write, Sync, Link, Rename };

/// While this lives, something happens in this process when such a call is made for the n-th time:
/// `fault` returns the error that it is to fail with, or 0 if it is to go on. One at a time.
class SystemFault {
public:
    /// \param n from 1
    SystemFault(SystemCall call, int n, std::function<int()> fault);
    SystemFault(SystemCall call, int n, int error) : SystemFault(call, n, [=] { return error; }) {}
    ~SystemFault();
    SystemFault(const SystemFault&) = delete;
    SystemFault& operator=(const SystemFault&) = delete;

    bool hasHappened() const;
};

}  // namespace espalier::test

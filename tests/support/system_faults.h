// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

namespace espalier::test {

/// The system calls that read and write files.
enum class SystemCall { Open, Read, Write, Sync, Link, Rename };

/// While it lives, the n-th call of this kind in this process first calls `fault`. If that returns
/// an error, the call fails with it; if it returns 0, the call goes on. Only one may exist at a
/// time.
class SystemFault {
public:
    /// \param n number of the call, from 1
    SystemFault(SystemCall call, int n, std::function<int()> fault);
    SystemFault(SystemCall call, int n, int error) : SystemFault(call, n, [=] { return error; }) {}
    ~SystemFault();
    SystemFault(const SystemFault&) = delete;
    SystemFault& operator=(const SystemFault&) = delete;

    bool hasHappened() const;
};

}  // namespace espalier::test

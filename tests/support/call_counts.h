// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ostream>

namespace espalier::test {

/// Numbers of calls of this process, in any library.
struct CallCounts {
    long allocations = 0;  ///< malloc and its relatives; operator new calls them too
    long locks = 0;        ///< locks of a mutex or of a once flag

    friend bool operator==(const CallCounts&, const CallCounts&) = default;
};

inline void PrintTo(const CallCounts& counts, std::ostream* out) {
    *out << counts.allocations << " allocations, " << counts.locks << " locks";
}

CallCounts callCounts();

/// Returns the numbers of calls that work() makes.
template <class Work>
CallCounts callsOf(Work work) {
    const CallCounts before = callCounts();
    work();
    const CallCounts after = callCounts();
    return {after.allocations - before.allocations, after.locks - before.locks};
}

}  // namespace espalier::test

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ostream>

namespace espalier::test {

/// Calls of this process, by whatever library.
struct CallCounts {
    long allocations = 0;  ///< malloc and its kin, by which operator new gets its memory, too
    long locks = 0;        ///< of a mutex, or of a flag for what is done once

    friend bool operator==(const CallCounts&, const CallCounts&) = default;
};

inline void PrintTo(const CallCounts& counts, std::ostream* out) {
    *out << counts.allocations << " allocations, " << counts.locks << " locks";
}

CallCounts callCounts();

/// The calls that work() makes.
template <class Work>
CallCounts callsOf(Work work) {
    const CallCounts before = callCounts();
    work();
    const CallCounts after = callCounts();
    return {after.allocations - before.allocations, after.locks - before.locks};
}

}  // namespace espalier::test

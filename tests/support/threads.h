// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/parallel.h>

#ifdef ESPALIER_WITH_TBB
#include <tbb/task_arena.h>
#endif

namespace espalier::test {

/// Returns the result of `work` on this number of threads, which may exceed the number of cores.
template <class Work>
auto withThreads(int threads, Work work) {
    const ThreadLimit limit(threads);
#ifdef ESPALIER_WITH_TBB
    return tbb::task_arena(threads).execute(work);
#else
    return work();
#endif
}

}  // namespace espalier::test

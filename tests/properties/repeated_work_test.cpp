// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/memory.h>
#include <espalier/base/parallel.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/shapes/inventory.h>

#include <cstdint>
#include <vector>

#include "support/test.h"

namespace espalier {
namespace {

// Each refinement needs 100 MB, and frees them. Without a way to use the freed memory again, the
// process holds twice as much after ten times. It may keep a part for later.
TEST(RepeatedWork, RefiningAgainTakesNoMoreMemory) {
    if (residentMemory() == 0) GTEST_SKIP() << "the system does not tell how much memory is in use";
    const far::CellComplex complex = shapes::box({.cells = {10, 10, 10}}).complex;
    const ThreadLimit limit(1);
    std::vector<std::uint64_t> inUse;
    for (int i = 0; i < 12; ++i) {
        far::TopologyRefiner refiner(complex);
        refiner.refineUniform(3);
        inUse.push_back(residentMemory());
    }
    EXPECT_LT(inUse.back(), inUse.front() + inUse.front() / 4);
}

}  // namespace
}  // namespace espalier

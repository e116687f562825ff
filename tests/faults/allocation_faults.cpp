// SPDX-License-Identifier: Apache-2.0
#include "allocation_faults.h"

#include <atomic>

#include "allocation_counter.h"

namespace espalier::test {
namespace {

std::atomic<long> live = 0;
std::atomic<bool> isShort = false;
std::atomic<long> calls = 0;  ///< allocations since then
Failing which = Failing::One;
long first = 0;

}  // namespace

bool allocationFails() {
    if (!isShort) return false;
    const long call = ++calls;
    return which == Failing::One ? call == first : call >= first;
}

void addLiveBlock() {
    ++live;
}

void removeLiveBlock() {
    --live;
}

long liveBlocks() {
    return live;
}

AllocationFault::AllocationFault(Failing failing, long n) {
    which = failing;
    first = n;
    calls = 0;
    isShort = true;
}

AllocationFault::~AllocationFault() {
    isShort = false;
}

bool AllocationFault::hasHappened() const {
    return count() >= first;
}

long AllocationFault::count() const {
    return calls;
}

}  // namespace espalier::test

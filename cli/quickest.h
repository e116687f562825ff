// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <limits>

namespace espalier::cli {

/// Seconds of the quickest of repeated runs, as a neighbour on the machine can only make one
/// slower: of one run at least, and of as many as begin within `seconds`.
template <class Work>
double quickest(double seconds, Work work) {
    using Clock = std::chrono::steady_clock;
    using Seconds = std::chrono::duration<double>;
    double least = std::numeric_limits<double>::infinity();
    const auto begin = Clock::now();
    auto end = begin;
    do {
        const auto start = Clock::now();
        work();
        end = Clock::now();
        least = std::min(least, Seconds(end - start).count());
    } while (Seconds(end - begin).count() < seconds);
    return least;
}

}  // namespace espalier::cli

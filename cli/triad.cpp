// SPDX-License-Identifier: Apache-2.0
#include "triad.h"

#include <espalier/base/parallel.h>

#include <algorithm>
#include <cstddef>
#include <memory>

#include "quickest.h"

namespace espalier::cli {
namespace {

constexpr Offset kTriadLength = 64'000'000;
constexpr Offset kTriadGrain = 1 << 18;

/// Written first by the threads that will read it, so that its pages lie near them.
std::unique_ptr<float[]> filled(float value) {
    auto array = std::make_unique_for_overwrite<float[]>(std::size_t{kTriadLength});
    parallelFor(kTriadLength, kTriadGrain, [&](Offset first, Offset last) {
        std::fill(array.get() + first, array.get() + last, value);
    });
    return array;
}

}  // namespace

double triadBytesPerSecond(int threads, double seconds) {
    const ThreadLimit limit(threads);
    const auto a = filled(0), b = filled(1), c = filled(2);
    const double least = quickest(seconds, [&] {
        parallelFor(kTriadLength, kTriadGrain, [&](Offset first, Offset last) {
            float* to = a.get();
            const float *from = b.get(), *other = c.get();
            for (Offset i = first; i < last; ++i) to[i] = from[i] + 3.0F * other[i];
        });
    });
    return 3.0 * sizeof(float) * kTriadLength / least;
}

}  // namespace espalier::cli

// SPDX-License-Identifier: Apache-2.0
#include "triad.h"

#include <espalier/far/parallel.h>

#include <algorithm>
#include <cstddef>
#include <memory>

#include "quickest.h"

namespace espalier::cli {
namespace {

constexpr far::Offset kTriadLength = 64'000'000;
constexpr far::Offset kTriadGrain = 1 << 18;

/// Written first by the threads that will read it, so that its pages lie near them.
std::unique_ptr<float[]> filled(float value) {
    auto array = std::make_unique_for_overwrite<float[]>(std::size_t{kTriadLength});
    far::parallelFor(kTriadLength, kTriadGrain, [&](far::Offset first, far::Offset last) {
        std::fill(array.get() + first, array.get() + last, value);
    });
    return array;
}

}  // namespace

double triadBytesPerSecond(int threads, double seconds) {
    const far::ThreadLimit limit(threads);
    const auto a = filled(0), b = filled(1), c = filled(2);
    const double least = quickest(seconds, [&] {
        far::parallelFor(kTriadLength, kTriadGrain, [&](far::Offset first, far::Offset last) {
            float* to = a.get();
            const float *from = b.get(), *other = c.get();
            for (far::Offset i = first; i < last; ++i) to[i] = from[i] + 3.0F * other[i];
        });
    });
    return 3.0 * sizeof(float) * kTriadLength / least;
}

}  // namespace espalier::cli

// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <espalier/base/array.h>
#include <espalier/base/parallel.h>

namespace espalier {
namespace {

/// a = b + s · c over arrays that exceed every cache: the bandwidth of the memory. Counts two reads
/// and one write for each number.
void triad(benchmark::State& state) {
    constexpr Offset kCount = 64 << 20;
    const ThreadLimit limit(static_cast<int>(state.range(0)));
    Array<float> a(kCount, 0), b(kCount, 1), c(kCount, 2);
    for (auto _ : state)
        parallelFor(kCount, 1 << 18, [&](Offset first, Offset last) {
            float* to = a.data();
            const float *from = b.data(), *other = c.data();
            for (Offset i = first; i < last; ++i) to[i] = from[i] + 3.0F * other[i];
            benchmark::ClobberMemory();
        });
    state.SetBytesProcessed(state.iterations() * kCount * 3 * Offset{sizeof(float)});
}
BENCHMARK(triad)
    ->Name("triad/threads")
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace espalier

// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/targets.h>

#include <cmath>

#include "fuzz_target.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace espalier;
    constexpr far::Index kPointCount = 100;
    const std::string name = "targets.txt";
    const auto targets = fuzz::readResult(
        name, [&] { return io::readTargets(name, kPointCount, fuzz::textOf(data, size)); });
    if (!targets) return 0;
    fuzz::require(!targets->empty(), "there are targets");
    for (const io::Target& target : *targets) {
        fuzz::require(target.point >= 0 && target.point < kPointCount, "a target is of a point");
        for (const double coordinate : target.position)
            fuzz::require(std::isfinite(coordinate), "a target is somewhere");
    }
    return 0;
}

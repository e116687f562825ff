// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/targets.h>

#include <cmath>

#include "fuzz_target.h"

namespace espalier::fuzz {
namespace {

const Target kTargets("targets", [](std::string_view bytes) {
    constexpr Index kPointCount = 100;
    const std::string name = "targets.txt";
    const auto targets =
        readResult(name, [&] { return io::readTargets(name, kPointCount, bytes); });
    if (!targets) return;
    require(!targets->empty(), "there are targets");
    for (const io::Target& target : *targets) {
        require(target.point >= 0 && target.point < kPointCount, "a target is of a point");
        for (const double coordinate : target.position)
            require(std::isfinite(coordinate), "a target is somewhere");
    }
});

}  // namespace
}  // namespace espalier::fuzz

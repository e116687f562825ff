// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/displacements.h>
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

const Target kDisplacements("displacements", [](std::string_view bytes) {
    constexpr Index kVertexCount = 100;
    // Arrays of NumPy begin with a byte that no text has.
    const std::string name = bytes.starts_with('\x93') ? "step.npy" : "step.csv";
    const auto displacements =
        readResult(name, [&] { return io::readDisplacements(name, kVertexCount, bytes); });
    if (!displacements) return;
    require(std::ssize(*displacements) == kVertexCount, "each vertex has a displacement");
    for (const Point3& displacement : *displacements)
        for (const double coordinate : displacement)
            require(std::isfinite(coordinate), "a displacement is finite");
});

}  // namespace
}  // namespace espalier::fuzz

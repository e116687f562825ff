// SPDX-License-Identifier: Apache-2.0
#include "binding_target.h"

/// Points bound to level 1.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace espalier;
    constexpr std::size_t kMostPoints = 4;
    fuzz::runBinding(fuzz::Input(data, size), kMostPoints,
                     [](const auto& refiner, const auto& rest, auto rules, const auto& points,
                        const auto& options) {
                         return stencils::bindPoints<double>(refiner, rest, 1, rules, points,
                                                             options);
                     });
    return 0;
}

// SPDX-License-Identifier: Apache-2.0
#include <espalier/stencils/limit_binding.h>

#include "binding_target.h"

/// The same to the limit, of one point, and not too closely: in a lattice without volume it is
/// sought in all cells that are there.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace espalier;
    constexpr std::size_t kMostPoints = 1;
    fuzz::runBinding(fuzz::Input(data, size), kMostPoints,
                     [](const auto& refiner, const auto& rest, auto rules, const auto& points,
                        const auto& options) {
                         auto bound = stencils::bindLimit<double>(
                             refiner, rest, rules, points,
                             {.embedding = options, .tolerance = 1e-3, .gradients = true});
                         for (const auto& table : bound.binding.table.gradients)
                             for (const double weight : table.weights())
                                 fuzz::require(std::isfinite(weight), "gradients are finite");
                         return stencils::BoundModel<double>{
                             stencils::withoutGradients(std::move(bound.binding)),
                             std::move(bound.statuses), bound.largestResidual};
                     });
    return 0;
}

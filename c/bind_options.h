// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/embedding.h>
#include <espalier/far/topology_refiner.h>

#include <cstddef>

#include "arguments.h"

// How points are bound, as C says it.
namespace espalier::c {

/// \throws Error for options of a wrong size
inline espalier_bind_options bindOptionsOr(const espalier_bind_options* options) {
    return optionsOr(options, espalier_default_bind_options(),
                     offsetof(espalier_bind_options, limit_tolerance),
                     "espalier_default_bind_options");
}

/// Options for points bound to a level.
/// \throws Error if the limit is asked for, with the reason
inline espalier_bind_options levelOptionsOr(const espalier_bind_options* options,
                                            const char* reason) {
    const espalier_bind_options chosen = bindOptionsOr(options);
    if (chosen.limit_tolerance != 0)
        throw Error("limit_tolerance is " + std::to_string(chosen.limit_tolerance) +
                    "; expected 0, since " + reason);
    return chosen;
}

/// \throws Error for an unknown policy
inline embed::EmbeddingOptions embeddingOptions(const espalier_bind_options& chosen) {
    embed::EmbeddingOptions options;
    options.outside = choice(chosen.outside, embed::OutsidePolicy::Error, "outside");
    options.tolerance = chosen.tolerance;
    return options;
}

/// A refiner of the same base, which points can be bound to.
inline far::TopologyRefiner baseOf(const far::TopologyRefiner& refiner) {
    return far::TopologyRefiner(refiner.level(0).complex, refiner.options());
}

}  // namespace espalier::c

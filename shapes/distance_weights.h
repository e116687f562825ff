// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/bounding_box.h>
#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/shapes/selection.h>

#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "checks.h"

// Weights of selections from distances; not installed.
namespace espalier::shapes {

/// Returns the weight at a distance from the selected region; 0 or less is inside.
double weightAt(double distance, const Falloff& falloff);

/// Returns the weights, given a function that returns the distance of a position, by its number,
/// from the region.
template <class Distance>
std::vector<double> weightsOfDistances(const std::string& function,
                                       std::span<const Point3> positions, const Falloff& falloff,
                                       const Distance& distance) {
    if (!(falloff.radius >= 0) || !std::isfinite(falloff.radius))
        throw ArgumentError(function, "falloff.radius", textOf(falloff.radius),
                            "a finite number of 0 or more");
    std::vector<double> weights;
    if (positions.empty()) return weights;
    requireFinite("positions", positions);
    constexpr double kRounding = 1e-9;
    const double tolerance = kRounding * BoundingBox(positions).diagonal();
    if (!std::isfinite(tolerance))
        throw Error("the positions are so far apart that their distance is infinite");
    weights.reserve(positions.size());
    for (std::size_t i = 0; i < positions.size(); ++i) {
        checkCancelledEvery(i, 14);
        const double outside = distance(i);
        if (std::isnan(outside))
            throw Error(concat("positions[", i, "] is ", textOf(positions[i]),
                               ", so far away that its distance is not a number"));
        weights.push_back(weightAt(outside <= tolerance ? 0 : outside, falloff));
    }
    return weights;
}

}  // namespace espalier::shapes

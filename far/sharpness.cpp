// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/sharpness.h>

#include <algorithm>

namespace espalier::far {

float storedSharpness(double sharpness) {
    // Rounded first: what rounds to 10 is infinite.
    const bool isInfinite = sharpness >= kLeastInfinite ||
                            static_cast<float>(sharpness) >= static_cast<float>(kLeastInfinite);
    return isInfinite ? kInfinitelySharp : static_cast<float>(sharpness);
}

float subdivideSharpness(float sharpness) {
    return std::max(sharpness - 1, kSmooth);
}

float subdivideEdgeSharpness(Creasing creasing, float sharpness, std::span<const float> around) {
    if (creasing == Creasing::Uniform || !isSemiSharp(sharpness))
        return subdivideSharpness(sharpness);
    // The sum first and the edge's own share taken off it again: OpenSubdiv's order of operations,
    // and so its rounding.
    float sum = 0;
    int count = 0;
    for (const float other : around)
        if (isSemiSharp(other)) {
            sum += other;
            ++count;
        }
    if (count < 2) return subdivideSharpness(sharpness);
    const float others = (sum - sharpness) / static_cast<float>(count - 1);
    return subdivideSharpness(0.75F * sharpness + 0.25F * others);
}

}  // namespace espalier::far

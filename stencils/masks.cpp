// SPDX-License-Identifier: Apache-2.0
#include <espalier/stencils/masks.h>

#include <cassert>

namespace espalier::stencils {
namespace {

Mask curveMask(int dimension) {
    return dimension == 0 ? Mask{0.5, 0.5, 0, 0} : Mask{0, 1, 0, 0};
}

Mask surfaceMask(int dimension, double n) {
    if (dimension == 0) return {(n - 3) / n, 2 / n, 1 / n, 0};
    return dimension == 1 ? Mask{0, 0.5, 0.5, 0} : Mask{0, 0, 1, 0};
}

Mask volumeMask(far::Rules rules, int dimension, double n) {
    if (dimension == 0) return {0.125, 0.375, 0.375, 0.125};
    if (dimension == 1)
        return rules == far::Rules::Siggraph96 ? Mask{0, (n - 3) / n, 2 / n, 1 / n}
                                               : Mask{0, 0.25, 0.5, 0.25};
    return dimension == 2 ? Mask{0, 0, 0.5, 0.5} : Mask{0, 0, 0, 1};
}

}  // namespace

Mask refinementMask(far::Rules rules, int dimension, int stratum, Index valence) {
    assert(rules != far::Rules::Mlca);
    assert(0 <= dimension && dimension <= stratum && stratum <= kMaxDimension);
    if (rules == far::Rules::Rats) {
        Mask average{};
        average[stratum] = 1;
        return average;
    }
    switch (stratum) {
        case 0:
            return {1, 0, 0, 0};
        case 1:
            return curveMask(dimension);
        case 2:
            return surfaceMask(dimension, valence);
        default:
            return volumeMask(rules, dimension, valence);
    }
}

Mask smoothTriangleMask(int triangles) {
    constexpr double kTriangle = 0.470, kOther = 0.25;
    const double faces = triangles * kTriangle + (2 - triangles) * kOther;
    return {0, 1 - faces, faces, 0};
}

}  // namespace espalier::stencils

// SPDX-License-Identifier: Apache-2.0
#include <espalier/stencils/masks.h>

#include "support/test.h"

namespace espalier::stencils {
namespace {

constexpr Rules kCatmullClark[] = {Rules::Siggraph96, Rules::Cse96};

TEST(Masks, AreAffineAndZeroOutsideTheirDimensions) {
    for (const Rules rules : {Rules::Siggraph96, Rules::Cse96, Rules::Rats})
        for (int stratum = 0; stratum <= 3; ++stratum)
            for (int dimension = 0; dimension <= stratum; ++dimension)
                for (Index valence = 2; valence <= 12; ++valence) {
                    const Mask mask = refinementMask(rules, dimension, stratum, valence);
                    double sum = 0;
                    for (int j = 0; j < 4; ++j) {
                        const double weight = mask[j];
                        sum += weight;
                        if (j < dimension || j > stratum) {
                            EXPECT_EQ(weight, 0);
                        }
                    }
                    // Up to three quotients k/n, each rounded once: three half-ulps of 1.
                    EXPECT_NEAR(sum, 1, 3e-16) << stratum << dimension << valence;
                }
}

// MacCracken & Joy 1996, section 2.2: V = (C + 3A + 3M + P)/8.
TEST(Masks, VolumeVertexIsTheSolidVertexRule) {
    for (const Rules rules : kCatmullClark)
        EXPECT_EQ(refinementMask(rules, 0, 3, 6), (Mask{1. / 8, 3. / 8, 3. / 8, 1. / 8}));
}

// The two editions agree if four faces meet (the B-spline case): (C + 2A + M)/4.
TEST(Masks, EdgeRulesAgreeAtFourFaces) {
    for (const Rules rules : kCatmullClark)
        EXPECT_EQ(refinementMask(rules, 1, 3, 4), (Mask{0, 0.25, 0.5, 0.25}));
}

// With six faces, siggraph96 gives (C + 2A + 3M)/6; cse96 does not depend on n.
TEST(Masks, EdgeRulesDifferAtSixFaces) {
    EXPECT_EQ(refinementMask(Rules::Siggraph96, 1, 3, 6), (Mask{0, 3. / 6, 2. / 6, 1. / 6}));
    EXPECT_EQ(refinementMask(Rules::Cse96, 1, 3, 6), (Mask{0, 0.25, 0.5, 0.25}));
}

// With two faces, the weight of M is (2 − 3)/2.
TEST(Masks, InteriorEdgeOfTwoFacesHasANegativeWeight) {
    EXPECT_EQ(refinementMask(Rules::Siggraph96, 1, 3, 2), (Mask{0, -0.5, 1, 0.5}));
}

// Catmull-Clark: Q/n + 2R/n + S(n − 3)/n; for n = 4, (Q + 2R + S)/4 as in Joy's notes.
TEST(Masks, SurfaceVertexIsCatmullClark) {
    EXPECT_EQ(refinementMask(Rules::Siggraph96, 0, 2, 4), (Mask{0.25, 0.5, 0.25, 0}));
    EXPECT_EQ(refinementMask(Rules::Siggraph96, 0, 2, 3), (Mask{0, 2. / 3, 1. / 3, 0}));
    EXPECT_EQ(refinementMask(Rules::Siggraph96, 0, 2, 5), (Mask{2. / 5, 2. / 5, 1. / 5, 0}));
}

TEST(Masks, CornerStays) {
    EXPECT_EQ(refinementMask(Rules::Siggraph96, 0, 0, 3), (Mask{1, 0, 0, 0}));
}

}  // namespace
}  // namespace espalier::stencils

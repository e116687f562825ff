// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/complex_builder.h>
#include <espalier/far/topology_refiner.h>
#include <gtest/gtest.h>
using namespace espalier::far;
TEST(R, cube) {
    ComplexBuilder b(3, 8);
    b.addCell(StandardCell::Hexahedron, {0,1,2,3,4,5,6,7});
    TopologyRefiner r(b.build());
    r.refineUniform(3);
    for (int l = 0; l <= 3; ++l) {
        validate(r.level(l).complex);
        for (int d = 0; d < 4; ++d) printf("%d ", r.level(l).complex.count(d));
        for (int d = 0; d < 4; ++d) for (int s = 0; s < 4; ++s) printf(" %d", r.level(l).strata.count(d,s));
        puts("");
    }
}

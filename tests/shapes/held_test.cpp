// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/held.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/pose.h>

#include "support/test.h"

namespace espalier::shapes {
namespace {

TEST(Held, VerticesAreIntegersNamedHeld) {
    Lattice lattice = box({{1, 1, 1}});
    EXPECT_THAT(heldVertices(lattice), IsEmpty());
    const Index some[] = {5, 2, 5};
    setHeldVertices(lattice, some);
    EXPECT_THAT(heldVertices(lattice), ElementsAre(2, 5));
    ASSERT_EQ(lattice.integers.size(), 1u);
    EXPECT_EQ(lattice.integers[0].name, "held");
    // A vertex of a refined lattice has noInteger().
    lattice.integers[0].values[2] = noInteger(lattice.integers[0].type);
    EXPECT_THAT(heldVertices(lattice), ElementsAre(5));
    setHeldVertices(lattice, {});
    EXPECT_EQ(lattice.integers.size(), 1u);
    EXPECT_THAT(heldVertices(lattice), IsEmpty());
    const Index none[] = {8};
    EXPECT_REFUSED(Error, "0 to 7", setHeldVertices(lattice, none));
}

TEST(Held, OtherDataOfThatNameStay) {
    const Lattice plain = box({{1, 1, 1}});
    const std::vector<std::int64_t> values = {0, 1, 2, 0, 0, 0, 0, 0};
    Lattice numbers = plain, pairs = plain, reals = plain;
    numbers.integers = {{"held", 1, IntegerType::Int32, values}};
    pairs.integers = {{"held", 2, IntegerType::Int32, std::vector<std::int64_t>(16, 1)}};
    reals.attributes = {{"held", 1, std::vector<double>(8, 1.0)}};
    const Index some[] = {5};
    for (Lattice* lattice : {&numbers, &pairs, &reals}) {
        EXPECT_THAT(heldVertices(*lattice), IsEmpty());
        EXPECT_REFUSED(Error, "point data with the name \"held\" that are not integers 0 and 1",
                       setHeldVertices(*lattice, some));
    }
    EXPECT_EQ(numbers.integers[0].values, values);
}

TEST(Held, VerticesGetNoWeight) {
    Lattice lattice = box({{1, 1, 1}});
    EXPECT_EQ(weightsWithHeld(lattice), std::vector<double>(8, 1.0));
    const Index some[] = {1, 6};
    setHeldVertices(lattice, some);
    EXPECT_THAT(weightsWithHeld(lattice), ElementsAre(1, 0, 1, 1, 1, 1, 0, 1));
    const std::vector<double> half(8, 0.5);
    EXPECT_THAT(weightsWithHeld(lattice, half), ElementsAre(.5, 0, .5, .5, .5, .5, 0, .5));
    const auto moved = pose::move(lattice.positions, {1, 2, 3}, weightsWithHeld(lattice));
    for (std::size_t v = 0; v < 8; ++v)
        EXPECT_EQ(moved[v] == lattice.positions[v], v == 1 || v == 6) << v;
    EXPECT_REFUSED(Error, "there are 3 weights",
                   weightsWithHeld(lattice, std::vector<double>(3, 1.0)));
    EXPECT_REFUSED(Error, "there are 0 weights", weightsWithHeld(lattice, std::vector<double>()));
    EXPECT_REFUSED(Error, "weights[0] is 1.5; expected 0 to 1",
                   weightsWithHeld(lattice, std::vector<double>(8, 1.5)));
}

TEST(Held, VerticesAreFrozenInFits) {
    Lattice lattice = box({{1, 1, 1}});
    const Index some[] = {1, 6}, frozen[] = {7, 6, 0};
    setHeldVertices(lattice, some);
    EXPECT_THAT(frozenWithHeld(lattice), ElementsAre(1, 6));
    EXPECT_THAT(frozenWithHeld(lattice, frozen), ElementsAre(0, 1, 6, 7));
}

}  // namespace
}  // namespace espalier::shapes

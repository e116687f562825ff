// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/array.h>

#include <cstdint>
#include <limits>

#include "support/test.h"

namespace espalier {
namespace {

constexpr std::size_t kLarge = kLargeArray / sizeof(int);

TEST(Array, LargeOnesBeginAtALargePage) {
    const Array<int> array(kLarge);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(array.data()) % (2 << 20), 0u);
}

// On the way, the memory changes from the kind for small arrays to the kind for large ones.
TEST(Array, KeepsItsElementsWhenItGrows) {
    Array<int> array;
    for (std::size_t i = 0; i < kLarge + 1; ++i) array.push_back(static_cast<int>(i));
    const Array<int> copy = array;
    array.resize(kLarge - 1);
    array.shrink_to_fit();
    const Array<int> moved = std::move(array);
    ASSERT_EQ(copy.size(), kLarge + 1);
    ASSERT_EQ(moved.size(), kLarge - 1);
    for (std::size_t i = 0; i < moved.size(); ++i) ASSERT_EQ(moved[i], static_cast<int>(i));
    for (std::size_t i = 0; i < copy.size(); ++i) ASSERT_EQ(copy[i], static_cast<int>(i));
}

TEST(Array, RefusesSizesThatNoMemoryHas) {
    EXPECT_THROW(Array<double>(std::numeric_limits<std::size_t>::max() / 4), std::length_error);
    UninitializedAllocator<double> allocator;
    EXPECT_THROW(allocator.allocate(static_cast<std::size_t>(-1) / 4), std::bad_array_new_length);
}

}  // namespace
}  // namespace espalier

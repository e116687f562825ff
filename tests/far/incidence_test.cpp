// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/incidence.h>

#include <vector>

#include "support/test.h"

namespace espalier::far {
namespace {

// Rows of one length store no offsets; other rows store them.
TEST(RowStarts, AppendedRowsStartAtTheSumOfTheLengthsBefore) {
    const std::vector<std::vector<Index>> all = {{},        {4, 4, 4},    {4, 4, 3, 4}, {0, 4, 4},
                                                 {4, 0, 0}, {1, 2, 3, 2}, {0, 0},       {5}};
    for (const auto& lengths : all) {
        RowStarts starts;
        std::vector<Index> rowAt;
        for (const Index length : lengths) {
            EXPECT_EQ(starts[starts.rowCount()], Offset(rowAt.size()));
            rowAt.insert(rowAt.end(), length, starts.rowCount());
            starts.append(length);
        }
        const RowStarts expected = RowStarts::ofLengths(lengths);
        ASSERT_EQ(starts.rowCount(), Index(lengths.size()));
        EXPECT_EQ(starts.commonLength(), expected.commonLength());
        for (Index row = 0; row <= starts.rowCount(); ++row) EXPECT_EQ(starts[row], expected[row]);
        for (std::size_t at = 0; at < rowAt.size(); ++at)
            EXPECT_EQ(starts.rowOf(Offset(at)), rowAt[at]);
    }
}

}  // namespace
}  // namespace espalier::far

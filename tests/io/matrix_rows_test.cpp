// SPDX-License-Identifier: Apache-2.0
#include "io/matrices/matrix_rows.h"
#include <io/matrix_samples.h>
#include "io/files/bytes.h"

namespace espalier::io {
namespace {

TEST(MatrixRows, AreSorted) {
    EXPECT_EQ(tableOfRows(5, {0, 3, 3, 5}, {4, 0, 2, 1, 3}, {1, 2, 3, 4, 5}),
              Table(5, {0, 3, 3, 5}, {0, 2, 4, 1, 3}, {2, 3, 1, 4, 5}));
    EXPECT_EQ(tableOfRows(0, {0}, {}, {}), Table());
}

TEST(MatrixRows, ErrorsNameTheRow) {
    const auto refused = [](Array<Offset> offsets, Array<Index> columns, Array<double> weights,
                            const std::string& why) {
        EXPECT_REFUSED(CodingError, why, tableOfRows(3, offsets, columns, weights));
    };
    refused({0, 1}, {0, 1}, {1}, "has 2 columns and 1 weights");
    refused({}, {}, {}, "no row offsets");
    refused({1, 1}, {0}, {1}, "rows from entry 1 to 1; expected 0 to 1");
    refused({0, 2}, {0}, {1}, "rows from entry 0 to 2; expected 0 to 1");
    refused({0, 2, 1}, {0}, {1}, "row 0 goes from entry 0 to 2 of 1");
    refused({0, 1, 0, 1}, {0}, {1}, "row 1 goes from entry 1 to 0 of 1");
    refused({0, -1, 1}, {0}, {1}, "row 0 goes from entry 0 to -1 of 1");
    refused({0, 1, 2}, {0, 3}, {1, 1}, "row 1 names column 3; there are 3");
    refused({0, 1, 2}, {0, -1}, {1, 1}, "row 1 names column -1; there are 3");
    refused({0, 0, 2}, {1, 1}, {1, 1}, "row 1 has column 1 twice");
    refused({0, 0, 3}, {2, 0, 2}, {1, 1, 1}, "row 1 has column 2 twice");
    refused({0, 1}, {0}, {kInfinity}, "row 0 has the weight inf");
}

TEST(MatrixRows, TooManyRowsAreRefused) {
    EXPECT_EQ(matrixSize(0, "rows"), 0);
    EXPECT_EQ(matrixSize(kMaxIndex, "rows"), kMaxIndex);
    for (const std::int64_t count : {std::int64_t{-1}, std::int64_t{kMaxIndex} + 1})
        EXPECT_REFUSED(CodingError, "claims " + std::to_string(count) + " columns; expected 0 to",
                       matrixSize(count, "columns"));
}

}  // namespace
}  // namespace espalier::io

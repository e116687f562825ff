// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/matrices/matrix_market.h>
#include <espalier/stencils/sparse_matrix.h>
#include <io/matrix_samples.h>
#include <io/model_files.h>

#include <unsupported/Eigen/SparseExtra>

namespace espalier::io {
namespace {

using stencils::StencilTable;

template <class Real>
std::string textOf(const StencilTable<Real>& table, std::span<const std::string> comments = {}) {
    const TemporaryFolder folder;
    writeMatrixMarket(folder / "a.mtx", table, comments);
    return readFile(folder / "a.mtx");
}

TEST(MatrixMarket, WritesOneBasedCoordinatesInTableOrder) {
    const StencilTable<double> table(3, {0, 2, 2, 3}, {0, 2, 1}, {0.5, 1.0 / 3, 1e-20});
    const std::vector<std::string> comments = {"espalier stencils", "two\nlines", ""};
    EXPECT_EQ(textOf(table, comments),
              "%%MatrixMarket matrix coordinate real general\n"
              "% espalier stencils\n"
              "% two\n"
              "% lines\n"
              "% \n"
              "3 3 3\n"
              "1 1 0.5\n"
              "1 3 0.3333333333333333\n"
              "3 2 1e-20\n");
}

TEST(MatrixMarket, EigenReadsItExactly) {
    const StencilTable<double> table(4, {0, 3, 3, 5}, {0, 1, 3, 2, 3},
                                     {0.25, 1.0 / 3, -1e-300, 1, 0.1});
    const TemporaryFolder folder;
    writeMatrixMarket(folder / "a.mtx", table);
    Eigen::SparseMatrix<double, Eigen::RowMajor> read;
    ASSERT_TRUE(Eigen::loadMarket(read, (folder / "a.mtx").string()));
    EXPECT_EQ(stencils::fromEigen(read), table);
}

TEST(MatrixMarket, RoundTripIsExact) {
    EXPECT_EQ(readMatrixMarket("a.mtx", textOf(sampleTable<double>())), sampleTable<double>());
    const std::vector<std::string> comments = {"a", "1 1 1"};
    EXPECT_EQ(readMatrixMarket("a.mtx", textOf(sampleTable<double>(), comments)),
              sampleTable<double>());
}

TEST(MatrixMarket, RoundTripOfFloatsGivesTheSameDoubles) {
    EXPECT_EQ(readMatrixMarket("a.mtx", textOf(sampleTable<float>())),
              stencils::convertTable<double>(sampleTable<float>()));
}

TEST(MatrixMarket, RoundTripKeepsEmptyMatrices) {
    const StencilTable<double> empty;
    EXPECT_EQ(textOf(empty), "%%MatrixMarket matrix coordinate real general\n0 0 0\n");
    EXPECT_EQ(readMatrixMarket("a.mtx", textOf(empty)), empty);
    const StencilTable<double> rows(2, {0, 0, 0, 0}, {}, {});
    EXPECT_EQ(readMatrixMarket("a.mtx", textOf(rows)), rows);
}

TEST(MatrixMarket, ReadsUnsortedEntriesAndLooseLayouts) {
    const StencilTable<double> expected(3, {0, 2, 3}, {0, 2, 1}, {4, -2, 7});
    EXPECT_EQ(readMatrixMarket("a.mtx",
                               "%%MatrixMarket MATRIX Coordinate Real General\r\n"
                               "%comment\r\n"
                               "\r\n"
                               "  2 3 3\r\n"
                               "2 2 7.0\r\n"
                               "\r\n"
                               "1\t3 -2e0\r\n"
                               " 1 1 +4"),
              expected);
    EXPECT_EQ(readMatrixMarket("a.mtx",
                               "%%MatrixMarket matrix coordinate integer general\n2 3 3\n"
                               "1 3 -2\n1 1 4\n2 2 7\n"),
              expected);
}

TEST(MatrixMarket, RefusesOtherKindsOfMatrices) {
    const auto refused = [](const std::string& banner, const std::string& why) {
        EXPECT_THAT([&] { readMatrixMarket("a.mtx", banner + "\n1 1 1\n1 1 1\n"); },
                    ThrowsMessage<FileError>(AllOf(HasSubstr("a.mtx:1: "), HasSubstr(why))));
    };
    refused("v 1 2 3", "not a Matrix Market file");
    refused("%%MatrixMarket matrix array real general", "expected coordinate");
    refused("%%MatrixMarket matrix coordinate complex general", "'complex' is not supported");
    refused("%%MatrixMarket matrix coordinate pattern general", "'pattern' is not supported");
    refused("%%MatrixMarket matrix coordinate real symmetric", "expected general");
    refused("%%MatrixMarket vector coordinate real general", "expected matrix");
    refused("%%MatrixMarket matrix coordinate", "expected real or integer");
}

TEST(MatrixMarket, RefusesMalformedEntriesWithTheirLine) {
    const auto refused = [](const std::string& body, const std::string& where,
                            const std::string& why, const std::string& field = "real") {
        EXPECT_THAT(
            [&] {
                readMatrixMarket("a.mtx",
                                 "%%MatrixMarket matrix coordinate " + field + " general\n" + body);
            },
            ThrowsMessage<FileError>(AllOf(HasSubstr("a.mtx:" + where + ": "), HasSubstr(why))))
            << body;
    };
    refused("% no more\n", "2", "expected numbers of rows");
    refused("2 2\n", "2", "number of entries");
    refused("-1 2 1\n1 1 1\n", "2", "'-1' is not a number of rows");
    refused("2 3000000000 1\n1 1 1\n", "2", "is not a number of columns from 0 to 2147483647");
    refused("2 2 1\n3 1 1\n", "3", "row 3 does not exist; expected 1 to 2");
    refused("2 2 1\n0 1 1\n", "3", "row 0 does not exist");
    refused("2 2 1\n2 5 1\n", "3", "column 5 does not exist");
    refused("2 2 2\n1 1 1\n2 2 x\n", "4", "'x' is not a number");
    refused("2 2 2\n1 1 1\n2 2 nan\n", "4", "not finite");
    refused("2 2 1\n1 1 0.5\n", "3", "'0.5' is not a number", "integer");
    refused("2 2 1\n1 1 9007199254740993\n", "3", "more than a double holds", "integer");
    refused("2 2 1\n1 1 1\n2 2 1\n", "4", "expected the end after 1 entries, got '2'");
    refused("2 2 2\n1 1 1            \n\n\n", "6", "the file ends");
    // The entry is on lines 3 and 5.
    refused("2 2 3\n2 1 1\n1 1 1\n2 1 5\n", "5", "row 2 column 1 has an entry already, on line 3");
}

TEST(MatrixMarket, ChecksClaimedSizesBeforeAllocating) {
    const std::string banner = "%%MatrixMarket matrix coordinate real general\n";
    EXPECT_REFUSED(FileError, "the number of entries is 18446744073709551615",
                   readMatrixMarket("a.mtx", banner + "2 2 18446744073709551615\n1 1 1\n"));
    EXPECT_REFUSED(FileError, "claims 2147483647 rows",
                   readMatrixMarket("a.mtx", banner + "2147483647 2 1\n1 1 1\n"));
}

TEST(MatrixMarket, RefusesTruncatedFiles) {
    const std::string text = textOf(sampleTable<double>());
    // A file that is cut within the last weight is still a matrix.
    for (std::size_t size = 0; size <= text.rfind(' '); ++size)
        EXPECT_THROW(readMatrixMarket("a.mtx", text.substr(0, size)), FileError) << size;
}

TEST(MatrixMarket, RefusesToWriteAWeightThatIsNotFinite) {
    const StencilTable<double> table(1, {0, 1, 2}, {0, 0}, {1, kNan});
    EXPECT_REFUSED(Error, "row 1 of the table", textOf(table));
}

}  // namespace
}  // namespace espalier::io

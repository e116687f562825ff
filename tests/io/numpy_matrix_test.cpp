// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/matrices/matrix_file.h>
#include <espalier/io/matrices/numpy_matrix.h>
#include <io/matrix_samples.h>
#include <io/model_files.h>

// Tests reading. tests/cli/export_test.py tests that NumPy and SciPy read the written files.
namespace espalier::io {
namespace {

Table tableInNpz(const std::string& bytes) {
    return readMatrix("a.npz", bytes);
}

template <class Real>
std::string fileBytes(const stencils::StencilTable<Real>& table) {
    const TemporaryFolder folder;
    writeNpz(folder / "a.npz", table);
    return readFile(folder / "a.npz");
}

/// The three files of a table.
struct Arrays {
    std::array<std::string, 3> files;

    explicit Arrays(const Table& table) {
        const TemporaryFolder folder;
        writeNpyArrays(folder / "D.npy", table);
        const auto paths = npyPaths(folder / "D.npy");
        for (std::size_t i = 0; i < files.size(); ++i) files[i] = readFile(paths[i]);
    }

    Table read(Index columnCount) const {
        return readNpyArrays("D.npy", columnCount, {files[0], files[1], files[2]});
    }
};

TEST(Npz, RoundTripIsExact) {
    const auto table = sampleTable<double>();
    EXPECT_EQ(tableInNpz(fileBytes(table)), table);
    const auto single = sampleTable<float>();
    EXPECT_EQ(tableInNpz(fileBytes(single)), stencils::convertTable<double>(single));
    for (const Table& edge : edgeTables()) EXPECT_EQ(tableInNpz(fileBytes(edge)), edge);
    const TemporaryFolder folder;
    writeNpz(folder / "a.npz", table);
    EXPECT_EQ(readMatrix(folder / "a.npz"), table);
    EXPECT_THROW(readMatrix(folder / "none.npz"), FileError);
}

/// See tests/io/matrices/README.md.
TEST(Npz, ReadsFilesWrittenByScipyAndNumpy) {
    const auto folder = matrixFolder();
    for (const char* name :
         {"scipy-compressed.npz", "scipy-array-unsorted-stored.npz", "numpy-2-big-endian.npz"})
        EXPECT_EQ(readMatrix(folder / name), tableOfOtherPrograms()) << name;
    constexpr double kLargest = std::int64_t{1} << 53;
    EXPECT_EQ(readMatrix(folder / "numpy-3-integers.npz"),
              Table(100'000, {0, 2, 2, 5, 5}, {0, 2, 0, 1, 3}, {1, -2, kLargest, -kLargest, 0}));
    EXPECT_EQ(readMatrix(folder / "scipy-no-rows.npz"), Table(3, {0}, {}, {}));
    EXPECT_REFUSED(FileError, "scipy-csc.npz: the matrix is in the format 'csc'; expected 'csr'",
                   readMatrix(folder / "scipy-csc.npz"));
}

TEST(Npz, TruncatedOrChangedFilesAreRefused) {
    const std::string own = fileBytes(sampleTable<double>());
    expectPartsOfMatrixRefused(own, tableInNpz);
    // Bytes that no checksum covers, such as times, have no meaning.
    expectFlipsRefusedOr(own, tableInNpz,
                         [](const Table& table) { EXPECT_EQ(table, sampleTable<double>()); });
    const std::string others = readFile(matrixFolder() / "scipy-compressed.npz");
    expectPartsOfMatrixRefused(others, tableInNpz);
    expectFlipsRefusedOr(others, tableInNpz,
                         [](const Table& table) { EXPECT_EQ(table, tableOfOtherPrograms()); });
}

TEST(Npz, ErrorsNameTheArray) {
    std::string bytes = fileBytes(sampleTable<double>());
    EXPECT_REFUSED(FileError, "a.npz: is not a ZIP archive", tableInNpz("PK"));
    // Changes the name in the directory, which is the last place that has it.
    bytes[bytes.rfind("data.npy")] = 'D';
    EXPECT_REFUSED(FileError, "a.npz: data.npy: is not in the archive", tableInNpz(bytes));
}

TEST(NpyArrays, RoundTripIsExact) {
    const auto table = sampleTable<double>();
    EXPECT_EQ(Arrays(table).read(4), table);
    for (const Table& edge : edgeTables()) EXPECT_EQ(Arrays(edge).read(edge.columnCount()), edge);
    const TemporaryFolder folder;
    writeNpyArrays(folder / "D.npy", table);
    EXPECT_EQ(readNpyArrays(folder / "D.npy", 4), table);
    std::filesystem::remove(folder / "D.indices.npy");
    EXPECT_REFUSED(FileError, "D.indices.npy: cannot open", readNpyArrays(folder / "D.npy", 4));
}

TEST(NpyArrays, ReadsFilesWrittenByNumpy) {
    EXPECT_EQ(readNpyArrays(matrixFolder() / "numpy.npy", 100'000), tableOfOtherPrograms());
}

TEST(NpyArrays, TruncatedFilesAreRefusedAndChangedOnesGiveValidTablesOrErrors) {
    const Arrays whole(sampleTable<double>());
    for (std::size_t i = 0; i < 3; ++i) {
        const auto read = [&](const std::string& bytes) {
            Arrays arrays = whole;
            arrays.files[i] = bytes;
            return arrays.read(4);
        };
        expectPartsOfMatrixRefused(whole.files[i], read);
        // These files have no checksum, so a changed file may give another matrix.
        expectFlipsRefusedOr(whole.files[i], read, expectValidTable);
    }
}

TEST(NpyArrays, ArraysThatDoNotFitTogetherAreRefused) {
    const Arrays whole(sampleTable<double>()), other(Table(4, {0, 1}, {3}, {1}));
    const auto refused = [](const Arrays& arrays, Index columnCount, const std::string& why) {
        EXPECT_REFUSED(FileError, why, arrays.read(columnCount));
    };
    refused(whole, 3, "D.npy: row 0 names column 3; there are 3");
    refused(whole, -1, "D.npy: claims -1 columns");
    const auto with = [&](std::size_t i, const std::string& file) {
        Arrays arrays = whole;
        arrays.files[i] = file;
        return arrays;
    };
    refused(with(0, other.files[0]), 4, "D.npy: has rows from entry 0 to 1; expected 0 to 5");
    refused(with(1, other.files[1]), 4, "D.npy: has 1 columns and 5 weights");
    refused(with(2, other.files[2]), 4, "D.npy: has 5 columns and 1 weights");
    // Columns are integers, and so could be offsets; weights could not.
    refused(with(0, whole.files[1]), 4, "D.npy: has rows from entry 0 to 3");
    refused(with(1, whole.files[2]), 4, "D.indices.npy: is of type '<f8'; expected integers");
    refused(with(0, Arrays(Table()).files[1]), 4, "D.npy: has no row offsets");
}

}  // namespace
}  // namespace espalier::io

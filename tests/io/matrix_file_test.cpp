// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/formats.h>
#include <espalier/io/matrices/matrix_file.h>
#include <espalier/io/matrices/numpy_matrix.h>
#include <io/matrix_samples.h>
#include <io/model_files.h>

#include <sstream>

#include "io/files/zip.h"
#include "io/matrices/npy.h"

// Tests the formats byte by byte. tests/cli/export_test.py tests that NumPy, SciPy and PETSc read
// the files.
namespace espalier::io {
namespace {

using stencils::StencilTable;

/// Returns a table with rows of 2, 0 and 1 entries and 3 columns.
template <class Real>
StencilTable<Real> sample() {
    return {3, {0, 2, 2, 3}, {0, 2, 1}, {Real(0.5), Real(1) / 3, Real(-2)}};
}

template <class Integer>
std::string petscBytes() {
    std::string bytes;
    const auto integers = [&](std::initializer_list<int> numbers) {
        for (const int number : numbers)
            bytes += bytesOf(static_cast<Integer>(number), std::endian::big);
    };
    integers({1211216, 3, 3, 3});  // MAT_FILE_CLASSID, rows, columns, entries
    integers({2, 0, 1});           // entries of each row
    integers({0, 2, 1});           // columns
    for (const double weight : {0.5, 1.0 / 3, -2.0}) bytes += bytesOf(weight, std::endian::big);
    return bytes;
}

TEST(MatrixFile, PetscBinaryIsBigEndianWithRowLengths) {
    const TemporaryFolder folder;
    writeMatrix(folder / "a.petsc", sample<double>());
    EXPECT_EQ(readFile(folder / "a.petsc"), petscBytes<std::int32_t>());
    writeMatrix(folder / "a.petsc", sample<double>(), {.petscIntegers = PetscInt::Bits64});
    EXPECT_EQ(readFile(folder / "a.petsc"), petscBytes<std::int64_t>());
    // Weights are written in double precision, whatever the precision of the table.
    const StencilTable<float> single(3, {0, 1}, {0}, {0.1F});
    writeMatrix(folder / "b.petsc", single);
    EXPECT_TRUE(readFile(folder / "b.petsc").ends_with(bytesOf(double{0.1F}, std::endian::big)));
}

TEST(MatrixFile, NpyHeadIsPaddedTo64Bytes) {
    std::ostringstream stream;
    ByteOutput out(stream, std::endian::little);
    const std::vector<float> numbers = {1.5F, -2};
    writeNpy<double>(out, std::span<const float>(numbers));
    const std::string bytes = stream.str();
    // NumPy's npy format: magic, version 1.0, the length of the rest, a dictionary, spaces.
    const std::string head = "{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }";
    EXPECT_EQ(bytes.substr(0, 10), std::string("\x93NUMPY\x01\x00\x76\x00", 10));
    EXPECT_EQ(bytes.substr(10, 118), head + std::string(117 - head.size(), ' ') + "\n");
    EXPECT_EQ(bytes.substr(128),
              bytesOf(1.5, std::endian::little) + bytesOf(-2.0, std::endian::little));
}

/// Returns an archive of a matrix with these arrays.
std::string npzOf(const std::vector<std::int64_t>& shape, const std::vector<std::int64_t>& offsets,
                  const std::string& format = "csr") {
    std::ostringstream stream;
    ZipWriter zip(stream);
    const auto add = [&](const char* name, const std::vector<std::int64_t>& numbers) {
        zip.add(name, [&](ByteOutput& out) {
            writeNpy<std::int64_t>(out, std::span<const std::int64_t>(numbers));
        });
    };
    add("shape.npy", shape);
    add("indptr.npy", offsets);
    add("indices.npy", {0, 1});
    add("data.npy", {7, 8});
    zip.add("format.npy", [&](ByteOutput& out) {
        writeNpyHead(out, "|S" + std::to_string(format.size()), {});
        out.bytes(format);
    });
    zip.finish();
    return stream.str();
}

TEST(MatrixFile, NpzErrorsNameTheArrayThatDoesNotFit) {
    EXPECT_EQ(readMatrix("a.npz", npzOf({2, 2}, {0, 2, 2})),
              StencilTable<double>(2, {0, 2, 2}, {0, 1}, {7, 8}));
    const auto refused = [](const std::string& bytes, const std::string& why) {
        EXPECT_REFUSED(FileError, "a.npz: " + why, readMatrix("a.npz", bytes));
    };
    refused(npzOf({2, 2}, {0, 2, 2}, "csc"), "the matrix is in the format 'csc'; expected 'csr'");
    refused(npzOf({2}, {0, 2, 2}), "the matrix has 1 axes; expected rows and columns");
    refused(npzOf({2, 2, 2}, {0, 2, 2}), "the matrix has 3 axes");
    refused(npzOf({1, 2}, {0, 2, 2}), "indptr.npy: has 3 numbers for 1 rows; expected one more");
    refused(npzOf({3, 2}, {0, 2, 2}), "indptr.npy: has 3 numbers for 3 rows");
    refused(npzOf({-1, 2}, {}), "claims -1 rows");
    refused(npzOf({2, std::int64_t{1} << 31}, {0, 2, 2}), "claims 2147483648 columns");
    refused(npzOf({2, 1}, {0, 2, 2}), "row 0 names column 1; there are 1");
}

TEST(MatrixFile, LongArraysAreConvertedInBlocks) {
    // More numbers than one block has when their byte order is reversed.
    std::vector<std::int32_t> numbers(10'000);
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<std::int32_t>(i);
    std::ostringstream stream;
    ByteOutput out(stream, std::endian::big);
    out.numbersAs<std::int64_t>(std::span<const std::int32_t>(numbers));
    std::string expected;
    for (const std::int32_t number : numbers)
        expected += bytesOf(std::int64_t{number}, std::endian::big);
    EXPECT_EQ(stream.str(), expected);
    EXPECT_EQ(out.count(), expected.size());
}

TEST(MatrixFile, ExtensionChoosesTheFormat) {
    const TemporaryFolder folder;
    for (const std::string& extension : extensionsOf(FileContent::Matrix, FileUse::Write)) {
        const auto path = folder / ("a" + extension);
        writeMatrix(path, sample<float>());
        for (const auto& each : matrixPaths(path)) EXPECT_TRUE(std::filesystem::exists(each));
    }
    EXPECT_EQ(matrixPaths("x/D.npy"), (std::vector<std::filesystem::path>{
                                          "x/D.indptr.npy", "x/D.indices.npy", "x/D.data.npy"}));
    EXPECT_REFUSED(FileError, "a.mat: is not of a matrix format; expected .mtx",
                   writeMatrix(folder / "a.mat", sample<float>()));
}

TEST(MatrixFile, ReadsBackByTheExtension) {
    const TemporaryFolder folder;
    const auto table = sampleTable<double>();
    for (const std::string extension : {".mtx", ".npz", ".petsc"}) {
        const auto path = folder / ("a" + extension);
        writeMatrix(path, table);
        EXPECT_EQ(readMatrix(path), table) << extension;
        // No file has this name, so the bytes must have been read.
        EXPECT_EQ(readMatrix("none" + extension, readFile(path)), table) << extension;
        EXPECT_THAT([&] { readMatrix("none" + extension, "no matrix"); },
                    ThrowsMessage<FileError>(StartsWith("none" + extension + ":")));
        EXPECT_REFUSED(FileError, "cannot open", readMatrix("none" + extension));
    }
    // PETSc's integers may have either size.
    writeMatrix(folder / "b.petsc", table, {.petscIntegers = PetscInt::Bits64});
    EXPECT_EQ(readMatrix(folder / "b.petsc"), table);
    const auto refused = [](const std::string& name, const std::string& why) {
        EXPECT_REFUSED(FileError, why, readMatrix(name));
        EXPECT_REFUSED(FileError, why, readMatrix(name, ""));
    };
    refused("D.npy", "D.npy: cannot be read as a matrix");
    refused("D.mat",
            "D.mat: is not of a matrix format that can be read; expected .mtx, .npz or .petsc");
}

TEST(MatrixFile, RefusesWeightsThatAreNotFiniteAndLeavesTheOldFile) {
    const StencilTable<double> bad(2, {0, 1, 2}, {0, 1}, {1, kNan});
    for (const std::string& extension : extensionsOf(FileContent::Matrix, FileUse::Write)) {
        const TemporaryFolder folder;
        const auto path = folder / ("a" + extension);
        putFile(path, "old");
        EXPECT_REFUSED(Error, "row 1 ", writeMatrix(path, bad));
        EXPECT_EQ(readFile(path), "old");
    }
}

}  // namespace
}  // namespace espalier::io

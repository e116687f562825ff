// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/matrices/matrix_file.h>
#include <espalier/io/matrices/petsc_binary.h>
#include <io/matrix_samples.h>
#include <io/model_files.h>

#include <cstdint>

// tests/petsc/matrix_load_test.cpp tests that PETSc writes such files.
namespace espalier::io {
namespace {

constexpr PetscInt kBoth[] = {PetscInt::Bits32, PetscInt::Bits64};

Table tableInPetscFile(const std::string& bytes) {
    return readMatrix("a.petsc", bytes);
}

template <class Real>
std::string bytesOfTable(const stencils::StencilTable<Real>& table, PetscInt integers) {
    const TemporaryFolder folder;
    writePetscBinary(folder / "a.petsc", table, integers);
    return readFile(folder / "a.petsc");
}

/// Returns a file with these integers, of 32 or 64 bits, and weights.
template <class Integer>
std::string file(const std::vector<std::int64_t>& integers, const std::vector<double>& weights) {
    std::string bytes;
    for (const std::int64_t number : integers)
        bytes += bytesOf(static_cast<Integer>(number), std::endian::big);
    for (const double weight : weights) bytes += bytesOf(weight, std::endian::big);
    return bytes;
}

TEST(PetscBinary, RoundTripIsExact) {
    for (const PetscInt integers : kBoth) {
        const auto table = sampleTable<double>();
        EXPECT_EQ(tableInPetscFile(bytesOfTable(table, integers)), table);
        const auto single = sampleTable<float>();
        EXPECT_EQ(tableInPetscFile(bytesOfTable(single, integers)),
                  stencils::convertTable<double>(single));
        for (const Table& edge : edgeTables())
            EXPECT_EQ(tableInPetscFile(bytesOfTable(edge, integers)), edge);
    }
    const TemporaryFolder folder;
    writePetscBinary(folder / "a.petsc", sampleTable<double>());
    EXPECT_EQ(readMatrix(folder / "a.petsc"), sampleTable<double>());
}

TEST(PetscBinary, SortsColumns) {
    EXPECT_EQ(
        tableInPetscFile(file<std::int32_t>({1211216, 2, 4, 4, 3, 1, 3, 0, 1, 2}, {3, 0.5, -1, 2})),
        Table(4, {0, 3, 4}, {0, 1, 3, 2}, {0.5, -1, 3, 2}));
}

TEST(PetscBinary, RefusesOtherKindsOfFiles) {
    const auto refused = [](const std::string& bytes, const std::string& why) {
        EXPECT_THAT([&] { tableInPetscFile(bytes); },
                    ThrowsMessage<FileError>(AllOf(HasSubstr("a.petsc: "), HasSubstr(why))));
    };
    refused("", "ends too early");
    // VEC_FILE_CLASSID
    refused(file<std::int32_t>({1211214, 1}, {1}), "is not a matrix of PETSc");
    refused(file<std::int32_t>({1211216, 1, 1, -1}, {1}), "dense");
    refused(file<std::int64_t>({1211216, 1, 1, -1}, {1}), "dense");
    const std::string whole = file<std::int32_t>({1211216, 1, 1, 1, 1, 0}, {1});
    EXPECT_EQ(tableInPetscFile(whole), Table(1, {0, 1}, {0}, {1}));
    // The extra bytes could be complex weights, or a vector after the matrix.
    refused(whole + bytesOf(0.0, std::endian::big), "double precision");
    EXPECT_THROW(readMatrix("/no/such/file.petsc"), FileError);
}

TEST(PetscBinary, RefusesInvalidMatrices) {
    const auto refused = [](const std::vector<std::int64_t>& integers,
                            const std::vector<double>& weights, const std::string& why) {
        for (const std::string& bytes :
             {file<std::int32_t>(integers, weights), file<std::int64_t>(integers, weights)})
            EXPECT_REFUSED(FileError, why, tableInPetscFile(bytes));
    };
    refused({1211216, -1, 1, 0}, {}, "claims -1 rows");
    refused({1211216, 0, -2, 0}, {}, "claims -2 columns");
    refused({1211216, 0, 1, -2}, {}, "-2 entries");
    refused({1211216, 2, 1, 1, 2, -1, 0}, {1}, "row 0 claims 2 of the 1 entries");
    refused({1211216, 2, 1, 1, 1, 1, 0}, {1}, "row 1 claims 1 of the 1 entries, of which 0");
    refused({1211216, 2, 1, 1, 1, -1, 0}, {1}, "row 1 claims -1");
    refused({1211216, 2, 1, 1, 0, 0, 0}, {1}, "rows from entry 0 to 0; expected 0 to 1");
    refused({1211216, 1, 1, 1, 1, 1}, {1}, "row 0 names column 1; there are 1");
    refused({1211216, 1, 1, 1, 1, -1}, {1}, "row 0 names column -1; there are 1");
    refused({1211216, 1, 3, 3, 3, 2, 1, 2}, {1, 2, 3}, "row 0 has column 2 twice");
    refused({1211216, 2, 1, 1, 0, 1, 0}, {kNan}, "row 1 has the weight nan");
}

TEST(PetscBinary, ChecksClaimedSizesBeforeAllocating) {
    constexpr std::int64_t kLargest = std::numeric_limits<std::int64_t>::max();
    constexpr std::int64_t kRows = kMaxIndex;
    const auto refused = [](const std::vector<std::int64_t>& integers, const std::string& why) {
        EXPECT_REFUSED(FileError, why, tableInPetscFile(file<std::int64_t>(integers, {})));
    };
    refused({1211216, kRows, 1, 0}, "claims 2147483647 rows and 0 entries, but 0 bytes follow");
    refused({1211216, 0, 1, kLargest}, "9223372036854775807 entries, but 0 bytes");
    // 2^60 entries of 16 bytes are 2^64 bytes, which is 0 in 64 bits.
    refused({1211216, 0, 1, std::int64_t{1} << 60}, "1152921504606846976 entries, but 0 bytes");
    // 2^60 − 1 entries of 16 bytes and two row lengths of 8 bytes are also 2^64 bytes.
    refused({1211216, 2, 1, (std::int64_t{1} << 60) - 1}, "2 rows and 1152921504606846975 entries");
    refused({1211216, kRows + 1, 1, 0}, "claims 2147483648 rows; expected 0 to 2147483647");
    refused({1211216, 0, kLargest, 0}, "claims 9223372036854775807 columns");
    refused({1211216, 1, 1, 1, 1, kRows + 1, 0}, "out of range");
}

TEST(PetscBinary, TruncatedFilesAreRefusedAndChangedOnesGiveValidTablesOrErrors) {
    for (const PetscInt integers : kBoth) {
        const std::string bytes = bytesOfTable(sampleTable<double>(), integers);
        expectPartsOfMatrixRefused(bytes, tableInPetscFile);
        // The file has no checksum, so a changed file may give another matrix.
        expectFlipsRefusedOr(bytes, tableInPetscFile, expectValidTable);
    }
}

}  // namespace
}  // namespace espalier::io

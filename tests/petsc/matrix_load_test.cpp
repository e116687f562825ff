// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/matrices/matrix_file.h>
#include <espalier/io/matrices/petsc_binary.h>
#include <petscmat.h>

#include <bit>
#include <filesystem>
#include <optional>

#include "petsc/errors.h"
#include "ranks.h"
#include "support/temporary_folder.h"
#include "support/test.h"

// Files that io writes are read by PETSc itself, and vice versa.
namespace espalier::petsc {
namespace {

/// The file of a test, in a folder of rank 0, which writes it.
class MatrixLoad : public ::testing::Test {
protected:
    static constexpr auto kOwnIntegers =
        sizeof(PetscInt) == 4 ? io::PetscInt::Bits32 : io::PetscInt::Bits64;
    static constexpr auto kOtherIntegers =
        sizeof(PetscInt) == 4 ? io::PetscInt::Bits64 : io::PetscInt::Bits32;

    MatrixLoad() {
        if (test::rank() == 0) {
            folder_.emplace();
            path_ = (*folder_ / "D.petsc").string();
        }
        auto length = int(path_.size());
        MPI_Bcast(&length, 1, MPI_INT, 0, MPI_COMM_WORLD);
        path_.resize(length);
        MPI_Bcast(path_.data(), length, MPI_CHAR, 0, MPI_COMM_WORLD);
    }
    ~MatrixLoad() override {
        MPI_Barrier(MPI_COMM_WORLD);
        MatDestroy(&matrix_);
    }

    void write(const stencils::StencilTable<double>& table, io::PetscInt integers) const {
        if (test::rank() == 0) io::writePetscBinary(path_, table, integers);
        MPI_Barrier(MPI_COMM_WORLD);
    }

    /// Calls `use` with a viewer of the file.
    template <class Use>
    void withViewer(PetscFileMode mode, Use use) {
        const ErrorCapture errors;
        PetscViewer viewer = nullptr;
        errors.check(PetscViewerBinaryOpen(MPI_COMM_WORLD, path_.c_str(), mode, &viewer));
        const PetscErrorCode used = use(viewer);
        PetscViewerDestroy(&viewer);
        errors.check(used);
    }

    void load() {
        ASSERT_EQ(MatCreate(MPI_COMM_WORLD, &matrix_), 0);
        ASSERT_EQ(MatSetType(matrix_, MATAIJ), 0);
        withViewer(FILE_MODE_READ, [&](PetscViewer viewer) { return MatLoad(matrix_, viewer); });
    }

    std::optional<TemporaryFolder> folder_;
    std::string path_;
    Mat matrix_ = nullptr;
};

TEST_F(MatrixLoad, ReadsEveryWeightExactly) {
    const auto table = randomTable(203, 31, 9);
    write(table, kOwnIntegers);
    load();
    PetscInt rows = 0, columns = 0, first = 0, last = 0;
    ASSERT_EQ(MatGetSize(matrix_, &rows, &columns), 0);
    EXPECT_EQ(rows, table.rowCount());
    EXPECT_EQ(columns, table.columnCount());
    ASSERT_EQ(MatGetOwnershipRange(matrix_, &first, &last), 0);
    const OwnedRange own = evenRange(rows, test::rank(), rankCount());
    EXPECT_EQ(first, own.first);
    EXPECT_EQ(last, own.last);
    for (PetscInt row = first; row < last; ++row) {
        PetscInt count = 0;
        const PetscInt* at = nullptr;
        const PetscScalar* values = nullptr;
        ASSERT_EQ(MatGetRow(matrix_, row, &count, &at, &values), 0);
        const auto expected = table.columns(Index(row));
        const auto weights = table.weights(Index(row));
        EXPECT_EQ(count, static_cast<PetscInt>(expected.size()));
        for (std::size_t k = 0; k < std::min(expected.size(), std::size_t(count)); ++k) {
            EXPECT_EQ(at[k], expected[k]);
            EXPECT_EQ(std::bit_cast<std::uint64_t>(values[k]),
                      std::bit_cast<std::uint64_t>(weights[k]));
        }
        ASSERT_EQ(MatRestoreRow(matrix_, row, &count, &at, &values), 0);
    }
}

TEST_F(MatrixLoad, PetscsFilesAreReadExactly) {
    const auto table = randomTable(203, 31, 9);
    write(table, kOwnIntegers);
    load();
    withViewer(FILE_MODE_WRITE, [&](PetscViewer viewer) { return MatView(matrix_, viewer); });
    MPI_Barrier(MPI_COMM_WORLD);
    if (test::rank() == 0) {
        EXPECT_EQ(io::readMatrix(path_), table);
    }
}

// PETSc reads only files with integers of its own size. It reports others, and does not misread
// them.
TEST_F(MatrixLoad, RefusesIntegersOfTheOtherSize) {
    write(randomTable(20, 5, 9), kOtherIntegers);
    EXPECT_REFUSED(Error, "Not a matrix", load());
}

}  // namespace
}  // namespace espalier::petsc

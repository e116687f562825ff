// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/petsc/distributed_table.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "errors.h"

namespace espalier::petsc {

OwnedRange evenRange(Offset total, int rank, int size) {
    if (total < 0 || rank < 0 || rank >= size)
        throw Error(concat("cannot split ", total, " for rank ", rank, " of ", size));
    const Offset each = total / size, more = total % size;
    const Offset first = each * rank + std::min<Offset>(rank, more);
    return {first, first + each + (rank < more ? 1 : 0)};
}

namespace {

using stencils::StencilTable;

static_assert(std::is_same_v<PetscScalar, double>, "takes a PETSc of real double scalars");

constexpr Offset kMaxPetscInt = std::numeric_limits<PetscInt>::max();

PetscInt toPetscInt(Offset value) {
    return static_cast<PetscInt>(value);
}

void checkPetscInt(Offset value, const std::string& what) {
    if (value > kMaxPetscInt)
        throw Error(
            concat(value, " ", what, "; PETSc's integers have ", 8 * sizeof(PetscInt), " bits"));
}

void checkInitialised() {
    PetscBool initialised = PETSC_FALSE;
    PetscInitialized(&initialised);
    if (!initialised)
        throw Error("PETSc is not initialised: call PetscInitialize() before spreading a table");
}

/// Checks the arguments of one rank, without communication.
void checkOwn(const StencilTable<double>& rows, Offset ownVertexCount, int components,
              int componentsOfRank0) {
    if (components < 1)
        throw Error(concat("the number of components is ", components, "; expected 1 or more"));
    if (components != componentsOfRank0)
        throw Error(concat("got ", components, " components, rank 0 has ", componentsOfRank0));
    if (ownVertexCount < 0)
        throw Error(
            concat("the number of own vertices is ", ownVertexCount, "; expected 0 or more"));
    checkPetscInt(rows.entryCount(), "entries on one rank");
    for (Index row = 0; row < rows.rowCount(); ++row)
        for (const double weight : rows.weights(row))
            if (!std::isfinite(weight))
                throw Error(
                    concat("row ", row, " has a weight of ", weight, "; expected finite weights"));
}

/// Returns the range of this rank, given the count of each rank.
OwnedRange rangeOf(MPI_Comm comm, Offset count) {
    std::int64_t last = 0;
    const std::int64_t own = count;
    checkMpi(MPI_Scan(&own, &last, 1, MPI_INT64_T, MPI_SUM, comm));
    return {last - count, last};
}

Offset sumOf(MPI_Comm comm, Offset count) {
    std::int64_t sum = count;
    checkMpi(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_INT64_T, MPI_SUM, comm));
    return sum;
}

/// The offsets and columns of rows as PETSc's integers; columns are copied only if the integer
/// types differ.
template <class Integer>
struct IntegersOf {
    explicit IntegersOf(const StencilTable<double>& rows)
        : offsets(rows.offsets().begin(), rows.offsets().end()) {
        if constexpr (std::is_same_v<Integer, Index>) {
            columns = rows.columns();
        } else {
            ownColumns.assign(rows.columns().begin(), rows.columns().end());
            columns = ownColumns;
        }
    }

    Array<Integer> offsets, ownColumns;
    std::span<const Integer> columns;
};

/// While this object exists, a PETSc vector without memory of its own uses an array of the caller.
class PlacedVector {
public:
    PlacedVector(const ErrorCapture& errors, Vec vector, std::span<const double> values)
        : vector_(vector) {
        errors.check(VecPlaceArray(vector, values.data()));
    }
    ~PlacedVector() { VecResetArray(vector_); }
    PlacedVector(const PlacedVector&) = delete;
    PlacedVector& operator=(const PlacedVector&) = delete;

private:
    Vec vector_;
};

void checkSize(std::size_t got, Offset count, int components, const char* what) {
    if (got != count * static_cast<std::size_t>(components))
        throw Error(concat("got ", got, " numbers for ", count, " ", what, " of ", components,
                           " components"));
}

}  // namespace

// After PetscFinalize() there is nothing left to free.
void DistributedTable::Destroy::operator()(Mat matrix) const {
    PetscBool initialised = PETSC_FALSE;
    PetscInitialized(&initialised);
    if (initialised) MatDestroy(&matrix);
}

void DistributedTable::Destroy::operator()(Vec vector) const {
    PetscBool initialised = PETSC_FALSE;
    PetscInitialized(&initialised);
    if (initialised) VecDestroy(&vector);
}

DistributedTable::DistributedTable(MPI_Comm comm, const StencilTable<double>& ownRows,
                                   Offset ownVertexCount, int components)
    : components_(components) {
    checkInitialised();
    int componentsOfRank0 = components;
    checkMpi(MPI_Bcast(&componentsOfRank0, 1, MPI_INT, 0, comm));
    checkOnAllRanks(comm,
                    [&] { checkOwn(ownRows, ownVertexCount, components, componentsOfRank0); });

    ownPoints_ = rangeOf(comm, ownRows.rowCount());
    ownVertices_ = rangeOf(comm, ownVertexCount);
    pointCount_ = sumOf(comm, ownRows.rowCount());
    vertexCount_ = sumOf(comm, ownVertexCount);
    std::optional<IntegersOf<PetscInt>> integers;
    checkOnAllRanks(comm, [&] {
        if (ownRows.columnCount() != vertexCount_)
            throw Error(concat("the rows are over ", ownRows.columnCount(),
                               " vertices; the ranks own ", vertexCount_));
        checkPetscInt(pointCount_ * components, "components of points");
        checkPetscInt(vertexCount_ * components, "components of vertices");
        integers.emplace(ownRows);
    });

    const ErrorCapture errors;
    // The type is MATAIJ and not MATMPIAIJ, because MatCreateMAIJ on one rank assumes a MATSEQAIJ
    // without checking.
    Mat matrix = nullptr;
    errors.check(MatCreate(comm, &matrix));
    matrix_.reset(matrix);
    errors.check(MatSetSizes(matrix, ownRows.rowCount(), toPetscInt(ownVertexCount),
                             toPetscInt(pointCount_), toPetscInt(vertexCount_)));
    errors.check(MatSetType(matrix, MATAIJ));
    // MATAIJ becomes MATSEQAIJ on one rank and MATMPIAIJ on several. Each of these two calls does
    // nothing for a matrix of the other type.
    errors.check(MatSeqAIJSetPreallocationCSR(matrix, integers->offsets.data(),
                                              integers->columns.data(), ownRows.weights().data()));
    errors.check(MatMPIAIJSetPreallocationCSR(matrix, integers->offsets.data(),
                                              integers->columns.data(), ownRows.weights().data()));
    integers.reset();
    Mat blocked = nullptr;
    errors.check(MatCreateMAIJ(matrix, components, &blocked));
    blocked_.reset(blocked);
    PetscInt ghosts = 0;
    errors.check(MatGetGhosts(matrix, &ghosts, nullptr));
    ghostCount_ = ghosts;

    const auto makeVector = [&](Owned<Vec>& owned, Offset own, Offset all) {
        Vec vector = nullptr;
        errors.check(VecCreateMPIWithArray(comm, components, toPetscInt(own * components),
                                           toPetscInt(all * components), nullptr, &vector));
        owned.reset(vector);
    };
    makeVector(points_, ownPoints_.count(), pointCount_);
    makeVector(vertices_, ownVertices_.count(), vertexCount_);
}

void DistributedTable::evaluate(std::span<const double> ownVertexValues,
                                std::span<double> ownPointValues,
                                std::span<const double> ownAddend) {
    checkOnAllRanks(PetscObjectComm(reinterpret_cast<PetscObject>(matrix())), [&] {
        checkSize(ownVertexValues.size(), ownVertices_.count(), components_, "vertices");
        checkSize(ownPointValues.size(), ownPoints_.count(), components_, "points");
        if (!ownAddend.empty())
            checkSize(ownAddend.size(), ownPoints_.count(), components_, "points of the addend");
    });
    {
        const ErrorCapture errors;
        const PlacedVector source(errors, vertices_.get(), ownVertexValues);
        const PlacedVector destination(errors, points_.get(), ownPointValues);
        errors.check(MatMult(blocked(), vertices_.get(), points_.get()));
    }
    for (std::size_t i = 0; i < ownAddend.size(); ++i) ownPointValues[i] += ownAddend[i];
}

void DistributedTable::evaluateAdjoint(std::span<const double> ownPointGradients,
                                       std::span<double> ownVertexGradients) {
    checkOnAllRanks(PetscObjectComm(reinterpret_cast<PetscObject>(matrix())), [&] {
        checkSize(ownPointGradients.size(), ownPoints_.count(), components_, "points");
        checkSize(ownVertexGradients.size(), ownVertices_.count(), components_, "vertices");
    });
    const ErrorCapture errors;
    const PlacedVector source(errors, points_.get(), ownPointGradients);
    const PlacedVector destination(errors, vertices_.get(), ownVertexGradients);
    errors.check(MatMultTranspose(blocked(), points_.get(), vertices_.get()));
}

}  // namespace espalier::petsc

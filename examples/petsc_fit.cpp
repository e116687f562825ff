// SPDX-License-Identifier: Apache-2.0
//
// Fits a lattice to where the points of a model are wanted, over several machines:
//
//     espalier stencils LATTICE --points MODEL -n 2 -o D.petsc
//     mpirun -n 2 petsc_fit D.petsc REST.txt WANTED.txt OUT.txt
//
// REST and WANTED have a line "x y z" for each point of the model, and so has OUT: where the points
// go when the lattice moves by d, the smallest of those that make |D d − (wanted − rest)| least.
// Points outside the lattice stay where they are.

#include <petscksp.h>

#include <array>
#include <fstream>
#include <iomanip>
#include <string>

namespace {

constexpr PetscInt kXyz = 3;

/// Each rank reads its own lines into its part of the vector.
PetscErrorCode readPoints(const std::string& path, Vec points) {
    PetscFunctionBeginUser;
    PetscInt first = 0, last = 0;
    PetscCall(VecGetOwnershipRange(points, &first, &last));
    PetscScalar* values = nullptr;
    PetscCall(VecGetArray(points, &values));
    std::ifstream in(path);
    std::string line;
    for (PetscInt i = 0; i < first / kXyz; ++i) std::getline(in, line);
    for (PetscInt i = 0; i < last - first; ++i) in >> values[i];
    const bool complete = static_cast<bool>(in);
    PetscCall(VecRestoreArray(points, &values));
    PetscCheck(complete, PETSC_COMM_SELF, PETSC_ERR_FILE_READ, "%s: expected x y z for each point",
               path.c_str());
    PetscFunctionReturn(0);
}

/// Rank 0 collects the points and writes them.
PetscErrorCode writePoints(const std::string& path, Vec points) {
    PetscFunctionBeginUser;
    VecScatter toFirst = nullptr;
    Vec all = nullptr;
    PetscCall(VecScatterCreateToZero(points, &toFirst, &all));
    PetscCall(VecScatterBegin(toFirst, points, all, INSERT_VALUES, SCATTER_FORWARD));
    PetscCall(VecScatterEnd(toFirst, points, all, INSERT_VALUES, SCATTER_FORWARD));
    PetscInt count = 0;
    PetscCall(VecGetLocalSize(all, &count));
    const PetscScalar* values = nullptr;
    PetscCall(VecGetArrayRead(all, &values));
    if (count > 0) {
        std::ofstream out(path);
        out << std::setprecision(17);
        for (PetscInt i = 0; i < count; ++i) out << values[i] << (i % kXyz == 2 ? '\n' : ' ');
    }
    PetscCall(VecRestoreArrayRead(all, &values));
    PetscCall(VecDestroy(&all));
    PetscCall(VecScatterDestroy(&toFirst));
    PetscFunctionReturn(0);
}

PetscErrorCode fit(const std::array<std::string, 4>& paths) {
    PetscFunctionBeginUser;
    // D, its rows spread over the ranks; and D for each of x, y and z.
    PetscViewer viewer = nullptr;
    Mat matrix = nullptr, blocked = nullptr;
    PetscCall(PetscViewerBinaryOpen(PETSC_COMM_WORLD, paths[0].c_str(), FILE_MODE_READ, &viewer));
    PetscCall(MatCreate(PETSC_COMM_WORLD, &matrix));
    PetscCall(MatSetType(matrix, MATAIJ));
    PetscCall(MatLoad(matrix, viewer));
    PetscCall(PetscViewerDestroy(&viewer));
    PetscCall(MatCreateMAIJ(matrix, kXyz, &blocked));

    Vec displacements = nullptr, rest = nullptr, misses = nullptr;
    PetscCall(MatCreateVecs(blocked, &displacements, &rest));
    PetscCall(VecDuplicate(rest, &misses));
    PetscCall(readPoints(paths[1], rest));
    PetscCall(readPoints(paths[2], misses));
    PetscCall(VecAXPY(misses, -1, rest));

    // LSQR from 0 finds the smallest solution, and takes only products with D and its transpose.
    KSP solver = nullptr;
    PC preconditioner = nullptr;
    PetscCall(KSPCreate(PETSC_COMM_WORLD, &solver));
    PetscCall(KSPSetType(solver, KSPLSQR));
    PetscCall(KSPSetOperators(solver, blocked, blocked));
    PetscCall(KSPGetPC(solver, &preconditioner));
    PetscCall(PCSetType(preconditioner, PCNONE));
    PetscCall(KSPSetTolerances(solver, 1e-12, 1e-14, PETSC_DEFAULT, 10'000));
    PetscCall(KSPSetErrorIfNotConverged(solver, PETSC_TRUE));
    PetscCall(KSPSetFromOptions(solver));
    PetscCall(KSPSolve(solver, misses, displacements));

    PetscCall(MatMultAdd(blocked, displacements, rest, rest));
    PetscCall(writePoints(paths[3], rest));
    PetscCall(KSPDestroy(&solver));
    for (Vec* vector : {&displacements, &rest, &misses}) PetscCall(VecDestroy(vector));
    PetscCall(MatDestroy(&blocked));
    PetscCall(MatDestroy(&matrix));
    PetscFunctionReturn(0);
}

}  // namespace

int main(int count, char** arguments) {
    PetscCall(PetscInitialize(&count, &arguments, nullptr, nullptr));
    PetscCheck(count >= 5, PETSC_COMM_WORLD, PETSC_ERR_USER_INPUT,
               "usage: petsc_fit D.petsc REST.txt WANTED.txt OUT.txt");
    PetscCall(fit({arguments[1], arguments[2], arguments[3], arguments[4]}));
    PetscCall(PetscFinalize());
    return 0;
}

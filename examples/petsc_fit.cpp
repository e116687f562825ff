// SPDX-License-Identifier: Apache-2.0
//
// Fits a lattice to wanted positions of the points of a model, over several ranks of MPI:
//
//     mpirun -n 2 petsc_fit MODEL REST WANTED OUT POSE
//
// WANTED is the model with its points at the wanted positions. The displacement d of the lattice
// REST minimises |D d − (wanted − rest)|; of several minimisers it is the smallest. The moved
// lattice is written to POSE, and the model that it carries to OUT. Points outside the lattice stay
// where they are.
//
// Each rank binds its share of the points, and has no other rows of D. (But each rank reads both
// files completely: a program for models larger than one machine's memory would read its own part.)

#include <espalier/base/error.h>
#include <espalier/base/parallel.h>
#include <espalier/bind/bind.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <espalier/petsc/distributed_table.h>
#include <petscksp.h>

#include <algorithm>
#include <exception>
#include <iostream>
#include <span>
#include <string>
#include <vector>

using namespace espalier;

namespace {

constexpr int kLevel = 2;

struct Paths {
    std::string model, rest, wanted, out, pose;
};

struct Ranks {
    int rank = 0, size = 1;

    template <class Value>
    std::span<const Value> ownPart(std::span<const Value> all) const {
        const auto own = petsc::evenRange(static_cast<Offset>(all.size()), rank, size);
        return all.subspan(own.first, own.count());
    }
};

std::span<const double> numbersOf(std::span<const Point3> points) {
    return {points.data()->data(), 3 * points.size()};
}

/// \param misses 3 numbers for each point of the rank
/// \param moves receives 3 numbers for each vertex of the rank
PetscErrorCode leastSquares(const petsc::DistributedTable& table, std::span<const double> misses,
                            std::vector<double>& moves) {
    PetscFunctionBeginUser;
    Vec right = nullptr, solution = nullptr;
    PetscCall(MatCreateVecs(table.blocked(), &solution, &right));
    PetscScalar* values = nullptr;
    PetscCall(VecGetArrayWrite(right, &values));
    std::copy(misses.begin(), misses.end(), values);
    PetscCall(VecRestoreArrayWrite(right, &values));

    // LSQR, started from 0, finds the smallest solution, and needs only products with D and its
    // transpose.
    KSP solver = nullptr;
    PC preconditioner = nullptr;
    PetscCall(KSPCreate(PETSC_COMM_WORLD, &solver));
    PetscCall(KSPSetType(solver, KSPLSQR));
    PetscCall(KSPSetOperators(solver, table.blocked(), table.blocked()));
    PetscCall(KSPGetPC(solver, &preconditioner));
    PetscCall(PCSetType(preconditioner, PCNONE));
    PetscCall(KSPSetTolerances(solver, 1e-12, 1e-14, PETSC_DEFAULT, 10'000));
    PetscCall(KSPSetErrorIfNotConverged(solver, PETSC_TRUE));
    PetscCall(KSPSetFromOptions(solver));
    PetscCall(KSPSolve(solver, right, solution));

    const PetscScalar* found = nullptr;
    PetscCall(VecGetArrayRead(solution, &found));
    moves.assign(found, found + 3 * table.ownVertices().count());
    PetscCall(VecRestoreArrayRead(solution, &found));
    PetscCall(KSPDestroy(&solver));
    PetscCall(VecDestroy(&right));
    PetscCall(VecDestroy(&solution));
    PetscFunctionReturn(0);
}

/// Returns the points of all ranks on rank 0, and nothing on other ranks.
std::vector<Point3> gather(const Ranks& ranks, const std::vector<double>& own, std::size_t total) {
    std::vector<Point3> all(ranks.rank == 0 ? total : 0);
    std::vector<int> counts, firsts;
    for (int rank = 0; rank < ranks.size; ++rank) {
        const auto range = petsc::evenRange(static_cast<Offset>(total), rank, ranks.size);
        counts.push_back(static_cast<int>(3 * range.count()));
        firsts.push_back(static_cast<int>(3 * range.first));
    }
    MPI_Gatherv(own.data(), static_cast<int>(own.size()), MPI_DOUBLE, all.data(), counts.data(),
                firsts.data(), MPI_DOUBLE, 0, PETSC_COMM_WORLD);
    return all;
}

PetscErrorCode fit(const Paths& paths) {
    PetscFunctionBeginUser;
    Ranks ranks;
    MPI_Comm_rank(PETSC_COMM_WORLD, &ranks.rank);
    MPI_Comm_size(PETSC_COMM_WORLD, &ranks.size);
    const auto model = io::readModel(paths.model), wanted = io::readModel(paths.wanted);
    io::refuseHeldPoints(paths.wanted, *wanted);
    const std::size_t pointCount = model->positions().size();
    if (wanted->positions().size() != pointCount)
        throw Error(paths.wanted + ": has " + std::to_string(wanted->positions().size()) +
                    " points; " + paths.model + " has " + std::to_string(pointCount));
    Lattice lattice = io::readLattice(paths.rest);
    model->checkTarget(paths.out);
    io::checkLatticeTarget(paths.pose);

    const auto ownPoints = ranks.ownPart(model->positions());
    const far::TopologyRefiner base(lattice.complex, {.marks = lattice.marks});

    const auto own = bind::bindPoints({base, lattice.positions}, ownPoints, bind::Level{kLevel});
    const auto vertices = petsc::evenRange(lattice.complex.count(0), ranks.rank, ranks.size);
    petsc::DistributedTable table(PETSC_COMM_WORLD, own.table, vertices.count());

    const auto ownWanted = numbersOf(ranks.ownPart(wanted->positions()));
    std::vector<double> misses(ownWanted.begin(), ownWanted.end()), ownMoves;
    for (std::size_t i = 0; i < misses.size(); ++i) misses[i] -= numbersOf(ownPoints)[i];
    PetscCall(leastSquares(table, misses, ownMoves));

    const auto ownRest = numbersOf(ranks.ownPart(std::span<const Point3>(lattice.positions)));
    std::vector<double> ownPose(ownRest.begin(), ownRest.end()), ownMoved(misses.size());
    for (std::size_t i = 0; i < ownPose.size(); ++i) ownPose[i] += ownMoves[i];
    // 3 numbers for each own vertex and point.
    table.evaluate(ownMoves, ownMoved, numbersOf(ownPoints));

    const auto moved = gather(ranks, ownMoved, pointCount);
    lattice.positions = gather(ranks, ownPose, lattice.positions.size());
    if (ranks.rank == 0) {
        model->write(paths.out, moved);
        io::writeLattice(paths.pose, lattice);
    }
    PetscFunctionReturn(0);
}

}  // namespace

int main(int count, char** arguments) {
    PetscCall(PetscInitialize(&count, &arguments, nullptr, nullptr));
    PetscCheck(count >= 6, PETSC_COMM_WORLD, PETSC_ERR_USER_INPUT,
               "usage: petsc_fit MODEL REST WANTED OUT POSE");
    // Ranks replace threads here.
    const ThreadLimit oneThread(1);
    try {
        PetscCall(fit({arguments[1], arguments[2], arguments[3], arguments[4], arguments[5]}));
    } catch (const std::exception& error) {
        // The error may be on this rank only, while other ranks wait for it.
        std::cerr << "petsc_fit: " << error.what() << std::endl;
        MPI_Abort(PETSC_COMM_WORLD, 1);
    }
    PetscCall(PetscFinalize());
    return 0;
}

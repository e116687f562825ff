// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mpi.h>
#include <petscsys.h>

#include <exception>
#include <string>

namespace espalier::petsc {

/// While an object exists, check() throws PETSc's errors on this rank, and PETSc does not print
/// them.
class ErrorCapture {
public:
    ErrorCapture();
    ~ErrorCapture();
    ErrorCapture(const ErrorCapture&) = delete;
    ErrorCapture& operator=(const ErrorCapture&) = delete;

    /// \param code return value of a PETSc function
    /// \throws Error with PETSc's message if the code is an error
    void check(PetscErrorCode code) const;

private:
    std::string message_;
};

/// \throws Error with MPI's message if the code is an error. (MPI's default error handler ends the
///         program instead.)
void checkMpi(int code);

/// Throws on all ranks if any rank has caught an error. Collective. No rank allocates memory before
/// all ranks know of the error.
///
/// \param wrong the exception that this rank has caught; null if none
/// \throws Error on all ranks if any has caught something: "rank 2: " and the message of the lowest
///         of these ranks, up to 500 bytes
/// \cost one reduction of an int
void throwOnAllRanks(MPI_Comm comm, const std::exception_ptr& wrong);

/// Runs work that may fail on one rank only, such as checks and allocations. If it fails on some
/// rank, all ranks throw; otherwise the other ranks would go on and wait for that rank for ever.
/// Collective.
///
/// \param work throws if this rank has an error; must not be collective itself
/// \throws Error as throwOnAllRanks()
template <class Work>
void checkOnAllRanks(MPI_Comm comm, const Work& work) {
    std::exception_ptr wrong;
    try {
        work();
    } catch (...) {
        wrong = std::current_exception();
    }
    throwOnAllRanks(comm, wrong);
}

}  // namespace espalier::petsc

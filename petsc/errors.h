// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mpi.h>
#include <petscsys.h>

#include <exception>
#include <string>

namespace espalier::petsc {

/// While it lives, PETSc's errors on this rank are not printed, but thrown by check().
class ErrorCapture {
public:
    ErrorCapture();
    ~ErrorCapture();
    ErrorCapture(const ErrorCapture&) = delete;
    ErrorCapture& operator=(const ErrorCapture&) = delete;

    /// \param code what a function of PETSc returned
    /// \throws Error with PETSc's message, unless all went well
    void check(PetscErrorCode code) const;

private:
    std::string message_;
};

/// \throws Error with MPI's message, unless all went well. (Where the communicator's error handler
///         is that which MPI starts with, MPI ends the program itself.)
void checkMpi(int code);

/// Throws on all ranks what was thrown on any. Collective; allocates nothing before all know.
///
/// \param wrong what this rank has caught; null where all is well
/// \throws Error on all ranks, where any has caught something: "rank 2: ", and what the lowest of
///         those has to say, of which 500 bytes are sent
/// \cost one reduction of an int
void throwOnAllRanks(MPI_Comm comm, const std::exception_ptr& wrong);

/// Does on each rank what only that rank may fail at (its checks, its allocations), so that none
/// goes on to wait for one that threw. Collective.
///
/// \param work throws what is wrong on this rank; must not itself be collective
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

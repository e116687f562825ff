// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <petscsys.h>

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

}  // namespace espalier::petsc

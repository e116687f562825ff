// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>

#include "error_capture.h"

namespace espalier::petsc {
namespace {

/// An error is told where it arises, and again by each function that it passes through.
PetscErrorCode keepMessage(MPI_Comm, int, const char* function, const char*, PetscErrorCode code,
                           PetscErrorType type, const char* message, void* context) {
    if (type != PETSC_ERROR_INITIAL) return code;
    auto& kept = *static_cast<std::string*>(context);
    kept = message ? message : "";
    if (function) kept += std::string(" (in ") + function + ")";
    return code;
}

}  // namespace

ErrorCapture::ErrorCapture() {
    if (PetscPushErrorHandler(keepMessage, &message_)) throw Error("PETSc takes no error handler");
}

ErrorCapture::~ErrorCapture() {
    PetscPopErrorHandler();
}

void ErrorCapture::check(PetscErrorCode code) const {
    if (!code) return;
    const char* text = nullptr;
    PetscErrorMessage(code, &text, nullptr);
    throw Error("PETSc, error " + std::to_string(static_cast<int>(code)) + ": " +
                (text ? text : "unknown") + (message_.empty() ? "" : ": ") + message_);
}

void checkMpi(int code) {
    if (code == MPI_SUCCESS) return;
    std::string text(MPI_MAX_ERROR_STRING, '\0');
    int length = 0;
    MPI_Error_string(code, text.data(), &length);
    text.resize(length);
    throw Error("MPI: " + text);
}

}  // namespace espalier::petsc

// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>

#include <array>
#include <cstring>
#include <new>
#include <string>

#include "errors.h"

namespace espalier::petsc {
namespace {

/// Keeps the first message of an error: PETSc reports an error where it occurs, and again in each
/// function on the way out.
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
    throw Error(concat("PETSc, error ", static_cast<int>(code), ": ", text ? text : "unknown",
                       message_.empty() ? "" : ": ", message_));
}

void checkMpi(int code) {
    if (code == MPI_SUCCESS) return;
    std::string text(MPI_MAX_ERROR_STRING, '\0');
    int length = 0;
    MPI_Error_string(code, text.data(), &length);
    text.resize(length);
    throw Error("MPI: " + text);
}

namespace {

/// A text of fixed size: the error may be lack of memory, so the text must not allocate any.
using ErrorText = std::array<char, 501>;

ErrorText errorTextOf(const std::exception_ptr& wrong) {
    ErrorText result{};
    const auto keep = [&](const char* text) {
        std::strncpy(result.data(), text, result.size() - 1);
    };
    try {
        std::rethrow_exception(wrong);
    } catch (const std::bad_alloc&) {
        keep("out of memory");
    } catch (const std::exception& error) {
        keep(error.what());
    } catch (...) {
        keep("an exception of no known type");
    }
    return result;
}

}  // namespace

void throwOnAllRanks(MPI_Comm comm, const std::exception_ptr& wrong) {
    int rank = 0, size = 0;
    checkMpi(MPI_Comm_rank(comm, &rank));
    checkMpi(MPI_Comm_size(comm, &size));
    int failedRank = wrong ? rank : size;
    checkMpi(MPI_Allreduce(MPI_IN_PLACE, &failedRank, 1, MPI_INT, MPI_MIN, comm));
    if (failedRank == size) return;

    ErrorText text = rank == failedRank ? errorTextOf(wrong) : ErrorText{};
    checkMpi(MPI_Bcast(text.data(), static_cast<int>(text.size()), MPI_CHAR, failedRank, comm));
    throw Error(concat("rank ", failedRank, ": ", text.data()));
}

}  // namespace espalier::petsc

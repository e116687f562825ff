// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/petsc/agreement.h>
#include <espalier/petsc/error_capture.h>

#include <exception>
#include <string>

namespace espalier::petsc {

void checkOnAllRanks(MPI_Comm comm, const std::function<void()>& check) {
    int rank = 0, size = 0;
    checkMpi(MPI_Comm_rank(comm, &rank));
    checkMpi(MPI_Comm_size(comm, &size));
    std::string complaint;
    int complaining = size;
    try {
        check();
    } catch (const std::exception& error) {
        complaint = error.what();
        complaining = rank;
    }
    checkMpi(MPI_Allreduce(MPI_IN_PLACE, &complaining, 1, MPI_INT, MPI_MIN, comm));
    if (complaining == size) return;

    auto length = static_cast<int>(complaint.size());
    checkMpi(MPI_Bcast(&length, 1, MPI_INT, complaining, comm));
    complaint.resize(static_cast<std::size_t>(length));
    checkMpi(MPI_Bcast(complaint.data(), length, MPI_CHAR, complaining, comm));
    throw Error("rank " + std::to_string(complaining) + ": " + complaint);
}

}  // namespace espalier::petsc

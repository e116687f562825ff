// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mpi.h>

#include <functional>

namespace espalier::petsc {

/// Checks on each rank what only that rank sees, so that none goes on to wait for one that threw.
/// Collective.
///
/// \param check throws what is wrong on this rank
/// \throws Error on all ranks, where it throws on any: "rank 2: ", and what the lowest of those
///         that threw has to say
/// \cost one reduction of an int
void checkOnAllRanks(MPI_Comm comm, const std::function<void()>& check);

}  // namespace espalier::petsc

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/api.h>
#include <espalier/stencils/stencil_table.h>

#include <filesystem>

namespace espalier::io {

/// The integers of the PETSc that is to read a file: a build has one kind (--with-64-bit-indices).
enum class PetscInt { Bits32, Bits64 };

/// Writes a table as PETSc's MatView writes a sparse matrix to a binary viewer, for MatLoad with
/// any number of ranks: big-endian, weights in double precision.
///
/// \throws Error if the integers do not hold the number of entries, or if a weight is not finite,
///         naming the row; FileError if the file cannot be written
template <class Real>
ESPALIER_API void writePetscBinary(const std::filesystem::path& path,
                                   const stencils::StencilTable<Real>& table,
                                   PetscInt integers = PetscInt::Bits32);

}  // namespace espalier::io

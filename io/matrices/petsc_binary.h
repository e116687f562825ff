// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/stencils/stencil_table.h>

#include <filesystem>
#include <string_view>

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

/// Reads a sparse matrix that PETSc's MatView wrote to a binary viewer, with integers of either
/// kind: the first number of the file, which is the same in all, tells which. The columns of a row
/// may come in any order; one that comes twice is an error. A file of several objects, of a dense
/// matrix, or by a PETSc of other scalars than double, is refused.
///
/// \param path for messages
/// \param bytes the whole file
/// \throws FileError if the file is malformed or of another kind, if it is not as long as it says
///         (before memory is taken for what it claims), or if a weight is not finite; it names the
///         row, counted from 0
/// \cost   the file and the table in memory
ESPALIER_API stencils::StencilTable<double> readPetscBinary(const std::filesystem::path& path,
                                                            std::string_view bytes);

}  // namespace espalier::io

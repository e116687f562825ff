// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/stencils/stencil_table.h>

#include <filesystem>
#include <string_view>

namespace espalier::io {

/// The size of integers in the PETSc that will read a file. A build of PETSc has one size
/// (--with-64-bit-indices).
enum class PetscInt { Bits32, Bits64 };

/// Writes a table for PETSc's MatLoad, with any number of ranks, in the way that MatView writes a
/// sparse matrix to a binary viewer: big-endian, weights in double precision.
///
/// \throws Error if the integers cannot hold the number of entries, or if a weight is not finite,
///         naming the row; FileError if the file cannot be written
template <class Real>
ESPALIER_API void writePetscBinary(const std::filesystem::path& path,
                                   const stencils::StencilTable<Real>& table,
                                   PetscInt integers = PetscInt::Bits32);

/// Reads a sparse matrix that PETSc's MatView wrote to a binary viewer. The integers may have 32 or
/// 64 bits; the first number of the file tells which, since all files begin with the same number.
/// The columns of a row may be in any order, and duplicates are an error. Files with several
/// objects, dense matrices, or scalars other than double are refused.
///
/// \param path for messages
/// \param bytes the whole file
/// \throws FileError if the file is malformed or of another kind, if its length is not what its
///         header says (before memory is allocated for the claimed sizes), or if a weight is not
///         finite; the message names the row, counted from 0
/// \cost memory for the file and the table
ESPALIER_API stencils::StencilTable<double> readPetscBinary(const std::filesystem::path& path,
                                                            std::string_view bytes);

}  // namespace espalier::io

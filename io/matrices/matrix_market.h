// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/stencils/stencil_table.h>

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace espalier::io {

/// Writes a table in the Matrix Market exchange format: a "matrix coordinate real general" of one
/// row a stencil and one column a source.
///
/// Entries are in the order of the table, and count from 1. A weight, of either precision, is
/// written as the shortest text that reads back as the same double, so that a reader of doubles
/// gets exactly the weights of the table.
///
/// \param comments lines for the head of the file; one with line ends becomes several
/// \throws Error if a weight is not finite, naming the row; FileError if the file cannot be written
template <class Real>
ESPALIER_API void writeMatrixMarket(const std::filesystem::path& path,
                                    const stencils::StencilTable<Real>& table,
                                    std::span<const std::string> comments = {});

extern template void writeMatrixMarket(const std::filesystem::path&,
                                       const stencils::StencilTable<float>&,
                                       std::span<const std::string>);
extern template void writeMatrixMarket(const std::filesystem::path&,
                                       const stencils::StencilTable<double>&,
                                       std::span<const std::string>);

/// Reads a "matrix coordinate real general" or "integer general" as a table. Entries may come in
/// any order; an entry that comes twice is an error, not a sum.
///
/// \param path for messages
/// \param bytes the whole file
/// \throws FileError with the line, if the file is malformed or of another kind, if it has more or
/// fewer entries than it claims, if a weight is not finite, if an integer is not a double; also if
/// it claims rows by the million where it has not as many bytes
/// \cost   24 bytes an entry while reading; O(entries · log entries) where they are not in order
ESPALIER_API stencils::StencilTable<double> readMatrixMarket(const std::filesystem::path& path,
                                                             std::string_view bytes);

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/stencils/stencil_table.h>

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace espalier::io {

/// Writes a table in the Matrix Market exchange format, as a "matrix coordinate real general" with
/// one row per stencil and one column per source.
///
/// Entries are in the order of the table, and their rows and columns count from 1. A weight of
/// either precision is written as the shortest text that reads back as the same double, so that a
/// reader of doubles gets exactly the weights of the table.
///
/// \param comments lines for the head of the file; a text with line ends becomes several lines
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

/// Reads a "matrix coordinate real general" or "integer general" as a table. Entries may be in any
/// order. Duplicate entries are an error; they are not summed.
///
/// \param path for messages
/// \param bytes the whole file
/// \throws FileError with the line, if the file is malformed or of another kind, if it has more or
///         fewer entries than it claims, if a weight is not finite, if a double cannot hold an
///         integer; also if it claims millions of rows and has fewer bytes than rows
/// \cost 24 bytes per entry while reading; O(entries · log entries) if entries are not in order
ESPALIER_API stencils::StencilTable<double> readMatrixMarket(const std::filesystem::path& path,
                                                             std::string_view bytes);

}  // namespace espalier::io

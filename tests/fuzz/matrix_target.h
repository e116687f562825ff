// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/matrices/matrix_file.h>
#include <espalier/io/matrices/matrix_market.h>

#include "fuzz_target.h"
#include "written.h"

namespace espalier::fuzz {

/// Requires that a matrix is refused, or is the same after writing and reading it.
/// \param name file name, whose extension gives the format
inline void runMatrix(const std::string& name, std::string_view bytes) {
    const auto table = readResult(name, [&] { return io::readMatrix(name, bytes); });
    if (!table) return;
    const std::string once =
        written(name, [&](const auto& path) { io::writeMatrix(path, *table); });
    require(io::readMatrix(name, once) == *table, "a matrix comes back");
}

}  // namespace espalier::fuzz

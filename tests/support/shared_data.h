// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <filesystem>

namespace espalier::test {

/// Returns the folder of models, lattices and surfaces beside the repository, or the folder that
/// the environment variable ESPALIER_SHARED_DATA names. If the folder is missing, tests that need
/// it say so and are skipped.
inline std::filesystem::path sharedData() {
    const char* given = std::getenv("ESPALIER_SHARED_DATA");
    return given != nullptr ? std::filesystem::path(given)
                            : std::filesystem::path(ESPALIER_SOURCE_DIR) / "../shared/data";
}

}  // namespace espalier::test

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

namespace espalier::cli {

/// Refuses outputs of one command that are one file, by way of links: all but the last written
/// would be lost. Devices and pipes may take several outputs.
/// \throws io::FileError naming two such outputs
void checkDistinct(const std::vector<std::filesystem::path>& outputs);

}  // namespace espalier::cli

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/files/file.h>

#include <filesystem>
#include <functional>
#include <string>

#include "support/temporary_folder.h"

namespace espalier::fuzz {

/// Returns the bytes of the file that `write` makes, in a temporary folder.
inline std::string written(const std::string& name,
                           const std::function<void(const std::filesystem::path&)>& write) {
    static const test::TemporaryFolder folder;
    write(folder / name);
    return io::readFile(folder / name);
}

}  // namespace espalier::fuzz

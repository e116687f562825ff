// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace espalier::cli {

/// The files that a model names.
struct Companions {
    std::vector<std::filesystem::path> files;  ///< each once, in the order of the model
    std::vector<std::string> missing;          ///< names of files that are not there
};

/// Finds the files beside a model that belong to it: the .mtl of an .obj and the pictures that it
/// names, and the buffers and the pictures of a .gltf. Other formats name none.
/// \param path of the model
/// \param bytes of the model
/// \throws io::FileError for an .mtl that cannot be read
Companions findCompanions(const std::filesystem::path& path, std::string_view bytes);

}  // namespace espalier::cli

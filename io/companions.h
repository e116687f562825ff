// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace espalier::io {

/// A file that belongs to a model.
struct Companion {
    std::string name;            ///< its path from the folder of the model, with "/"
    std::filesystem::path file;  ///< where it is
};

/// The files that a model names.
struct Companions {
    std::vector<Companion> files;      ///< each once, in the order of the model
    std::vector<std::string> missing;  ///< names of files that are not there; each once
};

/// Finds the files that belong to a model: the .mtl of an .obj and the pictures that it names, and
/// the buffers and the pictures of a .gltf. Other formats name none.
///
/// Only files in the folder of the model and below it are found, and only .mtl, .bin and pictures
/// that browsers show: a model of somebody else may name any file. Folders that a model names do
/// not count if the file is beside the model, nor do capital letters if there is no other file.
/// \param path of the model
/// \param bytes of the model
/// \throws FileError for an .mtl that cannot be read
/// \cost one pass over the model and each .mtl; a list of the folder, if a file is missing
ESPALIER_API Companions findCompanions(const std::filesystem::path& path, std::string_view bytes);

}  // namespace espalier::io

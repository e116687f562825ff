// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

namespace espalier::io {

/// Throws if CGNS's library must not read a file: if the file is cut short, or if it makes the
/// library open other files, by a link or by data that HDF5 stores elsewhere. The library trusts
/// the header of an ADF file, and may abort if it is not whole.
///
/// \param shown path for messages
/// \param bytes the whole file
/// \param path of a file with these bytes
/// \throws FileError naming the node that is stored elsewhere
void checkCgnsFile(const std::filesystem::path& shown, std::string_view bytes, const char* path);

}  // namespace espalier::io

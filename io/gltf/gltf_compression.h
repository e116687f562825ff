// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace espalier::io {

class GltfFile;

/// Replaces the compressed meshes (KHR_draco_mesh_compression) and views (EXT_meshopt_compression)
/// of a file by plain ones, in a buffer of its own, and removes the two extensions.
///
/// Draco's decoder returns the points of a mesh in its own order, so all attributes and indices of
/// the mesh are replaced.
///
/// \throws FileError if compressed data are damaged, or if this build lacks the library; the
///         message then names the extension
void decompress(GltfFile& file);

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace espalier::io {

class GltfFile;

/// Decompresses the meshes (KHR_draco_mesh_compression) and views (EXT_meshopt_compression) of a
/// file. The file gets a buffer with the plain numbers, and loses the two extensions. The bytes of
/// the compressed views stay in their buffers.
///
/// Draco's decoder returns the points of a mesh in its own order. The attributes that the extension
/// names and the indices are replaced together.
///
/// \throws FileError if compressed data are damaged, or if this build lacks the library; the
///         message then names the extension
void decompress(GltfFile& file);

}  // namespace espalier::io

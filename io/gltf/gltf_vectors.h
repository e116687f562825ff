// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "gltf_file.h"
#include "gltf_scene.h"

// The points and directions of the meshes that a glTF file draws. gltf_model.cpp says what they
// mean.

namespace espalier::io {

enum class GltfVectorKind { Points, Normals, Tangents };

/// Points of the model that are drawn alike, in the order of an accessor.
struct GltfBlock {
    std::size_t first = 0, count = 0;
    /// One for all points, or one per point.
    std::shared_ptr<const std::vector<Affine>> maps;

    const Affine& map(std::size_t i) const { return (*maps)[maps->size() == 1 ? 0 : i]; }
};

/// The vectors of an accessor, as one drawing uses them.
struct GltfVectors {
    std::size_t accessor = 0;
    GltfVectorKind kind = GltfVectorKind::Points;
    std::size_t block = 0;  ///< the points at which they are
    /// For the displacements of a morph target: the vectors of the mesh, to which they are added.
    std::optional<std::size_t> base = {};
    std::vector<Point3> local = {};          ///< in the mesh, plus the base
    std::vector<Point3> displacements = {};  ///< of a morph target: the numbers of the file
};

/// An attribute of a primitive or of one of its morph targets.
struct GltfUse {
    std::size_t mesh = 0, primitive = 0;
    std::optional<std::size_t> target = {};
    const char* semantic = "";
    std::size_t vectors = 0;
};

/// A mesh as nodes draw it.
struct GltfDrawnMesh {
    GltfDrawing drawing;
    std::vector<std::size_t> blocks;                  ///< per primitive: its points
    std::vector<std::optional<std::size_t>> normals;  ///< per primitive: its vectors
    std::vector<GltfUse> uses;
};

/// The meshes that the nodes of a file draw.
struct GltfScene {
    std::vector<Point3> positions;  ///< of all blocks, where they are drawn
    std::vector<GltfBlock> blocks;
    std::vector<GltfVectors> vectors;  ///< those of a mesh come before those of its morph targets
    std::vector<GltfDrawnMesh> meshes;
};

/// Reads the vectors of all drawn meshes.
/// \throws FileError if the nodes, the meshes or the accessors are malformed, or a position is not
///         finite
GltfScene readGltfScene(const GltfFile& file);

inline Point3 sum(const Point3& a, const Point3& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

inline Point3 difference(const Point3& a, const Point3& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

}  // namespace espalier::io

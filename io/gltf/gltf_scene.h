// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/deformation_gradient.h>
#include <espalier/base/point.h>

#include <cstddef>
#include <optional>
#include <vector>

#include "gltf_file.h"

// Where the nodes of a glTF file draw its meshes: the matrices of nodes (glTF 2.0 Specification,
// section 3.5.3) and of skins (section 3.7.3).

namespace espalier::io {

inline constexpr DeformationGradient kIdentity = {1, 0, 0, 0, 1, 0, 0, 0, 1};

/// An affine map x -> A x + b.
struct Affine {
    DeformationGradient linear = kIdentity;  ///< A, row by row
    Point3 translation{};                    ///< b

    friend bool operator==(const Affine&, const Affine&) = default;
};

/// Returns the map that applies `inner` first.
Affine operator*(const Affine& outer, const Affine& inner);

Point3 operator*(const DeformationGradient& matrix, const Point3& vector);
DeformationGradient operator*(const DeformationGradient& a, const DeformationGradient& b);
Point3 operator*(const Affine& map, const Point3& point);

double determinant(const DeformationGradient& matrix);

/// Returns the inverse; nothing if the matrix is singular to rounding.
std::optional<DeformationGradient> inverse(const DeformationGradient& matrix);

/// Returns the map of each node in the world.
/// \throws FileError if the nodes are no trees, or a matrix is malformed
std::vector<Affine> worldMaps(const GltfFile& file);

/// A mesh that nodes draw, all at the same place.
struct GltfDrawing {
    std::size_t mesh = 0;
    std::vector<std::size_t> nodes = {};
    std::optional<std::size_t> skin = {};
    Affine matrix = {};  ///< of the nodes in the world; unused with a skin
};

/// Returns the drawings of all nodes with a mesh, in the order of their first nodes.
/// \throws FileError if a mesh does not exist, or is drawn by EXT_mesh_gpu_instancing
/// \param world worldMaps()
std::vector<GltfDrawing> drawingsOf(const GltfFile& file, const std::vector<Affine>& world);

/// Returns the map of each joint of a skin: its matrix in the world, at rest, after its inverse
/// bind matrix.
/// \throws FileError if the skin is malformed
/// \param world worldMaps()
std::vector<Affine> jointMaps(const GltfFile& file, const std::vector<Affine>& world,
                              std::size_t skin);

/// Returns the map of each point of a primitive with a skin, the average of the maps of its joints
/// by their weights. Returns one map if all are equal.
/// \param attributes of the primitive: JOINTS_0, WEIGHTS_0 ...
/// \param count number of points
/// \throws FileError if the attributes are malformed
std::vector<Affine> skinMaps(const GltfFile& file, const std::vector<Affine>& joints,
                             const Json& attributes, std::size_t count);

}  // namespace espalier::io

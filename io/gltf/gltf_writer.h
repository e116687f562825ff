// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/io/animations/animation_file.h>

#include <filesystem>
#include <iosfwd>
#include <span>

#include "../models/surface_writers.h"

// New glTF files, for models of other formats and for animations. Vertices follow the order of the
// points; a point whose corners differ in their normals or texture coordinates becomes several
// vertices. Faces without corners of a model of points alone become points. Each material is a
// primitive.
//
// Positions are floats. If the model is small and far from the origin, they are relative to its
// centre, and the node has the centre as its translation.

namespace espalier::io {

/// Writes a surface of triangles, or of points alone.
/// \throws Error naming the point, if a coordinate exceeds the largest float; FileError if a .glb
///         would have 4 GiB or more
void writeGltfSurface(std::ostream& out, const SurfaceView& surface);

/// Writes an animation: the model at rest with a morph target for each pose.
/// \throws as writeAnimation()
void writeMorphTargets(const std::filesystem::path& path, const Model& model,
                       const Animation& animation);

/// Returns the centre to which positions in a new file are relative: zero, unless floats relative
/// to it are more precise by two bits or more.
Point3 gltfCentre(std::span<const Point3> points);

}  // namespace espalier::io

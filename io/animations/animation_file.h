// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/deformation_gradient.h>
#include <espalier/base/point.h>
#include <espalier/io/model.h>

#include <cstddef>
#include <filesystem>
#include <functional>
#include <vector>

/// \file
/// Writes the poses of a model as one file that animation programs read: point caches (.pc2, .mdd)
/// and glTF with morph targets (.glb, .gltf).
///
///     .pc2   for each frame all points, as floats; the format of 3ds Max, which Blender's modifier
///            Mesh Cache reads. Frames are numbered from 0
///     .mdd   the same, with a time for each frame; the format of LightWave
///     .glb   the model at rest, with its normals, texture coordinates, colours and materials, and
///     .gltf  one morph target per pose, which holds the movement of the points and normals. An
///            animation "poses" goes from pose to pose, one per frame. Faces of more than three
///            corners are split into triangles as at rest. glTF takes y for up and metres for
///            units; coordinates are written as they are
///
/// All coordinates are rounded to floats.

namespace espalier::io {

/// The poses of a model.
struct Animation {
    /// Returns the points of a frame, one per point of the model. Called for each frame once, in
    /// order, while the file is written.
    std::function<std::vector<Point3>(std::size_t frame)> frame;

    std::size_t frameCount = 0;
    double framesPerSecond = 24;

    /// Returns the gradients of a frame, one per point of the model, by which its normals follow.
    /// Without this function, the normals of all frames are those at rest. Only glTF has any.
    std::function<std::vector<DeformationGradient>(std::size_t frame)> gradients = {};
};

/// Returns true if poses that are written to this path become one animation. A format of models as
/// well (.glb, .gltf) takes a single pose as a model, and several poses whose numbers stand in the
/// path ("a%04d.glb") as several models.
ESPALIER_API bool isAnimation(const std::filesystem::path& path, std::size_t poseCount);

/// Returns a frame as programs that read the file see it: rounded to floats, and in a .glb the
/// sum of the rounded rest and the rounded movement. A coordinate that is too large for a float
/// becomes infinite.
ESPALIER_API std::vector<Point3> storedInAnimation(const std::filesystem::path& path,
                                                   const Model& model, std::vector<Point3> points);

/// Returns true if an animation in the format of this path has normals (glTF).
ESPALIER_API bool animationHoldsNormals(const std::filesystem::path& path);

/// Returns one line for the user, or nothing: the data of the model that the animation lacks, as
/// Model::checkTarget() names them.
/// \throws FileError as writeAnimation()
ESPALIER_API std::string lossesInAnimation(const std::filesystem::path& path, const Model& model);

/// Writes all frames, in the format that the extension names.
///
/// \throws Error if there are no frames or more than 2³¹ − 1, if framesPerSecond is not a finite
///         number above 0, if a frame does not have one finite position per point, if a coordinate
///         (or a movement in a .glb) is too large for a float, or if the times of the frames are
///         too large or too close together for floats; FileError if the extension is none of the
///         formats, if the file cannot be written, or for glTF if the file would have 4 GiB or
///         more
ESPALIER_API void writeAnimation(const std::filesystem::path& path, const Model& model,
                                 const Animation& animation);

}  // namespace espalier::io

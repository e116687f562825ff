// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/animations/animation_file.h>

#include <filesystem>
#include <span>
#include <vector>

namespace espalier::io {

/// Rounds the points of a frame to floats.
/// \throws Error unless there are `expected` points, all in the range of floats
std::vector<float> floatsOf(std::span<const Point3> points, std::size_t expected,
                            std::size_t frame);

/// Writes an animation as binary glTF 2.0 (.glb).
/// \throws as writeAnimation()
void writeMorphTargets(const std::filesystem::path& path, const Model& model,
                       const Animation& animation);

}  // namespace espalier::io

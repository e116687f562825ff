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

/// Returns true if a number rounded to a float is finite.
bool fitsFloat(double number);

/// Returns the times of the frames in seconds, ascending, rounded to floats.
/// \throws Error if floats cannot hold them, or cannot tell them apart
std::vector<float> timesOf(const Animation& animation);

/// Writes an animation as binary glTF 2.0 (.glb).
/// \throws as writeAnimation()
void writeMorphTargets(const std::filesystem::path& path, const Model& model,
                       const Animation& animation);

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/animations/animation_file.h>

#include <cstddef>
#include <span>
#include <vector>

namespace espalier::io {

/// Throws unless a frame has `expected` points whose coordinates floats can hold.
void checkFrame(std::span<const Point3> points, std::size_t expected, std::size_t frame);

/// Returns the times of the frames in seconds, ascending, rounded to floats.
/// \throws Error if floats cannot hold them, or cannot tell them apart
std::vector<float> timesOf(const Animation& animation);

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/point.h>

#include <array>
#include <bit>
#include <cstddef>
#include <filesystem>
#include <iosfwd>
#include <span>
#include <string>
#include <string_view>

// What the model formats share about the coordinates in a file: how they are read, and how they are
// put back.

namespace espalier::io {

/// How a file holds a coordinate.
enum class Precision { Float, Double };

/// Where x, y and z of one point begin among the bytes of its file.
using CoordinatePlaces = std::array<std::size_t, 3>;

/// How messages name an axis: "x", "y" or "z".
const char* axisName(std::size_t axis);

/// The value as a file of this precision holds it.
/// \throws Error naming the point, if it is beyond the largest float
double roundTo(Precision precision, double value, std::size_t point);

/// The coordinate at `place` in binary data.
/// \param point which point of the file it belongs to, for messages
/// \throws FileError if it is not finite
double loadCoordinate(std::string_view bytes, std::size_t place, Precision precision,
                      std::endian order, std::size_t axis, std::size_t point,
                      const std::filesystem::path& path);

/// Puts a coordinate that roundTo() returned into binary data.
void storeCoordinate(std::string& bytes, std::size_t place, double value, Precision precision,
                     std::endian order);

/// The coordinate that a word of text gives.
/// \param word empty where there is none
/// \throws FileError if it is not a number, or is not finite
double parseCoordinate(std::string_view word, std::size_t axis, Precision precision,
                       const std::filesystem::path& path, std::size_t line);

/// Writes `text` with the coordinates at `places` replaced by those of `now`. One that is, rounded,
/// the same as in `before` keeps its text.
///
/// All three have one entry a point; the places of a point precede those of the next.
void writeWithPositions(std::ostream& out, std::string_view text,
                        std::span<const CoordinatePlaces> places, std::span<const Point3> before,
                        std::span<const Point3> now, const std::array<Precision, 3>& precisions);

}  // namespace espalier::io

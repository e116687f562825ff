// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/io/directions.h>
#include <espalier/io/model.h>

#include <array>
#include <bit>
#include <cstddef>
#include <filesystem>
#include <iosfwd>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// Functions that all model formats use to read coordinates and directions, and to write changed
// ones.

namespace espalier::io {

class TextPatch;

/// How a file holds a coordinate.
enum class Precision { Float, Double };

inline CoordinateStorage storageOf(Precision precision) {
    return precision == Precision::Float ? CoordinateStorage::Float : CoordinateStorage::Double;
}

/// Offsets of x, y and z of one point in the bytes of its file.
using CoordinateOffsets = std::array<std::size_t, 3>;

/// Returns the name of an axis in messages: "x", "y" or "z".
ESPALIER_API const char* axisName(std::size_t axis);

/// Rounds a value to the precision of a file.
/// \param point for messages
/// \throws Error naming the point, if the value exceeds the largest float
ESPALIER_API double roundTo(Precision precision, double value, std::size_t point);

/// Rounds a coordinate to the nearest float, which may be infinite.
inline void roundToFloat(double& coordinate) {
    coordinate = static_cast<float>(coordinate);
}

/// Reads the number at an offset of binary data; it may be infinite or NaN.
double loadReal(std::string_view bytes, std::size_t offset, Precision precision, std::endian order);

/// Throws the error of a coordinate in binary data that is not finite.
/// \param point number of the point, for the message
[[noreturn]] void refuseNotFinite(std::size_t offset, std::size_t axis, std::size_t point,
                                  const std::filesystem::path& path);

/// Throws the error of a coordinate in a text that is not finite.
/// \param word its text
[[noreturn]] void refuseNotFinite(std::string_view word, std::size_t axis,
                                  const std::filesystem::path& path, std::size_t line);

/// Writes a coordinate into binary data. roundTo() must have returned it.
void storeCoordinate(std::string& bytes, std::size_t offset, double value, Precision precision,
                     std::endian order);

/// Parses a word as a number of this precision; NaN if it is no number or too large.
double parseReal(std::string_view word, Precision precision);

/// Parses a word as a coordinate, which may be infinite or NaN: HeldPoints decides about it.
/// \param word empty if the line has no more words
/// \throws FileError if the word is missing, not a number or too large
double parseCoordinate(std::string_view word, std::size_t axis, Precision precision,
                       const std::filesystem::path& path, std::size_t line);

/// Parses a word as a coordinate in double precision, whose exponent may begin with a D.
/// \throws FileError as parseCoordinate()
double parseFortranCoordinate(std::string_view word, std::size_t axis,
                              const std::filesystem::path& path, std::size_t line);

/// Returns the text of the number at an offset of a text. It was read as a number before.
std::string_view numberAt(std::string_view text, std::size_t offset);

/// Returns true if the numbers are equal, or both NaN.
bool isSame(double a, double b);

/// A change of one vector at every point of a file: its position, or a direction there. All spans
/// have one entry per point.
struct VectorChange {
    std::span<const CoordinateOffsets> offsets;  ///< where the file has the vectors
    std::span<const Point3> before;              ///< the vectors in the file
    std::span<const Point3> now;                 ///< the vectors to be written
    std::array<Precision, 3> precisions = {Precision::Double, Precision::Double, Precision::Double};

    /// Returns the rounded number to be written; nothing if it does not change.
    /// \throws Error as roundTo()
    std::optional<double> at(std::size_t point, std::size_t axis) const;
};

/// Replaces changed numbers in a text. All other numbers keep their text.
class TextChanges {
public:
    /// \param text, changes must outlive this
    /// \param dimension number of axes that the text has
    /// \cost O(points). If the text has the numbers of an axis in another order than the points, it
    ///       also sorts them
    TextChanges(std::string_view text, std::span<const VectorChange> changes,
                std::size_t dimension = 3);

    /// Replaces the changed numbers that begin before the offset `end` and follow the last call.
    /// \param patch patch of the text; it must not have gone past these numbers
    /// \throws Error as roundTo()
    /// \cost O(numbers · axes of all changes)
    void applyUpTo(TextPatch& patch, std::size_t end);

private:
    /// The numbers of one axis of a change, in the order of the text.
    struct Column {
        const VectorChange* change;
        std::size_t axis;
        std::vector<std::size_t> order = {};  ///< points; empty if they are in order
        std::size_t next = 0;

        std::size_t point() const { return order.empty() ? next : order[next]; }
        std::size_t offset() const { return change->offsets[point()][axis]; }
        bool atEnd() const { return next == change->offsets.size(); }
    };

    std::string_view text_;
    std::vector<Column> columns_;
};

/// A part of a binary file that is being written, and the points whose numbers are in it.
struct BinaryPart {
    std::string bytes;
    std::size_t begin;  ///< where the part begins in the file
    std::size_t firstPoint, endPoint;
    std::endian order;
};

/// Makes the changes of the points of a part.
/// \param dimension number of axes that the file has
void changeBinary(BinaryPart& part, std::span<const VectorChange> changes, std::size_t dimension);

/// The function that carries a direction: carryNormal() or carryTangent().
using Carry = Point3 (*)(const DeformationGradient&, const Point3&);

/// Returns true if three numbers of a file are a direction that can be carried. Returns false if
/// they are all 0, if one is NaN, or if the vector is too long for `precision`; the file then keeps
/// them.
bool isDirection(const Point3& numbers, Precision precision);

/// Carries the direction of each point by the gradient of the point. Vectors that are no direction
/// stay.
std::vector<Point3> carried(std::span<const Point3> directions,
                            std::span<const DeformationGradient> gradients, Carry carry,
                            Precision precision);

}  // namespace espalier::io

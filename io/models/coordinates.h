// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/io/directions.h>

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

// What the model formats share about the coordinates in a file: how they are read, and how they are
// put back.

// What the model formats share about the directions in a file.

namespace espalier::io {

class TextPatch;

/// How a file holds a coordinate.
enum class Precision { Float, Double };

/// Where x, y and z of one point begin among the bytes of its file.
using CoordinatePlaces = std::array<std::size_t, 3>;

/// How messages name an axis: "x", "y" or "z".
const char* axisName(std::size_t axis);

/// The value as a file of this precision holds it.
/// \throws Error naming the point, if it is beyond the largest float
double roundTo(Precision precision, double value, std::size_t point);

/// The number at `place` in binary data, finite or not.
double loadReal(std::string_view bytes, std::size_t place, Precision precision, std::endian order);

/// The coordinate at `place` in binary data.
/// \param point which point of the file it belongs to, for messages
/// \throws FileError if it is not finite
double loadCoordinate(std::string_view bytes, std::size_t place, Precision precision,
                      std::endian order, std::size_t axis, std::size_t point,
                      const std::filesystem::path& path);

/// Puts a coordinate that roundTo() returned into binary data.
void storeCoordinate(std::string& bytes, std::size_t place, double value, Precision precision,
                     std::endian order);

/// The number that a word of text gives; NaN if it gives none that the file can hold.
double parseReal(std::string_view word, Precision precision);

/// The coordinate that a word of text gives.
/// \param word empty where there is none
/// \throws FileError if it is not a number, or is not finite
double parseCoordinate(std::string_view word, std::size_t axis, Precision precision,
                       const std::filesystem::path& path, std::size_t line);

/// Whether a number stays what it was; what is none stays so.
bool isSame(double a, double b);

/// Three numbers of each point of a file, its position or a direction there: where they are, what
/// they were, and what they shall be. All have one entry a point.
struct VectorChange {
    std::span<const CoordinatePlaces> places;
    std::span<const Point3> before;
    std::span<const Point3> now;
    std::array<Precision, 3> precisions = {Precision::Double, Precision::Double, Precision::Double};

    /// The number to be written; none if, rounded, it is the same as before.
    /// \throws Error as roundTo()
    std::optional<double> at(std::size_t point, std::size_t axis) const;
};

/// Changes of a text: those of numbers in it.
class TextChanges {
public:
    /// \param text, changes must outlive this. The places of a point, those of all changes, precede
    /// those of the next, and are in the same order.
    TextChanges(std::string_view text, std::span<const VectorChange> changes);

    /// Replaces the numbers of one point that change; the others keep their text.
    /// \param patch of the text, which has not got beyond them
    void apply(TextPatch& patch, std::size_t point) const;

private:
    struct Number {
        const VectorChange* change;
        std::size_t axis;
    };

    std::string_view text_;
    std::vector<Number> numbers_;  ///< of a point, in the order of the file
};

/// Writes `text` with all changes in it.
/// \param changes at least one, as for TextChanges
void writeChanged(std::ostream& out, std::string_view text, std::span<const VectorChange> changes);

/// What a direction is, is how it is carried: carryNormal() or carryTangent().
using Carry = Point3 (*)(const DeformationGradient&, const Point3&);

/// Whether three numbers of a file are a direction: not those that are no numbers, that are all 0,
/// or that are too large to be turned. What is none is kept as it is.
bool isDirection(const Point3& numbers, Precision precision);

/// The directions of points, one each, as F of each makes them.
std::vector<Point3> carried(std::span<const Point3> directions,
                            std::span<const DeformationGradient> gradients, Carry carry,
                            Precision precision);

}  // namespace espalier::io

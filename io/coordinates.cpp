// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/io/byte_order.h>
#include <espalier/io/coordinates.h>
#include <espalier/io/file.h>
#include <espalier/io/text_output.h>
#include <espalier/io/text_reader.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace espalier::io {
namespace {

bool isTooLarge(Precision precision, double value) {
    return precision == Precision::Float && std::abs(value) > std::numeric_limits<float>::max();
}

/// The number that begins at `place`. What was read as a number holds no comment or backslash, so
/// that one of these ends it.
std::string_view numberAt(std::string_view text, std::size_t place) {
    const auto ends = [](char c) { return c <= ' ' || c == '#' || c == '\\'; };
    const auto begin = text.begin() + static_cast<std::ptrdiff_t>(place);
    return {begin, std::find_if(begin, text.end(), ends)};
}

}  // namespace

const char* axisName(std::size_t axis) {
    static constexpr std::array<const char*, 3> kNames = {"x", "y", "z"};
    return kNames[axis];
}

double roundTo(Precision precision, double value, std::size_t point) {
    if (isTooLarge(precision, value))
        throw Error("the new position of point " + std::to_string(point) + " holds " +
                    formatNumber(value) + ", which is more than the floats of its format hold");
    return precision == Precision::Float ? static_cast<float>(value) : value;
}

double loadCoordinate(std::string_view bytes, std::size_t place, Precision precision,
                      std::endian order, std::size_t axis, std::size_t point,
                      const std::filesystem::path& path) {
    const char* at = bytes.data() + place;
    const double value = precision == Precision::Float ? loadNumber<float>(at, order)
                                                       : loadNumber<double>(at, order);
    if (!std::isfinite(value))
        throw FileError(path, "byte " + std::to_string(place) + ": " + axisName(axis) +
                                  " of point " + std::to_string(point) + " is not finite");
    return value;
}

void storeCoordinate(std::string& bytes, std::size_t place, double value, Precision precision,
                     std::endian order) {
    if (precision == Precision::Float)
        storeNumber(bytes.data() + place, static_cast<float>(value), order);
    else
        storeNumber(bytes.data() + place, value, order);
}

double parseCoordinate(std::string_view word, std::size_t axis, Precision precision,
                       const std::filesystem::path& path, std::size_t line) {
    const auto fail = [&](const std::string& cause) {
        const std::string expected = std::string("; expected ") + axisName(axis) + " of a vertex";
        throw FileError(path, line, cause + expected);
    };
    double value = 0;
    if (word.empty()) fail("the line ends");
    if (!parseNumber(word, value)) fail(inQuotes(word) + " is not a number");
    if (!std::isfinite(value)) fail(inQuotes(word) + " is not finite");
    if (isTooLarge(precision, value)) fail(inQuotes(word) + " is more than a float holds");
    return precision == Precision::Float ? static_cast<float>(value) : value;
}

void writeWithPositions(std::ostream& out, std::string_view text,
                        std::span<const CoordinatePlaces> places, std::span<const Point3> before,
                        std::span<const Point3> now, const std::array<Precision, 3>& precisions) {
    TextPatch patch(out, text);
    for (std::size_t point = 0; point < places.size(); ++point) {
        std::array<std::size_t, 3> axes = {0, 1, 2};
        std::sort(axes.begin(), axes.end(), [&](std::size_t a, std::size_t b) {
            return places[point][a] < places[point][b];
        });
        for (const std::size_t axis : axes) {
            const double value = roundTo(precisions[axis], now[point][axis], point);
            if (value == before[point][axis]) continue;
            const std::string_view old = numberAt(text, places[point][axis]);
            if (precisions[axis] == Precision::Float)
                patch.replace(old, static_cast<float>(value));
            else
                patch.replace(old, value);
        }
    }
    patch.finish();
}

}  // namespace espalier::io

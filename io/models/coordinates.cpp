// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/cancellable_sort.h>
#include <espalier/base/error.h>
#include <espalier/base/parallel.h>
#include <espalier/base/vector3.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "../files/bytes.h"
#include "../files/text_output.h"
#include "coordinates.h"

namespace espalier::io {
namespace {

/// Returns true if a finite value exceeds the largest float. Infinity is not too large, since a
/// float can hold it.
bool isTooLarge(Precision precision, double value) {
    return precision == Precision::Float && std::isfinite(value) &&
           std::abs(value) > std::numeric_limits<float>::max();
}

}  // namespace

std::string_view numberAt(std::string_view text, std::size_t offset) {
    // White space, a comment, a backslash, a bracket or a comma ends the number.
    const auto ends = [](char c) {
        if ('-' <= c && c <= '9') return false;  // most bytes: digits, the point and the sign
        return c <= ' ' || c == '#' || c == '\\' || c == ')' || c == ',';
    };
    const auto begin = text.begin() + static_cast<std::ptrdiff_t>(offset);
    return text.substr(offset, std::find_if(begin, text.end(), ends) - begin);
}

const char* axisName(std::size_t axis) {
    static constexpr std::array<const char*, 3> kNames = {"x", "y", "z"};
    return kNames[axis];
}

double roundTo(Precision precision, double value, std::size_t point) {
    if (isTooLarge(precision, value))
        throw Error(concat("the new position of point ", point, " has the coordinate ",
                           formatNumber(value),
                           ", which is too large for the single precision of the file"));
    return precision == Precision::Float ? static_cast<float>(value) : value;
}

double loadReal(std::string_view bytes, std::size_t offset, Precision precision,
                std::endian order) {
    const char* at = bytes.data() + offset;
    return precision == Precision::Float ? loadNumber<float>(at, order)
                                         : loadNumber<double>(at, order);
}

void refuseNotFinite(std::size_t offset, std::size_t axis, std::size_t point,
                     const std::filesystem::path& path) {
    throw FileError(
        path, concat("byte ", offset, ": ", axisName(axis), " of point ", point, " is not finite"));
}

void refuseNotFinite(std::string_view word, std::size_t axis, const std::filesystem::path& path,
                     std::size_t line) {
    throw FileError(
        path, line,
        concat(inQuotes(word), " is not finite; expected ", axisName(axis), " of a vertex"));
}

void storeCoordinate(std::string& bytes, std::size_t offset, double value, Precision precision,
                     std::endian order) {
    if (precision == Precision::Float)
        storeNumber(bytes.data() + offset, static_cast<float>(value), order);
    else
        storeNumber(bytes.data() + offset, value, order);
}

double parseReal(std::string_view word, Precision precision) {
    double value = 0;
    if (!parseNumber(word, value) || isTooLarge(precision, value))
        return std::numeric_limits<double>::quiet_NaN();
    return precision == Precision::Float ? static_cast<float>(value) : value;
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
    if (isTooLarge(precision, value)) fail(inQuotes(word) + " is too large for single precision");
    return precision == Precision::Float ? static_cast<float>(value) : value;
}

double parseFortranCoordinate(std::string_view word, std::size_t axis,
                              const std::filesystem::path& path, std::size_t line) {
    const std::size_t letter = word.find_first_of("dD");
    double value = 0;
    if (letter != std::string_view::npos) {
        std::string text(word);
        text[letter] = 'e';
        if (parseNumber(text, value)) return value;
    }
    return parseCoordinate(word, axis, Precision::Double, path, line);
}

bool isSame(double a, double b) {
    return a == b || (std::isnan(a) && std::isnan(b));
}

std::optional<double> VectorChange::at(std::size_t point, std::size_t axis) const {
    const double old = before[point][axis];
    // Compared before rounding, because roundTo() would throw for an old value that is too large.
    if (isSame(now[point][axis], old)) return std::nullopt;
    const double value = roundTo(precisions[axis], now[point][axis], point);
    return value == old ? std::nullopt : std::optional(value);
}

TextChanges::TextChanges(std::string_view text, std::span<const VectorChange> changes,
                         std::size_t dimension)
    : text_(text) {
    for (const VectorChange& change : changes)
        for (std::size_t axis = 0; axis < dimension; ++axis) {
            Column column{&change, axis};
            const auto offsetOf = [&](std::size_t point) { return change.offsets[point][axis]; };
            std::size_t inOrder = 1;  // points, from the first, that are in the order of the text
            while (inOrder < change.offsets.size() && offsetOf(inOrder - 1) < offsetOf(inOrder))
                checkCancelledEvery(inOrder++, 16);
            if (inOrder < change.offsets.size()) {
                column.order.resize(change.offsets.size());
                std::iota(column.order.begin(), column.order.end(), std::size_t{0});
                sortCancellably(
                    column.order.begin(), column.order.end(),
                    [&](std::size_t a, std::size_t b) { return offsetOf(a) < offsetOf(b); });
            }
            columns_.push_back(std::move(column));
        }
}

void TextChanges::applyUpTo(TextPatch& patch, std::size_t end) {
    for (std::size_t count = 0;; ++count) {
        checkCancelledEvery(count, 16);
        Column* first = nullptr;
        std::size_t begin = end;
        for (Column& column : columns_)
            if (!column.atEnd() && column.offset() < begin) {
                first = &column;
                begin = column.offset();
            }
        if (!first) return;
        if (const auto value = first->change->at(first->point(), first->axis)) {
            const std::string_view old = numberAt(text_, begin);
            if (first->change->precisions[first->axis] == Precision::Float)
                patch.replace(old, static_cast<float>(*value));
            else
                patch.replace(old, *value);
        }
        ++first->next;
    }
}

void changeBinary(BinaryPart& part, std::span<const VectorChange> changes, std::size_t dimension) {
    for (const VectorChange& change : changes)
        for (std::size_t point = part.firstPoint; point < part.endPoint; ++point) {
            checkCancelledEvery(point, 14);
            for (std::size_t axis = 0; axis < dimension; ++axis)
                if (const auto value = change.at(point, axis))
                    storeCoordinate(part.bytes, change.offsets[point][axis] - part.begin, *value,
                                    change.precisions[axis], part.order);
        }
}

bool isDirection(const Point3& numbers, Precision precision) {
    const double largest = precision == Precision::Float ? std::numeric_limits<float>::max()
                                                         : std::numeric_limits<double>::max();
    // Half of the largest number, so that rounding cannot exceed it. The result is false for NaN.
    const double size = length(numbers);
    return size > 0 && size <= largest / 2;
}

std::vector<Point3> carried(std::span<const Point3> directions,
                            std::span<const DeformationGradient> gradients, Carry carry,
                            Precision precision) {
    std::vector<Point3> result(directions.begin(), directions.end());
    parallelFor(std::ssize(result), 1 << 14, [&](Offset first, Offset last) {
        for (Offset point = first; point < last; ++point)
            if (isDirection(result[point], precision))
                result[point] = carry(gradients[point], result[point]);
    });
    return result;
}

}  // namespace espalier::io

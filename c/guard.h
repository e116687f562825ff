// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/argument_error.h>
#include <espalier/base/number_text.h>
#include <espalier/base/point.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "espalier.h"

// The boundary between C and C++: turns exceptions into statuses, and checks arguments from C.
namespace espalier::c {

/// Stores the message of the exception that is being handled, for espalier_last_error().
/// \return the status of the exception
espalier_status statusOfException() noexcept;

/// Runs the body of a function of the C API. Every function that can fail uses this, so that no
/// exception leaves it.
template <class Body>
espalier_status guarded(const Body& body) noexcept {
    try {
        body();
        return ESPALIER_OK;
    } catch (...) {
        return statusOfException();
    }
}

/// Dereferences a pointer.
/// \throws Error if it is null; the message calls it `name`
template <class T>
T& deref(T* pointer, const char* name) {
    if (pointer == nullptr) throw Error(std::string(name) + " is null");
    return *pointer;
}

/// Runs a function with one result: writes what `make` returns to *out. Fails if `out` is null; the
/// message calls it `name`.
template <class Result, class Make>
espalier_status result(Result* out, const char* name, const Make& make) noexcept {
    return guarded([&] {
        Result& place = deref(out, name);
        place = make();
    });
}

/// Returns an array of `count` entities with `perEntity` values per entity.
/// \throws Error if `count` is negative or exceeds any memory, or if the array is null and not
///         empty
template <class T>
std::span<T> array(T* values, std::int64_t count, const char* name, std::int64_t perEntity = 1) {
    const std::int64_t maxCount = PTRDIFF_MAX / static_cast<std::int64_t>(sizeof(T)) / perEntity;
    if (count < 0 || count > maxCount)
        throw Error(concat(name, ": the count is ", count, "; expected 0 to ", maxCount));
    if (count > 0) deref(values, name);
    return {values, values + count * perEntity};
}

/// Checks the offsets of `count` rows and returns them.
/// \throws Error if they do not start with 0, or do not ascend
inline std::span<const std::int64_t> checkedOffsets(const std::int64_t* offsets, std::int64_t count,
                                                    const char* name) {
    array(offsets, count, name);  // refuses a count that has no successor
    const auto checked = array(offsets, count + 1, name);
    if (checked[0] != 0) throw Error(concat(name, "[0] is ", checked[0], "; expected 0"));
    for (std::size_t i = 1; i < checked.size(); ++i)
        if (checked[i] < checked[i - 1])
            throw Error(concat(name, "[", i, "] is ", checked[i], ", below the ", checked[i - 1],
                               " before it"));
    return checked;
}

/// Copies an array of positions.
/// \param count number of positions; the array has three times as many numbers
inline std::vector<Point3> positions(const double* values, std::int64_t count, const char* name) {
    array(values, count, name, 3);
    std::vector<Point3> result(count);
    if (count > 0) std::memcpy(result.data(), values, result.size() * sizeof(Point3));
    return result;
}

/// Copies an array of positions, which must be finite.
/// \throws Error that names the first position that is not: "pose[3]"
inline std::vector<Point3> finitePositions(const double* values, std::int64_t count,
                                           const char* name) {
    std::vector<Point3> result = positions(values, count, name);
    for (std::size_t i = 0; i < result.size(); ++i)
        for (const double coordinate : result[i])
            if (!std::isfinite(coordinate))
                throw Error(
                    concat(name, "[", i, "] is ", textOf(result[i]), "; expected finite numbers"));
    return result;
}

/// Returns positions as an array for C; null if there are none.
inline const double* numbers(const std::vector<Point3>& positions) {
    return positions.empty() ? nullptr : positions.front().data();
}

/// \throws Error if the two differ
inline void checkCount(std::int64_t got, std::int64_t expected, const char* what) {
    if (got != expected) throw Error(concat("got ", got, " ", what, "; expected ", expected));
}

/// Converts a number from C to the enumeration constant with the same value.
/// \param last the last constant
/// \throws Error if the value is not from 0 to `last`; the message calls it `name`
template <class Enum>
Enum choice(std::int32_t value, Enum last, const char* name) {
    if (value < 0 || value > static_cast<std::int32_t>(last))
        throw ArgumentError("", name, std::to_string(value),
                            concat("0 to ", static_cast<std::int32_t>(last)));
    return static_cast<Enum>(value);
}

/// Returns the given options, or the defaults if null. A struct of an earlier version lacks some
/// fields; these get their defaults.
///
/// \param maker the function that makes the defaults, for the message
/// \param firstSize size of the struct in its first version
/// \throws Error if the size is below firstSize or above the current size
template <class Options>
Options optionsOrDefaults(const Options* given, const Options& defaults, const char* maker,
                          std::size_t firstSize = sizeof(Options)) {
    if (given == nullptr) return defaults;
    if (given->size < firstSize || given->size > sizeof(Options))
        throw Error(concat("options of size ", given->size, "; expected ", sizeof(Options), ", as ",
                           maker, "() makes them"));
    Options options = defaults;
    std::memcpy(&options, given, given->size);
    return options;
}

}  // namespace espalier::c

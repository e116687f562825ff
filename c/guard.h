// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>
#include <espalier/base/point.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "espalier.h"

// Between C and C++: exceptions become statuses, and what comes from C is checked.
namespace espalier::c {

/// Keeps what the exception that is being handled says for espalier_last_error().
/// \return its status
espalier_status statusOfException() noexcept;

/// Every function of the C API that can fail does its work in here, so that no exception leaves it.
template <class Body>
espalier_status guarded(const Body& body) noexcept {
    try {
        body();
        return ESPALIER_OK;
    } catch (...) {
        return statusOfException();
    }
}

/// \throws Error if it is null, calling it `name`
template <class T>
T& deref(T* pointer, const char* name) {
    if (pointer == nullptr) throw Error(std::string(name) + " is null");
    return *pointer;
}

/// A function with one result: writes what `make` returns to where `out` points to, if that is
/// not null, calling it `name`.
template <class Result, class Make>
espalier_status result(Result* out, const char* name, const Make& make) noexcept {
    return guarded([&] {
        Result& place = deref(out, name);
        place = make();
    });
}

/// An array of `count` entities with `each` values an entity.
/// \throws Error if `count` is negative, or larger than any memory, or the array is null and should
///         not be
template <class T>
std::span<T> array(T* values, std::int64_t count, const char* name, std::int64_t each = 1) {
    const std::int64_t most = PTRDIFF_MAX / static_cast<std::int64_t>(sizeof(T)) / each;
    if (count < 0 || count > most)
        throw Error(concat(name, ": the count is ", count, "; expected 0 to ", most));
    if (count > 0) deref(values, name);
    return {values, static_cast<std::size_t>(count * each)};
}

/// \param count of positions; there are three times as many numbers
inline std::vector<Point3> positions(const double* values, std::int64_t count, const char* name) {
    array(values, count, name, 3);
    std::vector<Point3> result(count);
    if (count > 0) std::memcpy(result.data(), values, result.size() * sizeof(Point3));
    return result;
}

/// The numbers of positions, as they come out.
inline const double* numbers(const std::vector<Point3>& positions) {
    return positions.empty() ? nullptr : positions.front().data();
}

/// \throws Error if they are not the same
inline void checkCount(std::int64_t got, std::int64_t expected, const char* what) {
    if (got != expected) throw Error(concat("got ", got, " ", what, "; expected ", expected));
}

/// A constant of an enumeration whose C++ values are those of C.
/// \param last the last one
/// \throws Error if it is not from 0 to `last`, calling it `name`
template <class Enum>
Enum choice(std::int32_t value, Enum last, const char* name) {
    if (value < 0 || value > static_cast<std::int32_t>(last))
        throw Error(
            concat(name, " is ", value, "; expected 0 to ", static_cast<std::int32_t>(last)));
    return static_cast<Enum>(value);
}

/// Options as they were given, or else the defaults. The fields that the struct of an earlier
/// version lacks have their defaults, too.
///
/// \param maker the function that makes the defaults, for the message
/// \param firstSize of the struct in its first version
/// \throws Error if they are smaller than that, or larger than they can be
template <class Options>
Options optionsOr(const Options* given, const Options& defaults, const char* maker,
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

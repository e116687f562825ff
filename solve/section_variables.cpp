// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/argument_error.h>
#include <espalier/base/number_text.h>
#include <espalier/base/vector3.h>
#include <espalier/solve/section_variables.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "section_formula.h"

namespace espalier::solve {
namespace {

[[noreturn]] void refuseVector(const char* field, const Point3& vector, const char* expected) {
    throw ArgumentError("", field, textOf(vector), expected);
}

void requireFinite(const char* field, const Point3& vector) {
    for (const double coordinate : vector)
        if (!std::isfinite(coordinate)) refuseVector(field, vector, "finite numbers");
}

/// Returns the values of a vertex: those of the sections below and above it, in parts.
SectionValues<double> valuesAt(std::span<const double> values, Index section, double fraction) {
    SectionValues<double> result;
    for (std::size_t k = 0; k < 5; ++k) {
        const double* const first = &values[Offset{5} * section + k];
        result[k] = fraction == 0 ? *first : (1 - fraction) * first[0] + fraction * first[5];
    }
    return result;
}

}  // namespace

SectionVariables::SectionVariables(std::span<const Point3> positions, const SectionOptions& options)
    : stations_(options.stations) {
    requireFinite("axis", options.axis);
    requireFinite("chord", options.chord);
    requireFinite("center", options.center);
    if (!(length(options.axis) > 0)) refuseVector("axis", options.axis, "a vector other than 0");
    axis_ = normalised(options.axis);
    const Point3 chord = scaledNearOne(options.chord);
    const Point3 across = difference(chord, scaled(axis_, dot(chord, axis_)));
    // Less is the rounding of a parallel vector.
    constexpr double kParallel = 1e-9;
    if (!(length(across) > kParallel * length(chord)))
        refuseVector("chord", options.chord,
                     "a vector other than 0 that is not parallel to the axis");
    chord_ = normalised(across);
    normal_ = cross(axis_, chord_);
    if (stations_.empty()) throw ArgumentError("", "stations", "none", "one or more");
    for (std::size_t i = 0; i < stations_.size(); ++i)
        if (!std::isfinite(stations_[i]) || (i > 0 && !(stations_[i] > stations_[i - 1])))
            throw ArgumentError("", concat("stations[", i, "]"), textOf(stations_[i]),
                                "finite numbers in ascending order");
    vertices_.reserve(positions.size());
    for (std::size_t v = 0; v < positions.size(); ++v) {
        for (const double coordinate : positions[v])
            if (!std::isfinite(coordinate))
                throw Error(concat("the position of vertex ", v, " is not finite"));
        const Point3 arm = difference(positions[v], options.center);
        const double s = dot(positions[v], axis_);
        Vertex vertex;
        vertex.foot = sum(options.center, scaled(axis_, dot(arm, axis_)));
        vertex.chord = dot(arm, chord_);
        vertex.normal = dot(arm, normal_);
        const auto above = std::ranges::upper_bound(stations_, s) - stations_.begin();
        const auto below = std::max<std::ptrdiff_t>(above - 1, 0);
        vertex.section = static_cast<Index>(below);
        const bool isBetween = above > 0 && above < std::ssize(stations_);
        vertex.fraction =
            isBetween ? (s - stations_[below]) / (stations_[above] - stations_[below]) : 0;
        vertices_.push_back(vertex);
    }
}

std::vector<double> SectionVariables::atRest() const {
    std::vector<double> values;
    for (std::size_t i = 0; i < stations_.size(); ++i)
        values.insert(values.end(), {0.0, 1.0, 0.0, 0.0, 0.0});
    return values;
}

void SectionVariables::check(std::span<const double> values) const {
    if (std::ssize(values) != count())
        throw Error(concat("there are ", values.size(), " values; expected ", count(),
                           ", five for each section"));
    for (std::size_t i = 0; i < values.size(); ++i)
        if (!std::isfinite(values[i]))
            throw Error(concat("values[", i, "] is ", values[i], "; expected a finite number"));
}

std::vector<Point3> SectionVariables::positions(std::span<const double> values) const {
    check(values);
    std::vector<Point3> result;
    result.reserve(vertices_.size());
    for (const Vertex& vertex : vertices_)
        result.push_back(
            sectionPosition<double>({chord_, normal_}, vertex.foot, vertex.chord, vertex.normal,
                                    valuesAt(values, vertex.section, vertex.fraction)));
    return result;
}

stencils::StencilTable<double> SectionVariables::matrix(std::span<const double> values) const {
    check(values);
    Array<Offset> offsets = {0};
    Array<Index> columns;
    Array<double> weights;
    for (const Vertex& vertex : vertices_) {
        const auto derivatives =
            sectionDerivatives({chord_, normal_}, vertex.chord, vertex.normal,
                               valuesAt(values, vertex.section, vertex.fraction));
        for (std::size_t c = 0; c < 3; ++c) {
            const auto add = [&](Index section, double part) {
                for (std::size_t k = 0; k < 5; ++k) {
                    // Translations move one coordinate each.
                    if (k >= 2 && k != c + 2) continue;
                    columns.push_back(5 * section + static_cast<Index>(k));
                    weights.push_back(part * derivatives[k][c]);
                }
            };
            add(vertex.section, 1 - vertex.fraction);
            if (vertex.fraction > 0) add(vertex.section + 1, vertex.fraction);
            offsets.push_back(static_cast<Offset>(columns.size()));
        }
    }
    return {count(), std::move(offsets), std::move(columns), std::move(weights)};
}

}  // namespace espalier::solve

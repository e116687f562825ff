// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/vector3.h>
#include <espalier/shapes/transform.h>

#include <cmath>
#include <utility>

#include "checks.h"

namespace espalier::shapes {
namespace {

/// Rotation about a unit axis, from the cosine and sine of its angle (Rodrigues' formula).
Affine rotationAbout(const Point3& axis, double cosine, double sine) {
    const auto [x, y, z] = axis;
    const double rest = 1 - cosine;
    Affine map;
    map.linear = {{{cosine + x * x * rest, x * y * rest - z * sine, x * z * rest + y * sine},
                   {y * x * rest + z * sine, cosine + y * y * rest, y * z * rest - x * sine},
                   {z * x * rest - y * sine, z * y * rest + x * sine, cosine + z * z * rest}}};
    return map;
}

/// Returns the coordinate axis with the largest angle to a unit vector.
Point3 leastAlignedAxis(const Point3& direction) {
    std::size_t least = 0;
    for (std::size_t axis = 1; axis < 3; ++axis)
        if (std::abs(direction[axis]) < std::abs(direction[least])) least = axis;
    Point3 result = {0, 0, 0};
    result[least] = 1;
    return result;
}

}  // namespace

Point3 Affine::operator()(const Point3& point) const {
    return {dot(linear[0], point) + translation[0], dot(linear[1], point) + translation[1],
            dot(linear[2], point) + translation[2]};
}

double Affine::determinant() const {
    return dot(linear[0], cross(linear[1], linear[2]));
}

Affine operator*(const Affine& first, const Affine& second) {
    Affine product;
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 3; ++column)
            product.linear[row][column] =
                dot(first.linear[row],
                    {second.linear[0][column], second.linear[1][column], second.linear[2][column]});
    product.translation = first(second.translation);
    return product;
}

Affine translation(const Point3& offset) {
    Affine map;
    map.translation = offset;
    return map;
}

Affine scaling(const Point3& factors) {
    Affine map;
    for (std::size_t axis = 0; axis < 3; ++axis) map.linear[axis][axis] = factors[axis];
    return map;
}

Affine rotation(const Point3& axis, double angle) {
    requireFinite("rotation", "angle", angle);
    return rotationAbout(unitVector("rotation", "axis", axis), std::cos(angle), std::sin(angle));
}

Affine rotationBetween(const Point3& from, const Point3& to) {
    const Point3 start = unitVector("rotation", "from", from);
    const Point3 end = unitVector("rotation", "to", to);
    const Point3 axis = cross(start, end);
    const double sine = length(axis);
    if (sine > 0) return rotationAbout(normalised(axis), dot(start, end), sine);
    if (dot(start, end) > 0) return {};
    return rotationAbout(normalised(cross(start, leastAlignedAxis(start))), -1, 0);
}

far::CellComplex insideOut(const far::CellComplex& complex) {
    if (complex.dimension() != 3) throw Error("insideOut: expected a lattice with cells");
    far::Rows<far::Signed> faces;
    for (Index cell = 0; cell < complex.count(3); ++cell) {
        const auto row = complex.boundary(3)[cell];
        const auto signs = complex.boundary(3).signs(cell);
        for (std::size_t i = 0; i < row.size(); ++i)
            faces.values.push_back({row[i], static_cast<std::int8_t>(-signs[i])});
        faces.offsets.push_back(static_cast<Offset>(faces.values.size()));
    }
    return far::CellComplex(
        3, complex.count(0),
        {complex.boundary(1), complex.boundary(2), far::SignedIncidence(faces)});
}

Lattice transformed(const Lattice& lattice, const Affine& map) {
    requireConsistent("transformed", "the lattice", lattice, lattice.complex.dimension());
    for (const auto& row : map.linear) requireFinite("transformed", "linear", row);
    requireFinite("transformed", "translation", map.translation);
    const double determinant = map.determinant();
    if (determinant == 0 || !std::isfinite(determinant))
        throw ArgumentError("transformed", "the determinant of the map", textOf(determinant),
                            "a finite number other than 0");
    Lattice result = lattice;
    for (Point3& position : result.positions) position = map(position);
    if (determinant < 0 && lattice.complex.dimension() == 3)
        result.complex = insideOut(lattice.complex);
    return result;
}

}  // namespace espalier::shapes

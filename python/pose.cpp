// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/argument_error.h>
#include <espalier/base/number_text.h>
#include <espalier/shapes/cell_selection.h>
#include <espalier/shapes/held.h>
#include <espalier/shapes/lattice.h>
#include <espalier/shapes/limb.h>
#include <espalier/shapes/pose.h>
#include <espalier/shapes/selection.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "arguments.h"
#include "module.h"

// The module espalier.pose: operations that pose a lattice, and selections of its vertices.
namespace espalier::python {
namespace {

using namespace pybind11::literals;
namespace pose = shapes::pose;

/// An axis: "x", "+y", "-z", or a vector.
using Axis = std::variant<std::string, Point3>;
using OptionalRange = std::optional<std::array<double, 2>>;

Point3 vectorOf(const Axis& axis, const char* name) {
    if (axis.index() == 1) return std::get<1>(axis);
    const std::string& word = std::get<0>(axis);
    const bool hasSign = !word.empty() && (word[0] == '+' || word[0] == '-');
    const std::string letter = word.substr(hasSign ? 1 : 0);
    if (letter.size() != 1 || letter[0] < 'x' || letter[0] > 'z')
        throw ArgumentError("", name, inQuotes(word), "x, y or z, or a vector");
    Point3 vector = {0, 0, 0};
    vector[letter[0] - 'x'] = word[0] == '-' ? -1 : 1;
    return vector;
}

/// The positions and weights of a call, as C++ reads them.
struct Arguments {
    std::vector<Point3> positions;
    std::vector<double> weights;

    Arguments(const py::handle& points, const py::object& weightsOrNone)
        : positions(toPoints(points, "positions")) {
        if (weightsOrNone.is_none()) return;
        const auto array = realArray<double>(weightsOrNone, "weights");
        if (array.ndim() != 1 || array.shape(0) != std::ssize(positions))
            throw Error("weights has shape " + shapeText(array) +
                        "; expected one number for each of the " +
                        std::to_string(positions.size()) + " positions");
        weights.assign(array.data(), array.data() + array.size());
    }
};

/// Calls a function of selection.h.
template <class Select>
py::array select(const py::handle& points, const Select& make) {
    return toArray(make(toPoints(points, "positions")));
}

shapes::Falloff falloffOf(const std::string& profile, double radius) {
    return {chosen(shapes::kFalloffWords, "falloff", profile), radius};
}

void addOperations(py::module_& module) {
    module.def(
        "move",
        [](const ArrayLike& positions, const Point3& offset, const py::object& weights) {
            const Arguments given(positions, weights);
            return toArray(pose::move(given.positions, offset, given.weights));
        },
        "positions"_a, "offset"_a, py::kw_only(), "weights"_a = py::none(),
        R"(
Moves positions by a vector.

positions : (N, 3) array of float; weights : array (N,) of float from 0 to 1, the part of the vector
that each position moves by (1)
)");
    module.def(
        "displace",
        [](const ArrayLike& positions, const ArrayLike& displacements, const py::object& weights) {
            const Arguments given(positions, weights);
            return toArray(pose::displace(
                given.positions, toPoints(displacements, "displacements", given.positions.size()),
                given.weights));
        },
        "positions"_a, "displacements"_a, py::kw_only(), "weights"_a = py::none(),
        R"(
Moves each position by its own vector.

positions, displacements : (N, 3) arrays of float; weights : array (N,) of float from 0 to 1, the part
of its vector that each position moves by (1)
)");
    module.def(
        "rotate",
        [](const ArrayLike& positions, const Axis& axis, double angle, const py::object& weights,
           const std::optional<Point3>& center) {
            const Arguments given(positions, weights);
            return toArray(pose::rotate(given.positions, vectorOf(axis, "axis"), angle,
                                        {given.weights, center}));
        },
        "positions"_a, "axis"_a, "angle"_a, py::kw_only(), "weights"_a = py::none(),
        "center"_a = py::none(),
        R"(
Rotates positions about an axis, anticlockwise seen from its tip.

positions : (N, 3) array of float; axis : "x", "y", "z", with a sign or not, or 3 float
angle : in radians; weights : array (N,) of float from 0 to 1, the part of the angle that each
position rotates by (1); center : 3 float, a point on the axis (the middle of the box around the
positions with a weight above 0)
)");
    module.def(
        "scale",
        [](const ArrayLike& positions, const std::variant<double, Point3>& factors,
           const py::object& weights, const std::optional<Point3>& center) {
            const Arguments given(positions, weights);
            Point3 three;
            if (factors.index() == 0)
                three.fill(std::get<0>(factors));
            else
                three = std::get<1>(factors);
            return toArray(pose::scale(given.positions, three, {given.weights, center}));
        },
        "positions"_a, "factors"_a, py::kw_only(), "weights"_a = py::none(),
        "center"_a = py::none(), R"(
Scales positions about `center`.

positions : (N, 3) array of float; factors : float, or 3 float for x, y and z
weights : array (N,) of float from 0 to 1: a position with weight w is scaled by 1 + w (factor - 1)
center : as in rotate()
)");
    module.def(
        "twist",
        [](const ArrayLike& positions, const Axis& axis, double angle, const py::object& weights,
           const std::optional<Point3>& center, const OptionalRange& range) {
            const Arguments given(positions, weights);
            return toArray(pose::twist(given.positions, vectorOf(axis, "axis"), angle,
                                       {given.weights, center, range}));
        },
        "positions"_a, "axis"_a, "angle"_a, py::kw_only(), "weights"_a = py::none(),
        "center"_a = py::none(), "range"_a = py::none(),
        R"(
Rotates positions about an axis: by 0 at the start of `range`, by `angle` at its end and beyond.

positions : (N, 3) array of float; axis, weights, center : as in rotate(); angle : in radians
range : 2 float, coordinates along the axis (those of the positions with a weight above 0)
)");
    module.def(
        "bend",
        [](const ArrayLike& positions, const Axis& axis, double angle, const Axis& toward,
           const py::object& weights, const std::optional<Point3>& center,
           const OptionalRange& range) {
            const Arguments given(positions, weights);
            return toArray(pose::bend(given.positions, vectorOf(axis, "axis"), angle,
                                      vectorOf(toward, "toward"), {given.weights, center, range}));
        },
        "positions"_a, "axis"_a, "angle"_a, "toward"_a, py::kw_only(), "weights"_a = py::none(),
        "center"_a = py::none(), "range"_a = py::none(),
        R"(
Bends the axis into an arc of a circle (Barr 1984, section 3.4). The start of `range` stays.

positions : (N, 3) array of float; axis, weights, center : as in rotate(); range : as in twist()
angle : of the arc, in radians; toward : the direction that the end of `range` bends to, as an axis
)");
    module.def(
        "taper",
        [](const ArrayLike& positions, const Axis& axis, double factor, const py::object& weights,
           const std::optional<Point3>& center, const OptionalRange& range) {
            const Arguments given(positions, weights);
            return toArray(pose::taper(given.positions, vectorOf(axis, "axis"), factor,
                                       {given.weights, center, range}));
        },
        "positions"_a, "axis"_a, "factor"_a, py::kw_only(), "weights"_a = py::none(),
        "center"_a = py::none(), "range"_a = py::none(),
        R"(
Scales positions across an axis: by 1 at the start of `range`, by `factor` at its end and beyond.

positions : (N, 3) array of float; factor : 0 or more; axis, weights, center : as in rotate()
range : as in twist()
)");
}

void addMirror(py::module_& module) {
    module.def(
        "mirror",
        [](const ArrayLike& rest, const ArrayLike& positions, const std::string& axis,
           const py::object& weights, const std::optional<double>& plane) {
            const Arguments given(positions, weights);
            if (axis.size() != 1 || axis[0] < 'x' || axis[0] > 'z')
                throw ArgumentError("", "axis", inQuotes(axis), "x, y or z");
            const auto atRest = toPoints(rest, "rest");
            const auto result =
                pose::mirror(atRest, given.positions, axis[0] - 'x', given.weights, plane);
            if (result.withoutImage > 0)
                warn(concat("mirror: ", result.withoutImage, " of ",
                            result.withImage + result.withoutImage,
                            " positions have no mirror image, and stay"));
            return toArray(result.positions);
        },
        "rest"_a, "positions"_a, "axis"_a, py::kw_only(), "weights"_a = py::none(),
        "plane"_a = py::none(), R"(
Lets the other side do what one side does: gives the mirror image of each position the mirrored place
of the position. Images are found in the lattice at rest, within a thousandth of its diagonal.

rest, positions : (N, 3) arrays of float; axis : "x", "y" or "z", across which the plane is
weights : array (N,) of float from 0 to 1, default 1. Of a position and its image, the one with the
    larger weight leads; of equal weights, the one on the side where the weights have the larger sum
plane : coordinate of the plane on the axis; default: the middle of the box around `rest`

A UserWarning counts positions with a weight above 0 that have no mirror image, and so stay.
)");
}

void addSelections(py::module_& module) {
    module.def(
        "select_box",
        [](const ArrayLike& positions, const Point3& corner, const Point3& opposite,
           const std::string& falloff, double radius) {
            return select(positions, [&](const std::vector<Point3>& points) {
                return shapes::selectBox(points, corner, opposite, falloffOf(falloff, radius));
            });
        },
        "positions"_a, "corner"_a, "opposite"_a, py::kw_only(), "falloff"_a = "linear",
        "falloff_radius"_a = 0.0, R"(
Returns weights, an array (N,): 1 in the box with two opposite corners, 0 outside.

positions : (N, 3) array of float; corner, opposite : 3 float each
falloff, falloff_radius : how weights decrease with the distance d from the box: "linear",
1 - d / radius; or "smooth", with slope 0 at both ends. They are 0 from falloff_radius on
)");
    module.def(
        "select_ball",
        [](const ArrayLike& positions, const Point3& center, double ballRadius,
           const std::string& falloff, double radius) {
            return select(positions, [&](const std::vector<Point3>& points) {
                return shapes::selectBall(points, center, ballRadius, falloffOf(falloff, radius));
            });
        },
        "positions"_a, "center"_a, "radius"_a, py::kw_only(), "falloff"_a = "linear",
        "falloff_radius"_a = 0.0, R"(
Returns weights, an array (N,): 1 in a ball, 0 outside.

positions : (N, 3) array of float; center : 3 float; falloff, falloff_radius : as in select_box()
)");
    module.def(
        "select_half_space",
        [](const ArrayLike& positions, const Point3& point, const Point3& normal,
           const std::string& falloff, double radius) {
            return select(positions, [&](const std::vector<Point3>& points) {
                return shapes::selectHalfSpace(points, point, normal, falloffOf(falloff, radius));
            });
        },
        "positions"_a, "point"_a, "normal"_a, py::kw_only(), "falloff"_a = "linear",
        "falloff_radius"_a = 0.0,
        R"(
Returns weights, an array (N,): 1 on the side of a plane that `normal` points to, 0 on the other.

positions : (N, 3) array of float; point, normal : 3 float each
falloff, falloff_radius : as in select_box()
)");
    module.def(
        "select_end",
        [](const ArrayLike& positions, const Axis& direction, const std::string& falloff,
           double radius) {
            return select(positions, [&](const std::vector<Point3>& points) {
                return shapes::selectEnd(points, vectorOf(direction, "direction"),
                                         falloffOf(falloff, radius));
            });
        },
        "positions"_a, "direction"_a, py::kw_only(), "falloff"_a = "linear",
        "falloff_radius"_a = 0.0,
        R"(
Returns weights, an array (N,): 1 for the positions that are farthest in a direction, up to 1 % of
the extent, 0 for the others.

positions : (N, 3) array of float; direction : "+z", "-x" and so on, or 3 float
falloff, falloff_radius : as in select_box()
)");
    module.def(
        "select_numbers",
        [](const ArrayLike& positions, const py::handle& numbers, const std::string& falloff,
           double radius) {
            return select(positions, [&](const std::vector<Point3>& points) {
                return shapes::selectNumbers(points, toIndices(numbers, "numbers"),
                                             falloffOf(falloff, radius));
            });
        },
        "positions"_a, "numbers"_a, py::kw_only(), "falloff"_a = "linear", "falloff_radius"_a = 0.0,
        R"(
Returns weights, an array (N,): 1 for the positions with some numbers, 0 for the others.

positions : (N, 3) array of float; numbers : array (M,) of int
falloff, falloff_radius : as in select_box(), with the distance from the nearest of these positions
)");
}

/// Returns the vertices with a weight above 0.
std::vector<Index> selectedBy(const Lattice& lattice, const py::handle& weights) {
    const auto array = realArray<double>(weights, "weights");
    if (array.ndim() != 1 || array.shape(0) != std::ssize(lattice.positions))
        throw Error("weights has shape " + shapeText(array) +
                    "; expected one number for each of the " +
                    std::to_string(lattice.positions.size()) + " vertices");
    std::vector<Index> vertices;
    for (py::ssize_t v = 0; v < array.shape(0); ++v) {
        if (!(array.at(v) >= 0 && array.at(v) <= 1))
            throw Error(concat("weights[", v, "] is ", array.at(v), "; expected 0 to 1"));
        if (array.at(v) > 0) vertices.push_back(static_cast<Index>(v));
    }
    return vertices;
}

py::array along(const Lattice& lattice, const std::vector<Index>& vertices,
                const std::string& falloff, double radius) {
    return toArray(shapes::selectAlongCells(lattice.complex, lattice.positions, vertices,
                                            falloffOf(falloff, radius)));
}

void addSelectionsAlongCells(py::module_& module) {
    module.def(
        "select_limb",
        [](const Lattice& lattice, const Point3& point, const std::string& falloff, double radius) {
            const auto limb = shapes::selectLimb(lattice.complex, lattice.positions, point);
            return along(lattice, limb.vertices, falloff, radius);
        },
        "lattice"_a, "point"_a, py::kw_only(), "falloff"_a = "linear", "falloff_radius"_a = 0.0, R"(
Returns weights, an array (V,): 1 for the vertices of the limb at a point, such as an arm with its
hand: the part of the lattice beyond its narrowest section, where it opens into the body.

lattice : Lattice at rest; point : 3 float, inside or outside
falloff, falloff_radius : as in select_box(), with distances along the cells of the lattice
)");
    module.def(
        "select_beyond",
        [](const Lattice& lattice, const std::variant<Index, Point3>& face,
           const std::string& falloff, double radius) {
            Index number = 0;
            if (face.index() == 0) {
                number = std::get<0>(face);
            } else {
                const Point3& point = std::get<1>(face);
                for (const double coordinate : point)
                    if (!std::isfinite(coordinate))
                        throw ArgumentError("select_beyond", "face", espalier::textOf(point),
                                            "a number or finite coordinates");
                number = shapes::nearestInnerFace(lattice.complex, lattice.positions, point);
            }
            const auto part = shapes::selectBeyond(lattice.complex, lattice.positions, number);
            return along(lattice, part.vertices, falloff, radius);
        },
        "lattice"_a, "face"_a, py::kw_only(), "falloff"_a = "linear", "falloff_radius"_a = 0.0, R"(
Returns weights, an array (V,): 1 for the smaller part of a lattice beyond a face between two cells.

lattice : Lattice at rest; face : int, or 3 float, a point near the face
falloff, falloff_radius : as in select_limb()
)");
    module.def(
        "select_near",
        [](const Lattice& lattice, const Point3& point, double nearRadius,
           const std::string& falloff, double radius) {
            return toArray(shapes::selectNear(lattice.complex, lattice.positions, point, nearRadius,
                                              falloffOf(falloff, radius)));
        },
        "lattice"_a, "point"_a, "radius"_a, py::kw_only(), "falloff"_a = "linear",
        "falloff_radius"_a = 0.0, R"(
Returns weights, an array (V,): 1 within a distance of a point along the cells of the lattice.

lattice : Lattice at rest; point : 3 float; falloff, falloff_radius : as in select_limb()
)");
    module.def(
        "grow",
        [](const Lattice& lattice, const ArrayLike& weights, int steps) {
            const auto before = selectedBy(lattice, weights);
            const int count = std::min(std::abs(std::max(steps, -kMaxIndex)),
                                       static_cast<int>(lattice.complex.count(0)));
            return along(lattice,
                         steps < 0 ? shapes::shrinkSelection(lattice.complex, before, count)
                                   : shapes::growSelection(lattice.complex, before, count),
                         "linear", 0);
        },
        "lattice"_a, "weights"_a, "steps"_a = 1, R"(
Returns weights, an array (V,): 1 for the vertices with a weight above 0 and for those that up to
`steps` edges join to them. Below 0, the selection shrinks.

weights : array (V,) of float from 0 to 1
)");
    module.def(
        "without_held",
        [](const Lattice& lattice, const std::optional<ArrayLike>& weights) {
            if (!weights) return toArray(shapes::weightsWithHeld(lattice));
            const auto array = realArray<double>(*weights, "weights");
            if (array.ndim() != 1)
                throw Error("weights has shape " + shapeText(array) +
                            "; expected one number for each vertex");
            return toArray(shapes::weightsWithHeld(
                lattice, {array.data(), static_cast<std::size_t>(array.size())}));
        },
        "lattice"_a, "weights"_a = py::none(), R"(
Returns the weights with 0 for the vertices that the lattice holds (Lattice.held), so that no
operation moves them.

weights : array (V,) of float from 0 to 1 (1 for all)
)");
    module.def(
        "border",
        [](const Lattice& lattice, const ArrayLike& weights) {
            return shapes::selectionBorder(lattice.complex, lattice.positions,
                                           selectedBy(lattice, weights))
                .center;
        },
        "lattice"_a, "weights"_a, R"(
Returns the middle of the section between the vertices with a weight above 0 and the rest, 3 float:
the joint about which a selected limb turns, for the argument `center` of rotate().

weights : array (V,) of float from 0 to 1, without a falloff
)");
}

}  // namespace

void addPose(py::module_& module) {
    addSubmodule(module, "_pose",
                 "Operations that pose a lattice (Barr 1984), and selections of its vertices.",
                 "espalier.pose", [](py::module_& poseModule) {
                     addOperations(poseModule);
                     addMirror(poseModule);
                     addSelections(poseModule);
                     addSelectionsAlongCells(poseModule);
                 });
}

}  // namespace espalier::python

// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/solve/constraints.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "arguments.h"
#include "tables.h"

// The module espalier.constraints: measures of a shape with their derivatives.
namespace espalier::python {

using namespace py::literals;

namespace {

/// Returns the rows of an array (count, n) of point numbers.
template <std::size_t n>
std::vector<std::array<Index, n>> rowsOf(const py::object& object, const std::string& name,
                                         const std::string& expected) {
    const auto array = indexArray(object, name);
    if (array.ndim() != 2 || array.shape(1) != n)
        throw Error(concat(name, ": expected an array of shape ", expected, ", got shape ",
                           shapeText(array)));
    std::vector<std::array<Index, n>> result(array.shape(0));
    for (std::size_t i = 0; i < result.size(); ++i)
        std::copy_n(array.data() + i * n, n, result[i].begin());
    return result;
}

std::vector<std::array<Index, 3>> trianglesOf(const py::object& object) {
    return rowsOf<3>(object, "triangles", "(F, 3)");
}

/// Returns the values and the derivatives as a tuple.
py::tuple tupleOf(solve::Measures measures) {
    return py::make_tuple(toArray(std::move(measures.values)),
                          std::make_shared<Table>(std::move(measures.derivatives)));
}

void addMeasures(py::module_& module) {
    module.def(
        "distances",
        [](const ArrayLike& points, const py::object& pairs) {
            return tupleOf(solve::measureDistances(toPoints(points, "points"),
                                                   rowsOf<2>(pairs, "pairs", "(m, 2)")));
        },
        "points"_a, "pairs"_a, R"(
The distance of each pair of points, and the derivatives. Points at the same place are an error.

points : (N, 3) array of float; pairs : (m, 2) array of int, numbers of points
)");
    module.def(
        "crossings",
        [](const ArrayLike& points, const py::object& triangles, const ArrayLike& linePoints,
           const ArrayLike& lineDirections) {
            const auto from = toPoints(linePoints, "line_points");
            const auto directions = toPoints(lineDirections, "line_directions", from.size());
            std::vector<solve::Line> lines;
            for (std::size_t k = 0; k < from.size(); ++k) lines.push_back({from[k], directions[k]});
            const auto places = toPoints(points, "points");
            const auto faces = trianglesOf(triangles);
            return sharedWithoutGil([&] { return solve::findCrossings(places, faces, lines); });
        },
        "points"_a, "triangles"_a, "line_points"_a, "line_directions"_a, R"(
The places where lines first cross a surface, for thicknesses(): a StencilTable of shape (2 m, N).
Rows 2 k and 2 k + 1 are of line k, ahead and behind, as weights of the corners of a triangle. A line
that does not cross the surface on both sides of its point is an error.

points : (N, 3) array of float, at rest; triangles : (F, 3) array of int, numbers of points
line_points : (m, 3) array of float, between the two sides of the shape
line_directions : (m, 3) array of float, of any length
)");
    module.def(
        "thicknesses",
        [](const ArrayLike& points, const TableLike& crossings) {
            return tupleOf(
                solve::measureThicknesses(toPoints(points, "points"), *tableOf(crossings)));
        },
        "points"_a, "crossings"_a, R"(
The thickness of a shape along each line, and the derivatives: the distance between the two crossings,
which have moved with the surface.

points : (N, 3) array of float; crossings : of crossings(), for the shape at rest
)");
    module.def(
        "volume",
        [](const ArrayLike& points, const py::object& triangles) {
            return tupleOf(
                solve::measureVolume(toPoints(points, "points"), trianglesOf(triangles)));
        },
        "points"_a, "triangles"_a, R"(
The volume within a closed surface, and its derivatives. A surface that is not closed is an error.

points : (N, 3) array of float; triangles : (F, 3) array of int, anticlockwise seen from outside
)");
    module.def(
        "area",
        [](const ArrayLike& points, const py::object& triangles) {
            return tupleOf(solve::measureArea(toPoints(points, "points"), trianglesOf(triangles)));
        },
        "points"_a, "triangles"_a, R"(
The area of a surface, and its derivatives; a triangle without area adds nothing to them.

points : (N, 3) array of float; triangles : (F, 3) array of int, numbers of points
)");
    module.def(
        "curvatures",
        [](const ArrayLike& points, const ArrayLike& line) {
            return tupleOf(
                solve::measureCurvatures(toPoints(points, "points"), toIndices(line, "line")));
        },
        "points"_a, "line"_a, R"(
The curvature of a line of points at each point between its ends, and the derivatives: 1 / radius of
the circle through the point and its two neighbours. Where the line is straight, the derivatives are 0.

points : (N, 3) array of float; line : array (m + 2,) of int, numbers of points along the line
)");
    module.def(
        "planarity",
        [](const ArrayLike& points, const ArrayLike& some) {
            return tupleOf(
                solve::measurePlanarity(toPoints(points, "points"), toIndices(some, "some")));
        },
        "points"_a, "some"_a, R"(
The mean of the squared distances of points from the plane that fits them best, and its derivatives.

points : (N, 3) array of float; some : array (K,) of int, numbers of the points: three or more
)");
}

void addChains(py::module_& module) {
    module.def(
        "by_vertices",
        [](const TableLike& derivatives, const TableLike& deformation) {
            const auto g = tableOf(derivatives), d = tableOf(deformation);
            return sharedWithoutGil([&] { return solve::byVertices(*g, *d); });
        },
        "derivatives"_a, "deformation"_a, R"(
The derivatives of measures of deformed points by the lattice vertices: a StencilTable of shape (m, 3 V),
whose column 3 v + c is coordinate c of vertex v.

derivatives : of a measure, of shape (m, 3 N)
deformation : D: Binding, StencilTable or a sparse matrix of SciPy, of shape (N, V)
)");
    module.def(
        "by_variables",
        [](const TableLike& derivatives, const TableLike& jacobian) {
            const auto g = tableOf(derivatives), j = tableOf(jacobian);
            return sharedWithoutGil([&] { return solve::byVariables(*g, *j); });
        },
        "derivatives"_a, "jacobian"_a, R"(
The derivatives of measures of deformed points by the design variables: a StencilTable of shape
(m, variables).

derivatives : of a measure, of shape (m, 3 N); jacobian : of espalier.jacobian(), (3 N, variables)
)");
}

}  // namespace

void addConstraints(py::module_& module) {
    addSubmodule(module, "_constraints",
                 "Measures of a shape with their derivatives, for constraints.",
                 "espalier.constraints", [](py::module_& constraints) {
                     addMeasures(constraints);
                     addChains(constraints);
                 });
}

}  // namespace espalier::python

// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/solve/reference_axis.h>
#include <pybind11/stl.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "arguments.h"
#include "tables.h"

namespace espalier::python {

using namespace py::literals;
using solve::ReferenceAxis;

namespace {

/// Returns the values of the nodes as one list.
/// \throws Error unless the array has eleven values for each node
std::vector<double> nodeValues(const ReferenceAxis& axis, const ArrayLike& values) {
    const auto array = realArray<double>(values, "values");
    if (array.size() != axis.count())
        throw Error(concat("values: expected shape (", axis.nodeCount(), ", ",
                           ReferenceAxis::kValues, "), got shape ", shapeText(array)));
    return {array.data(), array.data() + array.size()};
}

}  // namespace

void addReferenceAxis(py::module_& module) {
    const solve::AxisOptions usual;
    py::class_<ReferenceAxis, std::shared_ptr<ReferenceAxis>>(module, "ReferenceAxis", R"(
An axis of straight lines that carries vertices of a lattice, such as the quarter-chord line of a
wing. Each of its n nodes has eleven values: the position x, y, z; turns about the x, y and z axes and
a twist about the axis, in radians, anticlockwise seen from the tip; a scale in all directions; scales
along the three directions of `frame`. Vertices linked between two nodes take values between theirs.

positions : array (V, 3), the vertices at rest; nodes : array (n, 3), two nodes or more
link : "nearest", a vertex is linked to the point of the axis nearest to it; "along", nearest to the
line through the vertex in `direction`; "across", nearest to the plane through it with this normal
direction : 3 float
order : "xyz", "xzy", "yzx", "yxz", "zxy" or "zyx", the order of the turns
follows : if True, sections turn with the axis when nodes move, and only the part of a link across the
axis counts; if False, they keep their direction
frame : array (3, 3), unit vectors at right angles
)")
        .def(py::init([](const ArrayLike& positions, const ArrayLike& nodes,
                         const std::string& link, const Point3& direction, const std::string& order,
                         bool follows, const std::array<Point3, 3>& frame) {
                 return ReferenceAxis(
                     toPoints(positions, "positions"),
                     {toPoints(nodes, "nodes"), chosen(solve::kAxisLinkWords, "link", link),
                      direction, chosen(solve::kTurnOrderWords, "order", order), follows, frame});
             }),
             "positions"_a, "nodes"_a, py::kw_only(), "link"_a = "nearest",
             "direction"_a = usual.direction, "order"_a = "zxy", "follows"_a = usual.follows,
             "frame"_a = usual.frame)
        .def(
            "moved_to",
            [](const ReferenceAxis& self, const ArrayLike& positions, const ArrayLike& nodes) {
                return std::make_shared<ReferenceAxis>(
                    self.movedTo(toPoints(positions, "positions"), toPoints(nodes, "nodes")));
            },
            "positions"_a, "nodes"_a, R"(
Returns the same links for vertices and an axis that have moved at rest, as a parent lattice moves
them.

positions : array (V, 3); nodes : array (n, 3)
)")
        .def_property_readonly(
            "at_rest",
            [](const ReferenceAxis& self) {
                return toArray(self.atRest())
                    .attr("reshape")(self.nodeCount(), ReferenceAxis::kValues);
            },
            "The values, an array (n, 11), that leave the vertices at rest: x, y, z, 0, 0, 0, 0, "
            "1, "
            "1, 1, 1 for each node.")
        .def_property_readonly(
            "feet", [](const ReferenceAxis& self) { return toArray(self.feet()); },
            "The point of the axis that each vertex is linked to, at rest: array (V, 3).")
        .def(
            "positions",
            [](const ReferenceAxis& self, const ArrayLike& values) {
                return toArray(self.positions(nodeValues(self, values)));
            },
            "values"_a, "Returns the vertices, an array (V, 3), for some values: array (n, 11).")
        .def(
            "matrix",
            [](const ReferenceAxis& self, const ArrayLike& values) {
                return std::make_shared<Table>(self.matrix(nodeValues(self, values)));
            },
            "values"_a,
            "Returns the derivatives of the coordinates by the values, a StencilTable 3 V × 11 n, "
            "at some values: array (n, 11).")
        .def(
            "rest_matrix",
            [](const ReferenceAxis& self, const ArrayLike& values) {
                return std::make_shared<Table>(self.restMatrix(nodeValues(self, values)));
            },
            "values"_a,
            "Returns the derivatives of the coordinates by the vertices and the nodes at rest, of "
            "moved_to(): a StencilTable 3 V × 3 (V + n), at some values: array (n, 11).");
}

}  // namespace espalier::python

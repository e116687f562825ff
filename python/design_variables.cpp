// SPDX-License-Identifier: Apache-2.0
#include <espalier/solve/design_variables.h>

#include <pybind11/stl.h>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "arguments.h"
#include "tables.h"

namespace espalier::python {

using namespace py::literals;

namespace {

using solve::DesignVariables;

/// One vertex, or several.
std::vector<Index> verticesOf(const ArrayLike& object) {
    const auto array = indexArray(object, "vertices");
    if (array.ndim() > 1)
        throw Error("vertices: expected an integer or an array of one dimension, got shape " +
                    shapeText(array));
    return {array.data(), array.data() + array.size()};
}

}  // namespace

void addDesignVariables(py::module_& module) {
    py::class_<DesignVariables>(module, "DesignVariables", R"(
The variables of a design: which displacements of the lattice an optimiser may choose. At first each
coordinate of each vertex is one. matrix() is B, which makes displacements of variables.

vertex_count : V
)")
        .def(py::init<Index>(), "vertex_count"_a)
        .def(
            "freeze",
            [](DesignVariables& self, const ArrayLike& vertices, std::optional<int> axis) {
                for (const Index vertex : verticesOf(vertices))
                    axis ? self.freeze(vertex, *axis) : self.freeze(vertex);
            },
            "vertices"_a, "axis"_a = py::none(),
            "Keeps vertices, or one coordinate of them (0 to 2), where they are. vertices : int, "
            "or array (K,) of int")
        .def("link", &DesignVariables::link, "vertex"_a, "to"_a,
             "factors"_a = std::array<double, 3>{1, 1, 1},
             "Makes a vertex move as another does, each coordinate times its factor.")
        .def(
            "mirror",
            [](DesignVariables& self, const ArrayLike& positions, int axis, double at,
               double tolerance) {
                const auto points = toPoints(positions, "positions");
                self.mirror(points, axis, at, tolerance);
            },
            "positions"_a, "axis"_a, "at"_a = 0.0, "tolerance"_a = 1e-9, R"(
Links each vertex with its mirror image at a plane across an axis.

positions : array (V, 3), at rest
axis, at  : the axis, 0 to 2, and where the plane is on it
tolerance : how far an image may be from its vertex, in the units of the positions
)")
        .def(
            "scale",
            [](DesignVariables& self, const ArrayLike& vertices, double unit,
               std::optional<int> axis) {
                for (const Index vertex : verticesOf(vertices))
                    axis ? self.scale(vertex, *axis, unit) : self.scale(vertex, unit);
            },
            "vertices"_a, "unit"_a, "axis"_a = py::none(),
            "Sets by how much vertices, or one coordinate of them, move when their variable grows "
            "by 1. vertices : int, or array (K,) of int")
        .def(
            "matrix",
            [](const DesignVariables& self) {
                return sharedWithoutGil([&] { return self.matrix(); });
            },
            "B: a StencilTable of shape (3 V, variables). Row 3 v + c is coordinate c of vertex "
            "v, so that (B @ variables).reshape(V, 3) are displacements.");
    module.def(
        "jacobian",
        [](const TableLike& deformation, const TableLike& design) {
            const auto d = tableOf(deformation);
            const auto b = tableOf(design);
            return sharedWithoutGil([&] { return solve::buildJacobian(*d, *b); });
        },
        "deformation"_a, "design"_a, R"(
The derivatives of the points by the variables: a StencilTable of shape (3 N, variables), whose row
3 i + c is coordinate c of point i.

deformation : D: Binding, StencilTable or a sparse matrix of SciPy, of shape (N, V)
design      : B: DesignVariables.matrix()
)");
}

}  // namespace espalier::python

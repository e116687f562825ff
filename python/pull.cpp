// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/held.h>
#include <espalier/shapes/lattice.h>
#include <espalier/solve/rigid_pull.h>
#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "arguments.h"
#include "module.h"
#include "tables.h"

// Pulls that bend a lattice: RigidPull.
namespace espalier::python {

using namespace py::literals;

namespace {

/// RigidPull, and the numbers of points and vertices that its arguments have.
struct Pull {
    solve::RigidPull pull;
    std::size_t pointCount, vertexCount;
};

std::unique_ptr<Pull> makePull(const Lattice& lattice, const TableLike& deformation,
                               const std::optional<ArrayLike>& rows,
                               const std::optional<ArrayLike>& frozen,
                               const std::optional<ArrayLike>& pins, double reach, double tolerance,
                               int maxIterations, bool moveHeld) {
    const auto table = tableOf(deformation);
    solve::RigidPullOptions options{
        .reach = reach, .tolerance = tolerance, .maxIterations = maxIterations};
    if (frozen) options.frozen = toIndices(*frozen, "frozen");
    if (!moveHeld) options.frozen = shapes::frozenWithHeld(lattice, options.frozen);
    if (pins) options.pins = toIndices(*pins, "pins");
    const auto chosen = rows ? toIndices(*rows, "rows") : std::vector<Index>();
    for (const Index row : chosen)
        if (row < 0 || row >= table->rowCount())
            throw Error(concat("rows: there is no row ", row, "; there are ", table->rowCount(),
                               ", numbered from 0"));
    return withoutGil([&] {
        const auto some = rows ? stencils::selectRows(*table, std::span(chosen)) : *table;
        return std::make_unique<Pull>(
            Pull{solve::RigidPull(lattice.complex, lattice.positions, some, options),
                 static_cast<std::size_t>(some.rowCount()), lattice.positions.size()});
    });
}

solve::RigidPose solvePull(const Pull& self, const ArrayLike& misses,
                           const std::optional<ArrayLike>& start) {
    const auto wanted = toPoints(misses, "misses", self.pointCount);
    const auto from = start ? toPoints(*start, "start", self.vertexCount) : std::vector<Point3>();
    return withoutGil([&] { return self.pull.solve(wanted, from); });
}

}  // namespace

void addPull(py::module_& module) {
    py::class_<solve::RigidPose, std::shared_ptr<solve::RigidPose>>(
        module, "RigidPose", "The displacements that RigidPull.solve() finds.")
        .def_property_readonly(
            "displacements",
            [](const py::object& self) {
                return viewOf(self.cast<const solve::RigidPose&>().displacements, self);
            },
            "Displacements of the lattice vertices: array (V, 3) of float64, read-only.")
        .def_readonly("largest_miss", &solve::RigidPose::largestMiss,
                      "The largest distance of a point from its target: float.")
        .def_readonly("rms_miss", &solve::RigidPose::rmsMiss,
                      "The root mean square of these distances: float.")
        .def_readonly("energy", &solve::RigidPose::energy,
                      "How far the cells are from rigid motions: float; 0 for a rigid motion.")
        .def_readonly("iterations", &solve::RigidPose::iterations, "The number of iterations: int.")
        .def_readonly("meets_barrier", &solve::RigidPose::meetsBarrier,
                      "True if cells would fold, or nearly, without the barrier that keeps them "
                      "open; points may then stay away from their targets: bool.");
    py::class_<Pull>(module, "RigidPull", R"(
Pulls points while the cells of a lattice stay as rigid as they can: a pulled hand bends its arm.
The matrix is factored once, for any number of targets of the same points.

lattice        : Lattice at rest
deformation    : D: Binding, StencilTable or a sparse matrix of SciPy, of shape (N, V)
rows           : array (K,) of int: the points that are pulled or pinned, if not all are
frozen         : array of int: lattice vertices that must not move
pins           : array of int: places in `rows` of the points that are to stay
reach          : vertices that are farther from all pulled points than this part of the distance of
                 the farthest one, along the cells, must not move; 0 to 1
tolerance      : the iteration ends when no vertex moves by more than this part of the lattice's
                 diagonal
max_iterations : 1 or more; for one frame of a drag 20 are enough
move_held      : if True, the vertices that the lattice holds (Lattice.held) may move, too
)")
        .def(py::init(&makePull), "lattice"_a, "deformation"_a, py::kw_only(),
             "rows"_a = py::none(), "frozen"_a = py::none(), "pins"_a = py::none(), "reach"_a = 0.5,
             "tolerance"_a = 1e-6, "max_iterations"_a = 500, "move_held"_a = false)
        .def_property_readonly(
            "fixed", [](const Pull& self) { return toArray(self.pull.fixedVertices()); },
            "The vertices that do not move, frozen ones and those beyond the reach, ascending: "
            "array of int32.")
        .def("solve", &solvePull, "misses"_a, py::kw_only(), "start"_a = py::none(), R"(
Finds the displacements of the lattice for some targets. Returns a RigidPose.

misses : array (K, 3): for each point its target minus its position at rest
start  : array (V, 3): displacements to start from, such as those of the last frame of a drag
)");
}

}  // namespace espalier::python

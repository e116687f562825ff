// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/lattice.h>
#include <espalier/solve/lattice_fit.h>
#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "arguments.h"
#include "tables.h"

namespace espalier::python {

using namespace py::literals;

namespace {

std::vector<Index> indicesOf(const std::optional<ArrayLike>& indices, const char* name) {
    return indices ? toIndices(*indices, name) : std::vector<Index>();
}

solve::LatticeFit fit(const Lattice& lattice, const TableLike& deformation, const ArrayLike& misses,
                      const std::optional<ArrayLike>& rows, const std::string& smoothing,
                      double strength, const std::optional<ArrayLike>& frozen,
                      const std::string& undetermined) {
    const auto table = tableOf(deformation);
    const auto chosenRows = indicesOf(rows, "rows");
    for (const Index row : chosenRows)
        if (row < 0 || row >= table->rowCount())
            throw Error("rows: there is no row " + std::to_string(row) + " among " +
                        std::to_string(table->rowCount()));
    const auto wanted = toPoints(
        misses, "misses", rows ? chosenRows.size() : static_cast<std::size_t>(table->rowCount()));
    solve::FitOptions options;
    options.smoothing = chosen(solve::kSmoothingWords, "smoothing", smoothing);
    options.strength = strength;
    options.frozen = indicesOf(frozen, "frozen");
    options.undetermined = chosen(solve::kUndeterminedWords, "undetermined", undetermined);
    return withoutGil([&] {
        if (!rows) return solve::fitLattice(*table, wanted, lattice.complex, options);
        return solve::fitLattice(stencils::selectRows(*table, std::span(chosenRows)), wanted,
                                 lattice.complex, options);
    });
}

}  // namespace

void addFit(py::module_& module) {
    py::class_<solve::LatticeFit, std::shared_ptr<solve::LatticeFit>>(
        module, "LatticeFit", "Displacements of a lattice, and how well they do: see fit().")
        .def_property_readonly(
            "displacements",
            [](const py::object& self) {
                return viewOf(self.cast<const solve::LatticeFit&>().displacements, self);
            },
            "Of the vertices: array (V, 3) of float64, read-only, in the units of the targets.")
        .def_readonly("largest_miss", &solve::LatticeFit::largestMiss,
                      "How far a point is from its target at most: float.")
        .def_readonly("rms_miss", &solve::LatticeFit::meanMiss,
                      "The root mean square of these distances: float.")
        .def_readonly("condition", &solve::LatticeFit::condition,
                      "The largest singular value of the problem over its least: float; inf where "
                      "the targets leave some displacements open.");
    module.def("fit", &fit, "lattice"_a, "deformation"_a, "misses"_a, py::kw_only(),
               "rows"_a = py::none(), "smoothing"_a = "none", "strength"_a = 1e-3,
               "frozen"_a = py::none(), "undetermined"_a = "smallest", R"(
The displacements of the lattice that carry points to where they are wanted, in the sense of least
squares. Returns a LatticeFit.

lattice      : Lattice
deformation  : D: Binding, StencilTable or a sparse matrix of SciPy, of shape (N, V)
misses       : array (N, 3): the target of each point, less where it is at rest
rows         : array (K,) of int: the points that have targets; misses is (K, 3) then
smoothing    : "none"; "tikhonov", small displacements; "laplacian", like those of the neighbours
strength     : of smoothing against targets, 1e-4 to 1e4; 1 is about as much
frozen       : array of int: vertices that stay
undetermined : "smallest" of all displacements that fit as well; or "refuse" these
)");
}

}  // namespace espalier::python

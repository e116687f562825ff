// SPDX-License-Identifier: Apache-2.0
// This is a separate module, so that `import espalier` does not need OpenSubdiv.
#include <espalier/compare/comparison.h>
#include <pybind11/stl.h>

#include <array>

#include "arguments.h"
#include "refiner.h"

namespace espalier::python {
namespace {

using compare::Agreement;
using compare::LevelAgreement;

Agreement compareWithOpenSubdiv(const Refiner& refiner, int level) {
    checkLevel(level);
    return withoutGil([&] {
        const auto levels = refiner.upTo(level);
        return compare::Comparison(*levels).compareAll(refiner.lattice()->positions);
    });
}

py::tuple toTuple(const std::array<Index, 3>& counts) {
    return py::make_tuple(counts[0], counts[1], counts[2]);
}

void addResults(py::module_& module) {
    py::class_<LevelAgreement>(module, "LevelAgreement",
                               "The differences between a level of a surface and OpenSubdiv's.")
        .def_readonly("level", &LevelAgreement::level, "The level, 1 or more: int.")
        .def_property_readonly(
            "counts", [](const LevelAgreement& self) { return toTuple(self.counts); },
            "Numbers of vertices, edges and faces of the surface: tuple of 3 int.")
        .def_property_readonly(
            "open_subdiv_counts",
            [](const LevelAgreement& self) { return toTuple(self.openSubdivCounts); },
            "The same numbers in OpenSubdiv: tuple of 3 int.")
        .def_readonly(
            "topology_difference", &LevelAgreement::topologyDifference,
            "The first difference in topology, features or holes: str, empty if there is none.")
        .def_readonly(
            "position_difference", &LevelAgreement::positionDifference,
            "The largest distance of matching vertices, for random positions in a cube, as a "
            "fraction of its side: float.")
        .def_readonly("weight_difference", &LevelAgreement::weightDifference,
                      "The largest difference between weights of the two stencil tables: float.")
        .def_readonly("evaluator_difference", &LevelAgreement::evaluatorDifference,
                      "The largest distance between results of the two evaluators, in single "
                      "precision, as a fraction of the side: float.")
        .def_property_readonly(
            "agrees", [](const LevelAgreement& self) { return self.isWithin({}); },
            "Whether all differences are within rounding: bool.");
    py::class_<Agreement>(
        module, "Agreement",
        "The differences between a surface and OpenSubdiv's, level by level: see compare().")
        .def_readonly("levels", &Agreement::levels, "List of LevelAgreement, from level 1 on.")
        .def_readonly("note", &Agreement::note, "A remark on the comparison: str, mostly empty.")
        .def_property_readonly(
            "agrees", [](const Agreement& self) { return self.isWithin({}); },
            "Whether every level agrees: bool.");
}

}  // namespace
}  // namespace espalier::python

PYBIND11_MODULE(_compare, module) {
    using namespace espalier::python;
    module.doc() = "The part of espalier that needs OpenSubdiv; use espalier.compare().";
    py::module_::import("espalier._core");  // for its types
    translateErrors();
    module.attr("__module__") = "espalier";
    addResults(module);
    module.attr("open_subdiv_version") = espalier::compare::openSubdivVersion();
    module.def("compare", &compareWithOpenSubdiv, py::arg("refiner"), py::arg("level"),
               "Compares the surface of a Refiner's lattice with OpenSubdiv's: see "
               "espalier.compare().");
    protectClasses(module);
    py::delattr(module, "__module__");
}

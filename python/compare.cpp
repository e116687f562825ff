// SPDX-License-Identifier: Apache-2.0
// A module of its own, so that `import espalier` needs no OpenSubdiv.
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
                               "How one level of a surface agrees with OpenSubdiv's.")
        .def_readonly("level", &LevelAgreement::level, "From 1 on: int.")
        .def_property_readonly(
            "counts", [](const LevelAgreement& self) { return toTuple(self.counts); },
            "Vertices, edges and faces of the surface: tuple of 3 int.")
        .def_property_readonly(
            "open_subdiv_counts",
            [](const LevelAgreement& self) { return toTuple(self.openSubdivCounts); },
            "Those of OpenSubdiv.")
        .def_readonly("topology_difference", &LevelAgreement::topologyDifference,
                      "The first difference of topology, features or holes: str, empty if none.")
        .def_readonly("position_difference", &LevelAgreement::positionDifference,
                      "The largest, of random positions in a cube, as a fraction of its side.")
        .def_readonly("weight_difference", &LevelAgreement::weightDifference,
                      "The largest between the two stencil tables.")
        .def_readonly("evaluator_difference", &LevelAgreement::evaluatorDifference,
                      "The largest between the evaluators, in single precision, as a fraction.")
        .def_property_readonly(
            "agrees", [](const LevelAgreement& self) { return self.isWithin({}); },
            "Whether all of it is within rounding: bool.");
    py::class_<Agreement>(module, "Agreement",
                          "How a surface agrees with OpenSubdiv's, level by level: see compare().")
        .def_readonly("levels", &Agreement::levels, "list of LevelAgreement, from level 1 on.")
        .def_readonly("note", &Agreement::note, "What else should be known: str, mostly empty.")
        .def_property_readonly(
            "agrees", [](const Agreement& self) { return self.isWithin({}); },
            "Whether every level does: bool.");
}

}  // namespace
}  // namespace espalier::python

PYBIND11_MODULE(_compare, module) {
    using namespace espalier::python;
    module.doc() = "The part of espalier that needs OpenSubdiv; use espalier.compare().";
    py::module_::import("espalier._core");  // whose types this takes
    translateErrors();
    module.attr("__module__") = "espalier";
    addResults(module);
    module.attr("open_subdiv_version") = espalier::compare::openSubdivVersion();
    module.def("compare", &compareWithOpenSubdiv, py::arg("refiner"), py::arg("level"),
               "Compares the surface of what a Refiner holds with OpenSubdiv's: see "
               "espalier.compare().");
    protectClasses(module);
    py::delattr(module, "__module__");
}

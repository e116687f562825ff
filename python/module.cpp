// SPDX-License-Identifier: Apache-2.0
#include "module.h"

#ifdef ESPALIER_WITH_CGNS
#include <espalier/io/cgns/cgns_model.h>
#endif

namespace py = pybind11;
using namespace espalier::python;

PYBIND11_MODULE(_core, module) {
    module.doc() = "The compiled part of espalier; import that.";
    module.attr("__version__") = ESPALIER_VERSION;
    // Types and functions take the name of their module from here.
    module.attr("__module__") = "espalier";
#ifdef ESPALIER_WITH_CGNS
    espalier::io::addCgnsModels();
#endif
    translateErrors();
    protectBaseClass();
    addLattice(module);
    addShapes(module);
    addPose(module);
    addModel(module);
    addRefiner(module);
    addStencilTable(module);
    addCompiledTables(module);
    addBinding(module);
    addFit(module);
    addDesignVariables(module);
    addValidity(module);
    addMeshCheck(module);
    addHolding(module);
    addLimits(module);
    protectClasses(module);
    py::delattr(module, "__module__");
}

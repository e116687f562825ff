// SPDX-License-Identifier: Apache-2.0
#include "module.h"

#ifdef ESPALIER_WITH_CGNS
#include <espalier/io/cgns/cgns_model.h>
#endif

#include <array>
#include <exception>

namespace espalier::python {
namespace {

/// Adds everything to the module.
void fill(py::module_& module) {
    module.doc() = "The compiled part of espalier; import that.";
    module.attr("__version__") = ESPALIER_VERSION;
    // Types and functions take the name of their module from here.
    module.attr("__module__") = "espalier";
#ifdef ESPALIER_WITH_CGNS
    io::addCgnsModels();
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
    addPull(module);
    addDesignVariables(module);
    addReferenceAxis(module);
    addConstraints(module);
    addValidity(module);
    addMeshCheck(module);
    addHolding(module);
    addLimits(module);
    protectClasses(module);
    py::delattr(module, "__module__");
}

/// Fills the module, unless the interpreter is a subinterpreter: there, pybind11 would take the GIL
/// of the main interpreter and wait for itself. Returns 0, or -1 with a Python exception.
int execute(PyObject* self) {
    if (PyInterpreterState_Get() != PyInterpreterState_Main()) {
        PyErr_SetString(PyExc_ImportError,
                        "espalier: only the main interpreter of a process can import it; this is a "
                        "subinterpreter. Use a process (multiprocessing) instead.");
        return -1;
    }
    try {
        py::detail::get_internals();
        auto module = py::reinterpret_borrow<py::module_>(self);
        fill(module);
        return 0;
    } catch (py::error_already_set& error) {
        py::raise_from(error, PyExc_ImportError, "initialization failed");
    } catch (const std::exception& error) {
        PyErr_SetString(PyExc_ImportError, error.what());
    }
    return -1;
}

}  // namespace
}  // namespace espalier::python

/// Initializes the module in two phases (PEP 489). PYBIND11_MODULE has one phase: it asks pybind11
/// before execute() could refuse, and a subinterpreter gets a copy of the module of the main one.
extern "C" PYBIND11_EXPORT PyObject* PyInit__core() {
    static std::array<PyModuleDef_Slot, 2> slots{
        {{Py_mod_exec, reinterpret_cast<void*>(&espalier::python::execute)}, {0, nullptr}}};
    static PyModuleDef definition = [] {
        PyModuleDef made{};
        made.m_base = PyModuleDef_HEAD_INIT;
        made.m_name = "_core";
        made.m_size = 1;  // with a state, importlib.reload() does not fill the module again
        made.m_slots = slots.data();
        return made;
    }();
    return PyModuleDef_Init(&definition);
}

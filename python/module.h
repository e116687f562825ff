// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/progress.h>
#include <pybind11/pybind11.h>

#include <memory>
#include <string>
#include <utility>

namespace espalier::python {

namespace py = pybind11;

// Each function adds the classes and functions of one source to the module. Types come before the
// functions that take them.
void addLattice(py::module_& module);
void addShapes(py::module_& module);
void addPose(py::module_& module);
void addModel(py::module_& module);
void addStencilTable(py::module_& module);
void addRefiner(py::module_& module);
void addCompiledTables(py::module_& module);
void addBinding(py::module_& module);
void addFit(py::module_& module);
void addPull(py::module_& module);
void addDesignVariables(py::module_& module);
void addReferenceAxis(py::module_& module);
void addConstraints(py::module_& module);
void addValidity(py::module_& module);
void addMeshCheck(py::module_& module);
void addHolding(py::module_& module);
void addLimits(py::module_& module);

/// Changes the base class of all pybind11 classes so that calling it cannot end the interpreter.
/// Only Espalier uses this base class (PYBIND11_COMPILER_TYPE). To be called by _core, which is
/// loaded first, before any class is added.
void protectBaseClass();

/// Protects the classes of a module: objects without a value cannot be used, pickle raises an error
/// where it would end the interpreter, and classes cannot be changed. To be called when all classes
/// have been added.
void protectClasses(const py::module_& module);

/// Adds a submodule whose objects say that they are of a public module.
/// \param name "_pose"
/// \param publicName "espalier.pose"
template <class Add>
void addSubmodule(py::module_& module, const char* name, const char* doc, const char* publicName,
                  Add add) {
    auto submodule = module.def_submodule(name, doc);
    submodule.attr("__module__") = publicName;
    add(submodule);
    py::delattr(submodule, "__module__");
}

/// Translates Error to ValueError and MemoryError to MemoryError, with the same text, for
/// exceptions of this shared object.
void translateErrors();

/// While it lives, a signal that Python answers by an exception, such as Ctrl-C, ends calls of this
/// thread to the library with that exception. To be made without the GIL.
class InterruptScope {
public:
    InterruptScope();

private:
    ProgressScope scope_;
};

/// Calls a function that touches no Python object, so that other threads can run Python meanwhile.
template <class Function>
auto withoutGil(Function&& function) {
    const py::gil_scoped_release release;
    const InterruptScope scope;
    return std::forward<Function>(function)();
}

/// Does the same for a function that makes an object for Python.
template <class Function>
auto sharedWithoutGil(Function&& function) {
    return withoutGil(
        [&] { return std::make_shared<decltype(function())>(std::forward<Function>(function)()); });
}

/// Issues a UserWarning, unless the text is empty.
inline void warn(const std::string& text) {
    if (!text.empty() && PyErr_WarnEx(PyExc_UserWarning, text.c_str(), 1) != 0)
        throw py::error_already_set();
}

}  // namespace espalier::python

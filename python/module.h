// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/progress.h>
#include <pybind11/pybind11.h>

#include <memory>
#include <utility>

namespace espalier::python {

namespace py = pybind11;

// What each source of the module adds to it; types before the functions that take them.
void addLattice(py::module_& module);
void addShapes(py::module_& module);
void addModel(py::module_& module);
void addStencilTable(py::module_& module);
void addRefiner(py::module_& module);
void addCompiledTables(py::module_& module);
void addBinding(py::module_& module);
void addFit(py::module_& module);
void addDesignVariables(py::module_& module);
void addValidity(py::module_& module);
void addHolding(py::module_& module);
void addLimits(py::module_& module);

/// Lets no call of the class that pybind11 derives all classes from end the interpreter. That class
/// is Espalier's alone (PYBIND11_COMPILER_TYPE). For _core, which is loaded first; before any
/// class is added, since classes inherit from it.
void protectBaseClass();

/// Lets no object of the classes of a module be used before it has a value, pickle raise where it
/// would end the interpreter, and no class be changed. After all classes were added.
void protectClasses(const py::module_& module);

/// Makes ValueError of Error, with the same text, in what this shared object throws.
void translateErrors();

/// Ends what this thread asks of the library when a signal comes that Python answers by an
/// exception: Ctrl-C. The exception arrives where the call was. Made without the GIL.
class InterruptScope {
public:
    InterruptScope();

private:
    ProgressScope scope_;
};

/// Calls a function that touches no Python object, while other threads run Python.
template <class Function>
auto withoutGil(Function&& function) {
    const py::gil_scoped_release release;
    const InterruptScope scope;
    return std::forward<Function>(function)();
}

/// The same for an object that Python is to hold.
template <class Function>
auto sharedWithoutGil(Function&& function) {
    return withoutGil(
        [&] { return std::make_shared<decltype(function())>(std::forward<Function>(function)()); });
}

}  // namespace espalier::python

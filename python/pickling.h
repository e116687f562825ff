// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/shapes/lattice.h>
#include <pybind11/pybind11.h>

#include <memory>

#include "binding.h"

// Pickling of immutable objects: as tuples of arrays, and of a binding as the bytes of its file,
// from which they are made again bit for bit.
namespace espalier::python {

/// Return the state of an object. Its arrays refer to the numbers of the object.
py::tuple stateOfLattice(const py::object& lattice);
py::tuple stateOfTable(const py::object& table);
py::tuple stateOfBinding(const py::object& binding);

/// Make an object from its state.
/// \throws Error if it is not the state of such an object
std::shared_ptr<Lattice> latticeOfState(const py::tuple& state);
std::shared_ptr<Table> tableOfState(const py::tuple& state);
std::shared_ptr<BoundPoints> bindingOfState(const py::tuple& state);

/// Lets a class be pickled and copied. A copy is the object itself, as for a tuple.
template <class Class, class ToState, class OfState>
void addPickling(Class& type, ToState toState, OfState ofState) {
    using namespace py::literals;
    type.def(py::pickle(toState, ofState))
        .def("__copy__", [](const py::object& self) { return self; })
        .def(
            "__deepcopy__", [](const py::object& self, const py::object&) { return self; },
            "memo"_a);
}

}  // namespace espalier::python

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/progress.h>
#include <pybind11/pybind11.h>

#include <utility>

namespace espalier::python {

namespace py = pybind11;

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

}  // namespace espalier::python

// SPDX-License-Identifier: Apache-2.0
#include "without_gil.h"

#include <thread>

namespace espalier::python {

InterruptScope::InterruptScope()
    : scope_([caller = std::this_thread::get_id()](const Progress&) {
          // Python answers signals on its main thread alone; that of another call does nothing
          // here.
          if (std::this_thread::get_id() != caller) return true;
          const py::gil_scoped_acquire acquire;
          if (PyErr_CheckSignals() != 0) throw py::error_already_set();
          return true;
      }) {}

}  // namespace espalier::python

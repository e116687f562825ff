// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/memory.h>

#include <exception>
#include <string_view>

#include "module.h"

namespace espalier::python {
namespace {

/// Raises an exception with a message that may have bytes which are not UTF-8: names of files, and
/// texts of theirs. These bytes are shown as "\\xff".
void raise(PyObject* type, std::string_view message) {
    const auto text = py::reinterpret_steal<py::object>(PyUnicode_DecodeUTF8(
        message.data(), static_cast<Py_ssize_t>(message.size()), "backslashreplace"));
    if (text) PyErr_SetObject(type, text.ptr());
}

}  // namespace

void translateErrors() {
    py::register_local_exception_translator([](std::exception_ptr thrown) {
        try {
            std::rethrow_exception(thrown);
        } catch (const MemoryError& error) {
            raise(PyExc_MemoryError, error.what());
        } catch (const Error& error) {
            raise(PyExc_ValueError, error.what());
        } catch (const py::cast_error& error) {
            // pybind11 says so of an object without a value, where it is to be shared.
            const std::string_view message = error.what();
            raise(PyExc_TypeError, message.find("non-held") == message.npos
                                       ? message
                                       : "the object was made by __new__ and has no value; call "
                                         "its class instead");
        }
    });
}

}  // namespace espalier::python

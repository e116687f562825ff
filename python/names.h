// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <string_view>

// Names that files have, such as those of attributes. They are bytes, mostly UTF-8, and str in
// Python. As in Python's names of files, each byte that is not UTF-8 is a surrogate ("\xff" is
// "\udcff"), so that a name that goes out and comes back has the same bytes.
namespace espalier::python {

namespace py = pybind11;

/// The str of a name.
inline py::str strOfName(std::string_view name) {
    PyObject* const text =
        PyUnicode_DecodeUTF8(name.data(), static_cast<Py_ssize_t>(name.size()), "surrogateescape");
    if (text == nullptr) throw py::error_already_set();
    return py::reinterpret_steal<py::str>(text);
}

/// The name of a str.
/// \throws py::error_already_set, a ValueError, for a surrogate that stands for no byte
inline std::string nameOfStr(const py::str& text) {
    const auto bytes = py::reinterpret_steal<py::bytes>(
        PyUnicode_AsEncodedString(text.ptr(), "utf-8", "surrogateescape"));
    if (!bytes) throw py::error_already_set();
    return bytes;
}

}  // namespace espalier::python

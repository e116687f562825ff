// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "module.h"

namespace espalier::python {
namespace {

/// Called by pybind11 where an object has no value yet: it would take memory without a value in it.
void* refuseWithoutValue(std::size_t) {
    throw py::type_error("the object was made by __new__ and has no value; call its class instead");
}

/// What pickle makes an object of. Not as object.__reduce__() does for protocols 0 and 1, by a call
/// of the base class of pybind11, which ends the interpreter.
py::tuple reduce(const py::object& self, const py::args&) {
    const py::object type = py::type::of(self);
    if (!py::hasattr(type, "__setstate__"))
        throw py::type_error("cannot pickle an object of type " +
                             py::str(type.attr("__name__")).cast<std::string>());
    return py::make_tuple(py::module_::import("copyreg").attr("__newobj__"), py::make_tuple(type),
                          self.attr("__getstate__")());
}

}  // namespace

void protectClasses(const py::module_& module) {
    const py::dict attributes = module.attr("__dict__");
    for (const auto& [name, attribute] : attributes) {
        if (!PyType_Check(attribute.ptr())) continue;
        auto* const type = reinterpret_cast<PyTypeObject*>(attribute.ptr());
        py::detail::type_info* const info = py::detail::get_type_info(type);
        if (info == nullptr) continue;
        info->operator_new = &refuseWithoutValue;
        for (const char* method : {"__reduce__", "__reduce_ex__"})
            py::setattr(attribute, method,
                        py::cpp_function(&reduce, py::name(method), py::is_method(attribute)));
    }
}

}  // namespace espalier::python

// SPDX-License-Identifier: Apache-2.0
// What this module has to tell the interpreter: errors, signals, and classes that it cannot misuse.
#include <espalier/base/error.h>
#include <espalier/base/memory.h>

#include <exception>
#include <new>
#include <string>
#include <string_view>
#include <thread>

#include "module.h"

namespace espalier::python {
namespace {

constexpr const char* kNoValue =
    "the object was made by __new__ and has no value; call the class instead";

/// Called by pybind11 where an object has no value yet: it would take memory without a value in it.
void* refuseWithoutValue(std::size_t) {
    throw py::type_error(kNoValue);
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

/// Lets a class, and objects of it, be changed in nothing: an object of one class that is given
/// another, `lattice.__class__ = Binding`, would be read as what it is not. Python 3.9 cannot.
void makeImmutable([[maybe_unused]] PyTypeObject* type) {
#ifdef Py_TPFLAGS_IMMUTABLETYPE
    type->tp_flags |= Py_TPFLAGS_IMMUTABLETYPE;
#endif
}

/// In place of pybind11_object_new(), which throws through Python where a class has nothing of C++:
/// pybind11_object itself, and classes that Python derives from that alone.
PyObject* newObject(PyTypeObject* type, PyObject*, PyObject*) {
    try {
        if (py::detail::all_type_info(type).empty())
            return PyErr_Format(PyExc_TypeError, "%.200s: No constructor defined!", type->tp_name);
        PyObject* const self = type->tp_alloc(type, 0);
        if (self != nullptr) reinterpret_cast<py::detail::instance*>(self)->allocate_layout();
        return self;
    } catch (const std::bad_alloc&) {
        return PyErr_NoMemory();
    } catch (const std::exception& error) {
        PyErr_SetString(PyExc_RuntimeError, error.what());
        return nullptr;
    }
}

/// Raises an exception with a message that may have bytes which are not UTF-8: names of files, and
/// texts of theirs. These bytes are shown as "\\xff".
void raise(PyObject* type, std::string_view message) {
    const auto text = py::reinterpret_steal<py::object>(PyUnicode_DecodeUTF8(
        message.data(), static_cast<Py_ssize_t>(message.size()), "backslashreplace"));
    if (text) PyErr_SetObject(type, text.ptr());
}

}  // namespace

void protectBaseClass() {
    const auto& internals = py::detail::get_internals();
    auto* const base = reinterpret_cast<PyTypeObject*>(internals.instance_base);
    base->tp_new = &newObject;
    makeImmutable(base);
    makeImmutable(internals.default_metaclass);
}

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
        makeImmutable(type);
    }
}

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
            raise(PyExc_TypeError, message.find("non-held") == message.npos ? message : kNoValue);
        }
    });
}

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

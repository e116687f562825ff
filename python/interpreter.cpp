// SPDX-License-Identifier: Apache-2.0
// The module and the interpreter: errors, signals, and protection of classes.
#include <espalier/base/argument_error.h>
#include <espalier/base/memory.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <map>
#include <new>
#include <string>
#include <string_view>
#include <thread>

#include "module.h"

namespace espalier::python {
namespace {

constexpr const char* kNoValue =
    "the object was made by __new__ and has no value; call the class instead";

/// pybind11 calls this function for an object without a value; without it, pybind11 would allocate
/// memory for a value.
void* refuseWithoutValue(std::size_t) {
    throw py::type_error(kNoValue);
}

/// Returns what pickle needs to make an object. (For protocols 0 and 1, object.__reduce__() would
/// call the base class of pybind11, which ends the interpreter.)
py::tuple reduce(const py::object& self, const py::args&) {
    const py::object type = py::type::of(self);
    if (!py::hasattr(type, "__setstate__"))
        throw py::type_error("cannot pickle an object of type " +
                             py::str(type.attr("__name__")).cast<std::string>());
    return py::make_tuple(py::module_::import("copyreg").attr("__newobj__"), py::make_tuple(type),
                          self.attr("__getstate__")());
}

/// Makes a class immutable, and fixes the class of its objects: after `lattice.__class__ =
/// Binding`, a lattice would be read as a binding. Python 3.9 has no such flag.
void makeImmutable([[maybe_unused]] PyTypeObject* type) {
#ifdef Py_TPFLAGS_IMMUTABLETYPE
    type->tp_flags |= Py_TPFLAGS_IMMUTABLETYPE;
#endif
}

/// Replaces pybind11_object_new(). That function throws a C++ exception through Python for a class
/// without a C++ type: pybind11_object itself, and Python classes that derive from no other class.
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

using Clock = std::chrono::steady_clock;

/// Time between two questions for signals. Each question waits for the GIL.
constexpr std::chrono::milliseconds kInterval(20);

/// Returns the name of an argument of Python, "minor_radius", for a field of the library,
/// "minorRadius"; or the name of a function.
std::string nameInPython(const std::string& name) {
    // The names that differ by more than underscores. (`from` is a keyword of Python.)
    static const std::map<std::string, std::string> kOthers = {{"from", "start"},
                                                               {"to", "end"},
                                                               {"cellsAlongLongest", "cells"},
                                                               {"falloff.radius", "falloff_radius"},
                                                               {"limitTolerance", "tolerance"},
                                                               {"maxStep", "most"}};
    if (const auto other = kOthers.find(name); other != kOthers.end()) return other->second;
    // A joint is a row of an array: "joints[1, 3]" for "joints[1].radius".
    static const std::map<std::string, std::string> kColumns = {
        {"].position", ":3"}, {"].radius", "3"}, {"].twist", "4"}};
    const std::size_t end = std::min(name.find(']'), name.size());
    if (const auto column = kColumns.find(name.substr(end)); column != kColumns.end())
        return name.substr(0, end) + ", " + column->second + "]";
    return separated(name, '_');
}

/// Raises an exception. Bytes of the message that are not UTF-8, in names and texts of files, are
/// shown as "\\xff".
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
        } catch (const ArgumentError& error) {
            raise(PyExc_ValueError,
                  error.message([](const std::string& name) { return nameInPython(name); }));
        } catch (const Error& error) {
            raise(PyExc_ValueError, error.what());
        } catch (const py::cast_error& error) {
            // pybind11 throws this if an object without a value is to be shared.
            const std::string_view message = error.what();
            raise(PyExc_TypeError, message.find("non-held") == message.npos ? message : kNoValue);
        }
    });
}

InterruptScope::InterruptScope()
    : scope_(
          [caller = std::this_thread::get_id(), last = Clock::now()](const Progress&) mutable {
              // Python handles signals on its main thread only, so other threads have nothing to
              // do. They must not use up the interval of this thread either: with many threads, it
              // would seldom be its turn.
              if (std::this_thread::get_id() != caller || Clock::now() - last < kInterval)
                  return true;
              const py::gil_scoped_acquire acquire;
              if (PyErr_CheckSignals() != 0) throw py::error_already_set();
              last = Clock::now();
              return true;
          },
          std::chrono::milliseconds(0)) {}

}  // namespace espalier::python

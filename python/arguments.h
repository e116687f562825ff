// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>
#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/base/printable.h>
#include <espalier/base/word.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "module.h"

// Conversion of arrays, names, words and shared objects from and to Python. A wrong argument throws
// an Error that names the argument, what was expected and what was given.
//
// An array argument is anything that NumPy can convert to an array of numbers. Names in files, such
// as the names of attributes, are bytes, mostly UTF-8; in Python they are str. As in Python's file
// names, a byte that is not UTF-8 becomes a surrogate ("\xff" is "\udcff"), so that a name that
// goes to Python and back keeps its bytes.
namespace espalier::python {

/// Any object. Signatures in docstrings show its type as Kind::kName.
template <class Kind>
class Like : public py::object {
    PYBIND11_OBJECT_DEFAULT(Like, object, [](PyObject*) { return true; })
};

struct ArrayKind {
    static constexpr auto kName = py::detail::const_name("ArrayLike");
};
using ArrayLike = Like<ArrayKind>;

/// Return str() of an object, and the name of its type.
std::string textOf(const py::handle& object);
std::string typeName(const py::handle& object);

/// Returns a shape as text: "(27, 3)".
std::string shapeText(std::span<const py::ssize_t> shape);
inline std::string shapeText(const py::array& array) {
    return shapeText(std::span(array.shape(), array.ndim()));
}

/// Returns whether a type is a 32-bit float, of either byte order.
bool isFloat32(const py::dtype& type);

/// The requirements on arrays that C++ reads: C order, and aligned numbers. NumPy copies other
/// arrays, and arrays of another type.
inline constexpr int kReadable =
    py::array::c_style | py::array::forcecast | py::detail::npy_api::NPY_ARRAY_ALIGNED_;

/// Returns whether the numbers of an array are aligned.
inline bool isAligned(const py::array& array) {
    return (array.flags() & py::detail::npy_api::NPY_ARRAY_ALIGNED_) != 0;
}

/// Returns an array of finite numbers, of any shape, in C order. Copies only if the object is not
/// such an array already. Real is float or double.
template <class Real>
py::array_t<Real> realArray(const py::handle& object, const std::string& name);

/// Returns the positions in an array of shape (N, 3), or (count, 3) if `count` is given.
std::vector<Point3> toPoints(const py::handle& object, const std::string& name,
                             std::optional<std::size_t> count = {});

/// Returns an array of integers, of any shape, in C order.
/// \throws Error for an integer that an Index cannot hold
py::array_t<Index> indexArray(const py::handle& object, const std::string& name);

/// Returns the integers of a one-dimensional array.
std::vector<Index> toIndices(const py::handle& object, const std::string& name);

/// The rows of a two-dimensional array of integers.
struct IndexRows {
    py::array_t<Index> array;
    std::size_t count() const { return array.shape(0); }
    std::size_t length() const { return array.shape(1); }
    std::span<const Index> operator[](std::size_t row) const {
        return {array.data() + row * length(), length()};
    }
};

/// Returns the rows of an array of integers, or nothing if the object is not an array.
/// \param expected the shape, for the message: "(F, k)"
/// \throws Error if the array does not have two dimensions
std::optional<IndexRows> indexRows(const py::object& object, const std::string& name,
                                   const std::string& expected);

/// Returns an object as a sequence.
/// \param expected for the message: "a list of loops"
/// \throws Error if it is none, or a str
py::sequence sequenceOf(const py::handle& object, const std::string& name,
                        const std::string& expected);

/// Returns a read-only array over numbers that belong to `owner`. The array keeps the owner alive.
template <class T>
py::array viewOf(std::span<const T> values, std::vector<py::ssize_t> shape, py::handle owner) {
    py::array array(py::dtype::of<T>(), std::move(shape), values.data(), owner);
    array.attr("setflags")(py::arg("write") = false);
    return array;
}

/// Returns a one-dimensional view of all values.
template <class T>
py::array viewOf(std::span<const T> values, py::handle owner) {
    return viewOf(values, {static_cast<py::ssize_t>(values.size())}, owner);
}

/// Returns a view of positions, of shape (N, 3).
inline py::array viewOf(std::span<const Point3> points, py::handle owner) {
    return viewOf(std::span(points.data()->data(), 3 * points.size()),
                  {static_cast<py::ssize_t>(points.size()), 3}, owner);
}

/// Returns an object that owns a vector, for an array over its numbers.
template <class T>
py::capsule ownerOf(std::unique_ptr<std::vector<T>> values) {
    py::capsule owner(values.get(), [](void* held) {
        delete static_cast<std::vector<T>*>(held);  // NOLINT: a capsule owns by void*
    });
    values.release();
    return owner;
}

/// Moves a vector into an array.
template <class T>
py::array_t<T> toArray(std::vector<T> values) {
    auto kept = std::make_unique<std::vector<T>>(std::move(values));
    const T* const data = kept->data();
    const auto size = static_cast<py::ssize_t>(kept->size());
    return py::array_t<T>(size, data, ownerOf(std::move(kept)));
}

/// Moves positions into an array of shape (N, 3).
inline py::array_t<double> toArray(std::vector<Point3> points) {
    auto kept = std::make_unique<std::vector<Point3>>(std::move(points));
    const double* const data = kept->data()->data();
    const auto size = static_cast<py::ssize_t>(kept->size());
    return py::array_t<double>({size, py::ssize_t{3}}, data, ownerOf(std::move(kept)));
}

/// Converts a name to str.
inline py::str strOfName(std::string_view name) {
    PyObject* const text =
        PyUnicode_DecodeUTF8(name.data(), static_cast<Py_ssize_t>(name.size()), "surrogateescape");
    if (text == nullptr) throw py::error_already_set();
    return py::reinterpret_steal<py::str>(text);
}

/// Converts a str to a name.
/// \throws py::error_already_set, a ValueError, for a surrogate that does not encode a byte
inline std::string nameOfStr(const py::str& text) {
    const auto bytes = py::reinterpret_steal<py::bytes>(
        PyUnicode_AsEncodedString(text.ptr(), "utf-8", "surrogateescape"));
    if (!bytes) throw py::error_already_set();
    return bytes;
}

/// Returns the choice that a word names. The words are the same as in the program's options.
/// \throws Error naming the argument, the possible words, and the given one
template <class Choice, std::size_t n>
Choice chosen(const Word<Choice> (&words)[n], const std::string& argument,
              const std::string& given) {
    std::string names;
    for (std::size_t i = 0; i < n; ++i) {
        if (words[i].text == given) return words[i].choice;
        names += i == 0 ? "" : i + 1 == n ? " or " : ", ";
        names += words[i].text;
    }
    throw Error(argument + ": expected " + names + ", got \"" + printable(given) + "\"");
}

/// Returns the choice that a word names, or nothing for None.
template <class Choice, std::size_t n>
std::optional<Choice> chosen(const Word<Choice> (&words)[n], const std::string& argument,
                             const std::optional<std::string>& given) {
    return given ? std::optional(chosen(words, argument, *given)) : std::nullopt;
}

/// Returns the word of a choice; nothing, which becomes None, if there is no choice.
template <class Choice, std::size_t n>
std::optional<std::string_view> wordOf(const Word<Choice> (&words)[n],
                                       std::optional<Choice> choice) {
    for (const Word<Choice>& word : words)
        if (word.choice == choice) return word.text;
    return std::nullopt;
}

/// A shared pointer argument that is never null. (For a plain std::shared_ptr, pybind11 would
/// accept None and pass null.)
template <class T>
class Shared {
public:
    Shared() = default;  ///< null until the caster has found the object
    explicit Shared(std::shared_ptr<T> pointer) : pointer_(std::move(pointer)) {}

    T& operator*() const { return *pointer_; }
    T* operator->() const { return pointer_.get(); }
    operator const std::shared_ptr<T>&() const { return pointer_; }

private:
    std::shared_ptr<T> pointer_;
};

/// Returns a function for a property. (Given the method itself, pybind11 would call it on a null
/// pointer for None.)
template <class Result, class T>
auto getter(Result (T::*method)() const) {
    return [method](const T& self) -> Result { return (self.*method)(); };
}

}  // namespace espalier::python

namespace pybind11::detail {

template <class Kind>
struct handle_type_name<espalier::python::Like<Kind>> {
    static constexpr auto name = Kind::kName;
};

template <class T>
class type_caster<espalier::python::Shared<T>> {
public:
    PYBIND11_TYPE_CASTER(espalier::python::Shared<T>, make_caster<T>::name);

    bool load(handle source, bool convert) {
        make_caster<std::shared_ptr<T>> caster;
        if (source.is_none() || !caster.load(source, convert)) return false;
        value = espalier::python::Shared<T>(static_cast<std::shared_ptr<T>&>(caster));
        return true;
    }
};

}  // namespace pybind11::detail

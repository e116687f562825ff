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

// What comes from Python and goes there: arrays, names, words and shared objects. What does not fit
// is refused by an Error that names the argument, what was expected and what was there.
//
// An array that comes in is anything that NumPy makes an array of numbers of. Names that files
// have, such as those of attributes, are bytes, mostly UTF-8, and str in Python. As in Python's
// names of files, each byte that is not UTF-8 is a surrogate ("\xff" is "\udcff"), so that a name
// that goes out and comes back has the same bytes.
namespace espalier::python {

/// Any object, by the name that signatures give it: Kind::kName.
template <class Kind>
class Like : public py::object {
    PYBIND11_OBJECT_DEFAULT(Like, object, [](PyObject*) { return true; })
};

struct ArrayKind {
    static constexpr auto kName = py::detail::const_name("ArrayLike");
};
using ArrayLike = Like<ArrayKind>;

/// What str() says of an object, and the name of its type.
std::string textOf(const py::handle& object);
std::string typeName(const py::handle& object);

/// "(27, 3)".
std::string shapeText(std::span<const py::ssize_t> shape);
inline std::string shapeText(const py::array& array) {
    return shapeText(std::span(array.shape(), array.ndim()));
}

/// Whether numbers are of 32 bits, in any order of their bytes.
bool isFloat32(const py::dtype& type);

/// What arrays have to be whose numbers C++ reads: in C order, each where the processor wants it.
/// NumPy makes a copy of any other, and of numbers of another type.
inline constexpr int kReadable =
    py::array::c_style | py::array::forcecast | py::detail::npy_api::NPY_ARRAY_ALIGNED_;

/// Whether each number of an array is where the processor wants it.
inline bool isAligned(const py::array& array) {
    return (array.flags() & py::detail::npy_api::NPY_ARRAY_ALIGNED_) != 0;
}

/// Finite numbers of any shape, in C order; a copy only where they are not such an array already.
/// Real is float or double.
template <class Real>
py::array_t<Real> realArray(const py::handle& object, const std::string& name);

/// The positions of an array of shape (N, 3), or with `count` of (count, 3).
std::vector<Point3> toPoints(const py::handle& object, const std::string& name,
                             std::optional<std::size_t> count = {});

/// Integers of any shape, in C order, that an Index can hold.
py::array_t<Index> indexArray(const py::handle& object, const std::string& name);

/// The integers of an array of one dimension.
std::vector<Index> toIndices(const py::handle& object, const std::string& name);

/// A read-only array of numbers that belong to `owner`, which it keeps alive.
template <class T>
py::array viewOf(std::span<const T> values, std::vector<py::ssize_t> shape, py::handle owner) {
    py::array array(py::dtype::of<T>(), std::move(shape), values.data(), owner);
    array.attr("setflags")(py::arg("write") = false);
    return array;
}

/// The same for all of them in a row.
template <class T>
py::array viewOf(std::span<const T> values, py::handle owner) {
    return viewOf(values, {static_cast<py::ssize_t>(values.size())}, owner);
}

/// The same for positions: shape (N, 3).
inline py::array viewOf(std::span<const Point3> points, py::handle owner) {
    return viewOf(std::span(points.data()->data(), 3 * points.size()),
                  {static_cast<py::ssize_t>(points.size()), 3}, owner);
}

/// What keeps a vector for an array of its numbers.
template <class T>
py::capsule ownerOf(std::unique_ptr<std::vector<T>> values) {
    py::capsule owner(values.get(), [](void* held) {
        delete static_cast<std::vector<T>*>(held);  // NOLINT: a capsule owns by void*
    });
    values.release();
    return owner;
}

/// An array that owns what was a vector.
template <class T>
py::array_t<T> toArray(std::vector<T> values) {
    auto kept = std::make_unique<std::vector<T>>(std::move(values));
    const T* const data = kept->data();
    const auto size = static_cast<py::ssize_t>(kept->size());
    return py::array_t<T>(size, data, ownerOf(std::move(kept)));
}

/// The same for positions: shape (N, 3).
inline py::array_t<double> toArray(std::vector<Point3> points) {
    auto kept = std::make_unique<std::vector<Point3>>(std::move(points));
    const double* const data = kept->data()->data();
    const auto size = static_cast<py::ssize_t>(kept->size());
    return py::array_t<double>({size, py::ssize_t{3}}, data, ownerOf(std::move(kept)));
}

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

/// The choice that a word names; the words are the same as those of the program's options.
/// \throws Error naming the argument, the words that there are, and the one that was given
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

/// The same where None names no choice.
template <class Choice, std::size_t n>
std::optional<Choice> chosen(const Word<Choice> (&words)[n], const std::string& argument,
                             const std::optional<std::string>& given) {
    return given ? std::optional(chosen(words, argument, *given)) : std::nullopt;
}

/// The word of a choice, and None for none.
template <class Choice, std::size_t n>
std::optional<std::string_view> wordOf(const Word<Choice> (&words)[n],
                                       std::optional<Choice> choice) {
    for (const Word<Choice>& word : words)
        if (word.choice == choice) return word.text;
    return std::nullopt;
}

/// What an argument shares with its caller. Never null: pybind11 makes a null std::shared_ptr of
/// None, where a function takes one.
template <class T>
class Shared {
public:
    Shared() = default;  ///< for the caster alone, until it has found what to share
    explicit Shared(std::shared_ptr<T> pointer) : pointer_(std::move(pointer)) {}

    T& operator*() const { return *pointer_; }
    T* operator->() const { return pointer_.get(); }
    operator const std::shared_ptr<T>&() const { return pointer_; }

private:
    std::shared_ptr<T> pointer_;
};

/// What a property calls. Given a method itself, pybind11 would call that on a null pointer for
/// None.
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

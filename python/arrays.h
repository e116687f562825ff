// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "without_gil.h"

// NumPy arrays in and out. What comes in is anything that NumPy makes an array of numbers of; what
// does not fit is refused by an Error that names the argument, what was expected and what was
// there.
namespace espalier::python {

namespace py = pybind11;

/// Any object, by the name that signatures give it.
class ArrayLike : public py::object {
    PYBIND11_OBJECT_DEFAULT(ArrayLike, object, [](PyObject*) { return true; })
};

/// What str() says of an object, and the name of its type.
std::string textOf(const py::handle& object);
std::string typeName(const py::handle& object);

/// "(27, 3)".
std::string shapeText(std::span<const py::ssize_t> shape);
inline std::string shapeText(const py::array& array) {
    return shapeText({array.shape(), static_cast<std::size_t>(array.ndim())});
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

/// The same for positions: shape (N, 3).
inline py::array viewOf(const std::vector<Point3>& points, py::handle owner) {
    return viewOf(std::span<const double>(points.data()->data(), 3 * points.size()),
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

}  // namespace espalier::python

namespace pybind11::detail {

template <>
struct handle_type_name<espalier::python::ArrayLike> {
    static constexpr auto name = const_name("ArrayLike");
};

}  // namespace pybind11::detail

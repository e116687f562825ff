// SPDX-License-Identifier: Apache-2.0
#include "arguments.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace espalier::python {

std::string textOf(const py::handle& object) {
    return nameOfStr(py::str(object));
}

std::string typeName(const py::handle& object) {
    return textOf(py::type::handle_of(object).attr("__name__"));
}

namespace {

/// Returns an object as an array of numbers. `kinds` are NumPy's letters for the accepted types.
py::array numberArray(const py::handle& object, const std::string& name, const std::string& kinds,
                      const std::string& expected) {
    auto array = py::array::ensure(object);
    if (!array)
        throw Error(name + ": expected an array of " + expected + ", got " + typeName(object));
    // NumPy gives an empty list the type float64, whatever the caller meant.
    if (array.size() > 0 && kinds.find(array.dtype().kind()) == std::string::npos)
        throw Error(name + ": expected an array of " + expected + ", got " + textOf(array.dtype()));
    return array;
}

/// Returns the indices of entry `at` of an array as text: "[3, 1]".
std::string placeText(const py::array& array, py::ssize_t at) {
    std::string text;
    for (py::ssize_t axis = array.ndim() - 1; axis >= 0; --axis) {
        text = std::to_string(at % array.shape(axis)) + (text.empty() ? "" : ", ") + text;
        at /= array.shape(axis);
    }
    return text.empty() ? text : "[" + text + "]";
}

template <class Real>
void checkFinite(const py::array_t<Real>& array, const std::string& name) {
    const std::span<const Real> values(array.data(), array.size());
    // No early exit, so that the compiler vectorises the loop.
    bool areFinite = true;
    for (const Real value : values)
        areFinite &= std::abs(value) <= std::numeric_limits<Real>::max();
    if (areFinite) return;
    const auto bad = std::find_if(values.begin(), values.end(),
                                  [](Real value) { return !std::isfinite(value); });
    throw Error(concat(name, placeText(array, bad - values.begin()), " is ", *bad,
                       "; expected a finite number"));
}

}  // namespace

bool isFloat32(const py::dtype& type) {
    return type.kind() == 'f' && type.itemsize() == sizeof(float);
}

std::string shapeText(std::span<const py::ssize_t> shape) {
    std::string text;
    for (const py::ssize_t size : shape) text += (text.empty() ? "" : ", ") + std::to_string(size);
    return "(" + text + (shape.size() == 1 ? ",)" : ")");
}

template <class Real>
py::array_t<Real> realArray(const py::handle& object, const std::string& name) {
    const py::array array = numberArray(object, name, "fiu", "real numbers");
    const auto values = py::array_t<Real, kReadable>::ensure(array);
    if (!values) throw py::error_already_set();
    checkFinite<Real>(values, name);
    return values;
}
template py::array_t<float> realArray(const py::handle&, const std::string&);
template py::array_t<double> realArray(const py::handle&, const std::string&);

std::vector<Point3> toPoints(const py::handle& object, const std::string& name,
                             std::optional<std::size_t> count) {
    const auto array = realArray<double>(object, name);
    if (array.ndim() != 2 || array.shape(1) != 3 ||
        (count && std::cmp_not_equal(array.shape(0), *count)))
        throw Error(name + ": expected an array of shape (" +
                    (count ? std::to_string(*count) : "N") + ", 3), got " + shapeText(array));
    std::vector<Point3> points(array.shape(0));
    for (std::size_t i = 0; i < points.size(); ++i)
        std::copy_n(array.data() + 3 * i, 3, points[i].begin());
    return points;
}

py::array_t<Index> indexArray(const py::handle& object, const std::string& name) {
    const py::array array = numberArray(object, name, "iu", "integers");
    const bool isUnsigned = array.dtype().kind() == 'u';
    // Converts by the widest type of the same sign, so that no integer is truncated unnoticed.
    py::array_t<Index> result(
        std::vector<py::ssize_t>(array.shape(), array.shape() + array.ndim()));
    const auto narrow = [&](const auto& wide) {
        if (!wide) throw py::error_already_set();
        for (py::ssize_t i = 0; i < wide.size(); ++i) {
            const auto value = wide.data()[i];
            if (!std::in_range<Index>(value))
                throw Error(concat(name, placeText(array, i), " is ", value,
                                   "; expected an integer that fits into 32 bits"));
            result.mutable_data()[i] = static_cast<Index>(value);
        }
    };
    if (isUnsigned)
        narrow(py::array_t<std::uint64_t, kReadable>::ensure(array));
    else
        narrow(py::array_t<std::int64_t, kReadable>::ensure(array));
    return result;
}

std::vector<Index> toIndices(const py::handle& object, const std::string& name) {
    const auto array = indexArray(object, name);
    if (array.ndim() != 1)
        throw Error(name + ": expected an array of one dimension, got shape " + shapeText(array));
    return {array.data(), array.data() + array.size()};
}

std::optional<IndexRows> indexRows(const py::object& object, const std::string& name,
                                   const std::string& expected) {
    if (!py::isinstance<py::array>(object)) return std::nullopt;
    IndexRows rows{indexArray(object, name)};
    if (rows.array.ndim() != 2)
        throw Error(name + ": expected an array of shape " + expected + ", got " +
                    shapeText(rows.array));
    return rows;
}

py::sequence sequenceOf(const py::handle& object, const std::string& name,
                        const std::string& expected) {
    if (!py::isinstance<py::sequence>(object) || py::isinstance<py::str>(object))
        throw Error(name + ": expected " + expected + ", got " + typeName(object));
    return py::reinterpret_borrow<py::sequence>(object);
}

}  // namespace espalier::python

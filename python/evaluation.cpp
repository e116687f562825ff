// SPDX-License-Identifier: Apache-2.0
#include "evaluation.h"

#include <espalier/base/error.h>

#include <cstdint>

namespace espalier::python {
namespace {

using Shape = std::vector<py::ssize_t>;

Shape shapeOf(const py::array& array) {
    return {array.shape(), array.shape() + array.ndim()};
}

/// The numbers of sets and components of a shape.
struct Parts {
    py::ssize_t sets = 1;
    py::ssize_t components = 1;
};

template <class Real>
Parts partsOf(const ArrayEvaluation<Real>& evaluation, const py::array& values) {
    const auto& [source, sourceRows, rows, components, run, ofAll] = evaluation;
    const py::ssize_t dimensions = values.ndim();
    const bool isVector = dimensions == 1 && !components;
    const bool hasSets = dimensions == 3;
    if (isVector || dimensions == 2 || hasSets) {
        const Parts parts{hasSets ? values.shape(0) : 1,
                          isVector ? 1 : values.shape(dimensions - 1)};
        if (values.shape(hasSets ? 1 : 0) == sourceRows && parts.components > 0 &&
            (!components || parts.components == *components))
            return parts;
    }
    const std::string n = std::to_string(sourceRows);
    const std::string k = components ? std::to_string(*components) : "k";
    throw Error(source + ": expected an array of shape (" + n + ", " + k + ") or (P, " + n + ", " +
                k + ")" + (components ? "" : " or (" + n + ",)") + ", got " + shapeText(values));
}

template <class Real>
py::array_t<Real> checkedOut(const py::handle& object, const Shape& shape,
                             const py::array& values) {
    if (!py::isinstance<py::array>(object))
        throw Error("out: expected an array, got " + typeName(object));
    const auto array = py::reinterpret_borrow<py::array>(object);
    if (shapeOf(array) != shape)
        throw Error("out: expected an array of shape " + shapeText(shape) + ", got " +
                    shapeText(array));
    if (!py::isinstance<py::array_t<Real, py::array::c_style>>(array))
        throw Error("out: expected an array of " + textOf(py::dtype::of<Real>()) +
                    " in C order, got " + textOf(array.dtype()) +
                    (py::isinstance<py::array_t<Real>>(array) ? " in another order" : ""));
    if (!isAligned(array)) throw Error("out: the numbers of the array are not aligned in memory");
    if (!array.writeable()) throw Error("out: the array is read-only");
    const auto begin = [](const py::array& each) {
        return reinterpret_cast<std::uintptr_t>(each.data());
    };
    const auto end = [&](const py::array& each) {
        return begin(each) + static_cast<std::uintptr_t>(each.nbytes());
    };
    if (begin(array) < end(values) && begin(values) < end(array))
        throw Error("out: the array overlaps the input array");
    return py::reinterpret_borrow<py::array_t<Real>>(array);
}

}  // namespace

template <class Real>
py::array evaluate(const ArrayEvaluation<Real>& evaluation, const ArrayLike& values,
                   const std::optional<ArrayLike>& out) {
    const auto source = realArray<Real>(values, evaluation.source);
    const Parts parts = partsOf(evaluation, source);
    Shape shape = shapeOf(source);
    shape[source.ndim() == 3 ? 1 : 0] = evaluation.rows;
    auto result = out ? checkedOut<Real>(*out, shape, source) : py::array_t<Real>(shape);
    const auto layout = osd::BufferDescriptor::packed(parts.components);
    const std::size_t from = evaluation.sourceRows * parts.components;
    const std::size_t to = evaluation.rows * parts.components;
    const Real* const first = source.data();
    Real* const firstResult = result.mutable_data();
    withoutGil([&] {
        if (evaluation.runTakesAllSets)
            return evaluation.run({first, from * parts.sets}, layout,
                                  {firstResult, to * parts.sets});
        for (py::ssize_t set = 0; set < parts.sets; ++set)
            evaluation.run({first + set * from, from}, layout, {firstResult + set * to, to});
    });
    return result;
}

template py::array evaluate(const ArrayEvaluation<float>&, const ArrayLike&,
                            const std::optional<ArrayLike>&);
template py::array evaluate(const ArrayEvaluation<double>&, const ArrayLike&,
                            const std::optional<ArrayLike>&);

}  // namespace espalier::python

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <variant>

#include "evaluation.h"
#include "shared.h"

namespace espalier::python {

/// What evaluates a table in either precision. Evaluator is osd::CompiledTable,
/// osd::CompiledAdjoint or osd::ChangeEvaluator.
template <template <class> class Evaluator>
class InEither {
public:
    using Variant = std::variant<Evaluator<float>, Evaluator<double>>;

    explicit InEither(Variant variant) : variant_(std::move(variant)) {}

    const Variant& variant() const { return variant_; }

    std::pair<Index, Index> shape() const {
        return std::visit(
            [](const auto& evaluator) {
                return std::pair(evaluator.rowCount(), evaluator.columnCount());
            },
            variant_);
    }

    std::size_t byteCount() const {
        return std::visit([](const auto& evaluator) { return evaluator.byteCount(); }, variant_);
    }

    py::dtype dtype() const {
        return std::holds_alternative<Evaluator<float>>(variant_) ? py::dtype::of<float>()
                                                                  : py::dtype::of<double>();
    }

private:
    Variant variant_;
};

/// Evaluates arrays of any number of components by run(evaluator, source, layout, result).
template <template <class> class Evaluator, class Run>
py::array evaluateBy(const InEither<Evaluator>& either, const ArrayLike& values,
                     const std::optional<ArrayLike>& out, Run run) {
    return std::visit(
        [&]<class Real>(const Evaluator<Real>& evaluator) {
            return evaluate<Real>(
                {"values",
                 evaluator.columnCount(),
                 evaluator.rowCount(),
                 {},
                 [&](std::span<const Real> source, const osd::BufferDescriptor& layout,
                     std::span<Real> result) { run(evaluator, source, layout, result); }},
                values, out);
        },
        either.variant());
}

/// The properties that all of them have.
template <template <class> class Evaluator>
void addProperties(py::class_<InEither<Evaluator>>& type) {
    using Either = InEither<Evaluator>;
    type.def_property_readonly("shape", getter(&Either::shape), "Rows and columns: tuple of 2 int.")
        .def_property_readonly("dtype", getter(&Either::dtype), "numpy.float32 or float64.")
        .def_property_readonly("nbytes", getter(&Either::byteCount),
                               "Memory that it takes, in bytes.");
}

}  // namespace espalier::python

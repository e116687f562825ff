// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/osd/change_evaluator.h>
#include <espalier/osd/compiled_adjoint.h>
#include <espalier/osd/compiled_table.h>
#include <pybind11/stl.h>

#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "evaluation.h"
#include "module.h"
#include "tables.h"

namespace espalier::python {

using namespace py::literals;

namespace {

/// An evaluator of a table in float or double. Evaluator is osd::CompiledTable,
/// osd::CompiledAdjoint or osd::ChangeEvaluator.
template <template <class> class Evaluator>
class EitherPrecision {
public:
    using Variant = std::variant<Evaluator<float>, Evaluator<double>>;

    explicit EitherPrecision(Variant variant) : variant_(std::move(variant)) {}

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
py::array evaluateBy(const EitherPrecision<Evaluator>& either, const ArrayLike& values,
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

/// Adds the properties that all evaluators have.
template <template <class> class Evaluator>
void addProperties(py::class_<EitherPrecision<Evaluator>>& type) {
    using Either = EitherPrecision<Evaluator>;
    type.def_property_readonly("shape", getter(&Either::shape), "Rows and columns: tuple of 2 int.")
        .def_property_readonly("dtype", getter(&Either::dtype), "numpy.float32 or float64.")
        .def_property_readonly("nbytes", getter(&Either::byteCount),
                               "Memory that it takes, in bytes.");
}

/// Returns whether a dtype is float32.
/// \throws Error for a dtype that is neither float32 nor float64
bool isSingle(const py::object& dtype) {
    const py::dtype type = py::dtype::from_args(dtype);
    const char kind = type.kind();
    if (isFloat32(type)) return true;
    if (kind == 'f' && type.itemsize() == sizeof(double)) return false;
    throw Error("dtype: expected float32 or float64, got " + textOf(type));
}

template <template <class> class Compiled>
void addCompiled(py::module_& module, const char* name, const char* text,
                 const char* evaluateText) {
    using Either = EitherPrecision<Compiled>;
    using Variant = typename Either::Variant;
    py::class_<Either> type(module, name, text);
    type.def(py::init([](const TableLike& like, const py::object& dtype) {
                 const auto table = tableOf(like);
                 const bool single = isSingle(dtype);
                 return withoutGil([&] {
                     return Either(single ? Variant(osd::compile<Compiled, float>(*table))
                                          : Variant(osd::compile<Compiled, double>(*table)));
                 });
             }),
             "table"_a, py::kw_only(), "dtype"_a = "float64")
        .def(
            "evaluate",
            [](const Either& self, const ArrayLike& values, const std::optional<ArrayLike>& out) {
                return evaluateBy(
                    self, values, out,
                    [](const auto& compiled, const auto& source, const auto& layout,
                       const auto& result) {
                        compiled.evaluate(source, layout, result, layout, {0, compiled.rowCount()});
                    });
            },
            "values"_a, "out"_a = py::none(), evaluateText);
    addProperties(type);
}

/// Returns a ChangeEvaluator in the precision of a compiled table.
EitherPrecision<osd::ChangeEvaluator> changeEvaluatorOf(
    const EitherPrecision<osd::CompiledTable>& table) {
    return std::visit(
        []<class Real>(const osd::CompiledTable<Real>& compiled) {
            return EitherPrecision<osd::ChangeEvaluator>(osd::ChangeEvaluator<Real>(compiled));
        },
        table.variant());
}

/// Returns the changed columns.
/// \throws Error for a column that does not exist
std::vector<Index> columnsOf(const ArrayLike& changed,
                             const EitherPrecision<osd::ChangeEvaluator>& evaluator) {
    auto columns = toIndices(changed, "changed");
    const Index count = evaluator.shape().second;
    for (const Index column : columns)
        if (column < 0 || column >= count)
            throw Error(concat("changed: there is no column ", column, "; there are ", count,
                               ", numbered from 0"));
    return columns;
}

void addChangeEvaluator(py::module_& module) {
    using Either = EitherPrecision<osd::ChangeEvaluator>;
    py::class_<Either> type(module, "ChangeEvaluator", R"(
Updates only the results that depend on a few changed vertices, for example while a vertex is dragged.
Shares the memory of the compiled table. Any number of threads may use it.

table : CompiledTable; its precision is used
)");
    type.def(py::init([](const EitherPrecision<osd::CompiledTable>& table) {
                 return withoutGil([&] { return changeEvaluatorOf(table); });
             }),
             "table"_a)
        .def(
            "evaluate_changed",
            [](const Either& self, const ArrayLike& values, const ArrayLike& changed,
               const ArrayLike& out) {
                const auto columns = columnsOf(changed, self);
                return evaluateBy(self, values, out,
                                  [&](const auto& evaluator, const auto& source, const auto& layout,
                                      const auto& result) {
                                      evaluator.evaluateChanged(source, layout, result, layout,
                                                                columns);
                                  });
            },
            "values"_a, "changed"_a, "out"_a, R"(
Writes the rows of table @ values that depend on changed columns, with the same bits as
CompiledTable.evaluate(). Other rows of `out` are left as they are: they must be the result for values
that differed from these in the changed columns only.

values  : array (columns, k), or (P, columns, k) for P poses at once, or (columns,), with the changes
changed : array (C,) of int, the columns whose values have changed, in any order
out     : array (rows, k), (P, rows, k) or (rows,), in C order and of this dtype
Returns `out`.
)")
        .def(
            "rows",
            [](const Either& self, const ArrayLike& changed) {
                const auto columns = columnsOf(changed, self);
                return toArray(withoutGil([&] {
                    return std::visit(
                        [&](const auto& evaluator) { return evaluator.rowsOf(columns); },
                        self.variant());
                }));
            },
            "changed"_a,
            "Returns the rows that evaluate_changed() writes: array (R,) of int32, ascending. "
            "changed "
            ": array (C,) of int, the changed columns");
    addProperties(type);
}

}  // namespace

void addCompiledTables(py::module_& module) {
    addCompiled<osd::CompiledTable>(module, "CompiledTable", R"(
A table in a compact form that is fast to evaluate many times. Any number of threads may use it.

table : StencilTable, Binding, or a sparse matrix of SciPy
dtype : float64, or float32 for weights and values in single precision
)",
                                    R"(
Returns table @ values: an array (rows, k), (P, rows, k) or (rows,).

values : array (columns, k), or (P, columns, k) for P poses at once, or (columns,)
out    : array for the result, in C order and of this dtype; by default a new array
)");
    addCompiled<osd::CompiledAdjoint>(module, "CompiledAdjoint", R"(
The transpose of a table in a form that is fast to evaluate: it turns gradients with respect to the
rows of the table into gradients with respect to its columns.

table : StencilTable, Binding, or a sparse matrix of SciPy: D, not its transpose
dtype : float64, or float32 for weights and values in single precision
)",
                                      R"(
Returns table.T @ values: an array (columns, k), (P, columns, k) or (columns,).

values : array (rows, k), or (P, rows, k) for P arrays at once, or (rows,)
out    : array for the result, in C order and of this dtype; by default a new array
)");
    addChangeEvaluator(module);
}

}  // namespace espalier::python

// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/osd/compiled_adjoint.h>
#include <espalier/osd/compiled_table.h>
#include <pybind11/stl.h>

#include <memory>
#include <string>
#include <utility>
#include <variant>

#include "evaluation.h"
#include "module.h"
#include "tables.h"

namespace espalier::python {

using namespace py::literals;

namespace {

/// Whether a dtype is float32; of others only float64 will do.
bool isSingle(const py::object& dtype) {
    const py::dtype type = py::dtype::from_args(dtype);
    const char kind = type.kind();
    if (kind == 'f' && type.itemsize() == sizeof(float)) return true;
    if (kind == 'f' && type.itemsize() == sizeof(double)) return false;
    throw Error("dtype: expected float32 or float64, got " + textOf(type));
}

/// A table compiled in either precision. Compiled is osd::CompiledTable or osd::CompiledAdjoint.
template <template <class> class Compiled>
class InEither {
public:
    InEither(const Table& table, bool isSingle)
        : compiled_(isSingle ? Variant(compile<Compiled, float>(table))
                             : Variant(compile<Compiled, double>(table))) {}

    py::array evaluate(const ArrayLike& values, const std::optional<ArrayLike>& out) const {
        return std::visit([&](const auto& compiled) { return evaluateBy(compiled, values, out); },
                          compiled_);
    }

    std::pair<far::Index, far::Index> shape() const {
        return std::visit(
            [](const auto& compiled) {
                return std::pair(compiled.rowCount(), compiled.columnCount());
            },
            compiled_);
    }

    std::size_t byteCount() const {
        return std::visit([](const auto& compiled) { return compiled.byteCount(); }, compiled_);
    }

    py::dtype dtype() const {
        return std::holds_alternative<Compiled<float>>(compiled_) ? py::dtype::of<float>()
                                                                  : py::dtype::of<double>();
    }

private:
    using Variant = std::variant<Compiled<float>, Compiled<double>>;

    template <class Real>
    static py::array evaluateBy(const Compiled<Real>& compiled, const ArrayLike& values,
                                const std::optional<ArrayLike>& out) {
        return python::evaluate<Real>(
            {"values",
             compiled.columnCount(),
             compiled.rowCount(),
             {},
             [&](std::span<const Real> source, const osd::BufferDescriptor& layout,
                 std::span<Real> result) {
                 compiled.evaluate(source, layout, result, layout, {0, compiled.rowCount()});
             }},
            values, out);
    }

    Variant compiled_;
};

template <template <class> class Compiled>
void addCompiled(py::module_& module, const char* name, const char* text,
                 const char* evaluateText) {
    using Either = InEither<Compiled>;
    py::class_<Either>(module, name, text)
        .def(py::init([](const TableLike& like, const py::object& dtype) {
                 const auto table = tableOf(like);
                 const bool single = isSingle(dtype);
                 return withoutGil([&] { return std::make_unique<Either>(*table, single); });
             }),
             "table"_a, py::kw_only(), "dtype"_a = "float64")
        .def_property_readonly("shape", &Either::shape, "Rows and columns: tuple of 2 int.")
        .def_property_readonly("dtype", &Either::dtype, "numpy.float32 or float64.")
        .def_property_readonly("nbytes", &Either::byteCount, "Memory that it takes, in bytes.")
        .def("evaluate", &Either::evaluate, "values"_a, "out"_a = py::none(), evaluateText);
}

}  // namespace

void addCompiledTables(py::module_& module) {
    addCompiled<osd::CompiledTable>(module, "CompiledTable", R"(
A table in the form that is quickest to evaluate, again and again. Any number of threads may.

table : StencilTable, Binding, or a sparse matrix of SciPy
dtype : float64, or float32 for weights and values in single precision
)",
                                    R"(
table @ values.

values : array (columns, k), or (P, columns, k) for P poses at once, or (columns,)
out    : array for the result, in C order and of this dtype; a new one without
Returns an array (rows, k), (P, rows, k) or (rows,).
)");
    addCompiled<osd::CompiledAdjoint>(module, "CompiledAdjoint", R"(
The transpose of a table in the form that is quickest to evaluate: gradients by the rows of the table
become gradients by its columns.

table : StencilTable, Binding, or a sparse matrix of SciPy: D, not its transpose
dtype : float64, or float32 for weights and values in single precision
)",
                                      R"(
table.T @ values.

values : array (rows of the table, k), or (P, rows, k) for P of them at once, or (rows,)
out    : array for the result, in C order and of this dtype; a new one without
Returns an array (columns of the table, k), (P, columns, k) or (columns,).
)");
}

}  // namespace espalier::python

// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/matrices/matrix_file.h>
#include <pybind11/stl/filesystem.h>

#include <string>
#include <utility>

#include "arguments.h"
#include "binding.h"
#include "pickling.h"
#include "tables.h"

namespace espalier::python {

using namespace py::literals;

namespace {

// SciPy converts a sparse matrix in C and trusts its arrays, but anybody may have changed them. So
// they are checked first.

std::pair<Offset, Offset> shapeOf(const py::object& matrix) {
    return matrix.attr("shape").cast<std::pair<Offset, Offset>>();
}

/// Returns an array of a matrix.
/// \throws Error naming the array if it is not a one-dimensional array of integers
py::array_t<Offset> integersOf(const py::object& matrix, const char* name) {
    const auto array = py::array::ensure(matrix.attr(name));
    if (!array || array.ndim() != 1 || array.dtype().kind() != 'i')
        throw Error(std::string(name) + ": expected an array of integers, of one dimension");
    const auto integers = py::array_t<Offset, kReadable>::ensure(array);
    if (!integers) throw py::error_already_set();
    return integers;
}

[[noreturn]] void refuse(const std::string& name, py::ssize_t at, Offset value,
                         const std::string& expected) {
    throw Error(concat(name, "[", at, "] is ", value, "; expected ", expected));
}

/// Checks that an array of row or column numbers has `count` entries or more, all from 0 to bound
/// - 1.
void checkNumbers(const py::object& matrix, const char* name, Offset count, Offset bound) {
    const auto numbers = integersOf(matrix, name);
    if (numbers.size() < count)
        throw Error(concat(name, ": expected ", count, " entries, got ", numbers.size()));
    for (py::ssize_t i = 0; i < numbers.size(); ++i)
        if (const Offset number = numbers.data()[i]; number < 0 || number >= bound)
            refuse(name, i, number, "0 to " + std::to_string(bound - 1));
}

Offset lengthOfData(const py::object& matrix) {
    const auto data = py::array::ensure(matrix.attr("data"));
    if (!data || data.ndim() == 0) throw Error("data: expected an array of numbers");
    return data.shape(0);
}

/// Checks the arrays of a compressed matrix.
/// \param major number of rows (csr), columns (csc) or rows of blocks (bsr)
/// \param minor number of the other
void checkCompressed(const py::object& matrix, Offset major, Offset minor) {
    const auto offsets = integersOf(matrix, "indptr");
    if (offsets.size() != major + 1)
        throw Error(concat("indptr: expected ", major + 1, " entries, got ", offsets.size()));
    const Offset* const values = offsets.data();
    if (values[0] != 0) refuse("indptr", 0, values[0], "0");
    for (py::ssize_t i = 1; i < offsets.size(); ++i)
        if (values[i] < values[i - 1])
            refuse("indptr", i, values[i], std::to_string(values[i - 1]) + " or more");
    const Offset last = values[major];
    checkNumbers(matrix, "indices", last, minor);
    if (const Offset length = lengthOfData(matrix); length < last)
        refuse("indptr", major, last, std::to_string(length) + " at most, which data has");
}

/// Checks the arrays of a csr, csc, bsr or coo matrix of SciPy, so that it can be converted. SciPy
/// checks the arrays of other formats. \throws Error naming the first entry that does not fit
void checkMatrix(const py::object& matrix) {
    const std::string format =
        py::hasattr(matrix, "format") ? textOf(matrix.attr("format")) : std::string();
    const auto [rows, columns] = shapeOf(matrix);
    if (format == "csr") {
        checkCompressed(matrix, rows, columns);
    } else if (format == "csc") {
        checkCompressed(matrix, columns, rows);
    } else if (format == "bsr") {
        const auto [height, width] = matrix.attr("blocksize").cast<std::pair<Offset, Offset>>();
        if (height < 1 || width < 1 || rows % height != 0 || columns % width != 0)
            throw Error(concat("data: blocks of ", height, " x ", width,
                               " do not fill a matrix of ", rows, " x ", columns));
        checkCompressed(matrix, rows / height, columns / width);
    } else if (format == "coo") {
        const Offset length = lengthOfData(matrix);
        checkNumbers(matrix, "row", length, rows);
        checkNumbers(matrix, "col", length, columns);
    }
}

/// Returns a view of an array of a table. The view keeps the table alive.
template <class T>
py::array arrayOf(std::span<const T> values, const std::shared_ptr<Table>& table) {
    return viewOf(values, py::cast(table));
}

std::shared_ptr<Table> tableOfMatrix(const py::object& matrix) {
    checkMatrix(matrix);
    // Makes columns ascending and unique in a copy, since the matrix is the caller's.
    const py::object rows = matrix.attr("tocsr")("copy"_a = true);
    rows.attr("sum_duplicates")();
    const auto shape = shapeOf(rows);
    if (!std::in_range<Index>(shape.first) || !std::in_range<Index>(shape.second))
        throw Error(
            concat("a matrix of ", shape.first, " x ", shape.second, " is too large for a table"));
    const auto offsets = integersOf(rows, "indptr");
    const auto columns = indexArray(rows.attr("indices"), "indices");
    const auto weights = realArray<double>(rows.attr("data"), "data");
    const auto copyOf = [](const auto& array) {
        return Array<std::remove_cvref_t<decltype(*array.data())>>(array.data(),
                                                                   array.data() + array.size());
    };
    return sharedWithoutGil([&] {
        return Table(static_cast<Index>(shape.second), copyOf(offsets), copyOf(columns),
                     copyOf(weights));
    });
}

}  // namespace

std::shared_ptr<Table> tableOf(const TableLike& object) {
    if (py::isinstance<Table>(object)) return object.cast<std::shared_ptr<Table>>();
    if (py::isinstance<BoundPoints>(object))
        return tableIn(object.cast<std::shared_ptr<BoundPoints>>());
    if (!py::hasattr(object, "tocsr"))
        throw py::type_error(
            "expected a StencilTable, a Binding or a sparse matrix of SciPy, got " +
            typeName(object));
    return tableOfMatrix(object);
}

py::object csrOf(const std::shared_ptr<Table>& table) {
    py::object columns = arrayOf(table->columns(), table);
    py::object offsets = arrayOf(table->offsets(), table);
    // SciPy wants both in the same width, and would otherwise copy them itself.
    if (table->entryCount() <= kMaxIndex)
        offsets = offsets.attr("astype")("int32");
    else
        columns = columns.attr("astype")("int64");
    const py::object type = py::module_::import("scipy.sparse").attr("csr_matrix");
    py::object matrix =
        type(py::make_tuple(arrayOf(table->weights(), table), columns, offsets),
             "shape"_a = py::make_tuple(table->rowCount(), table->columnCount()), "copy"_a = false);
    // The columns are sorted and unique. Otherwise SciPy would try to sort arrays that are
    // read-only.
    matrix.attr("has_canonical_format") = true;
    return matrix;
}

void addStencilTable(py::module_& module) {
    py::class_<Table, std::shared_ptr<Table>> type(module, "StencilTable", R"(
A sparse matrix of weights in compressed sparse rows, double precision, immutable: result i is the
sum over k from offsets[i] to offsets[i + 1] of weights[k] * source[columns[k]].

matrix : a sparse matrix of SciPy, which is copied, with columns ascending; or a Binding
)");
    type.def(py::init([](const TableLike& matrix) { return tableOf(matrix); }), "matrix"_a)
        .def_property_readonly(
            "shape",
            [](const Table& self) { return std::pair(self.rowCount(), self.columnCount()); },
            "Numbers of rows and columns: tuple of 2 int.")
        .def_property_readonly("nnz", getter(&Table::entryCount), "Number of entries: int.")
        .def_property_readonly(
            "offsets", [](const Shared<Table>& self) { return arrayOf(self->offsets(), self); },
            "The first entry of each row, and the end: array (rows + 1,) of int64, read-only, not "
            "a copy.")
        .def_property_readonly(
            "columns",
            [](const Shared<Table>& self) { return arrayOf(std::as_const(*self).columns(), self); },
            "The column of each entry: array (nnz,) of int32, read-only, not a copy.")
        .def_property_readonly(
            "weights",
            [](const Shared<Table>& self) { return arrayOf(std::as_const(*self).weights(), self); },
            "The weight of each entry: array (nnz,) of float64, read-only, not a copy.")
        .def(
            "csr", [](const Shared<Table>& self) { return csrOf(self); }, R"(
Returns the table as a scipy.sparse.csr_matrix over the same memory, which the matrix keeps alive.

Columns and weights are read-only and not copied. The offsets are copied to 32 bits, since SciPy wants
offsets and columns of the same width. (With 2^31 entries or more the columns are copied instead.)
)")
        .def(
            "write",
            [](const Table& self, const std::filesystem::path& path) {
                withoutGil([&] { io::writeMatrix(path, self); });
            },
            "path"_a,
            "Writes the table as Matrix Market (.mtx), for scipy.sparse.load_npz (.npz), for "
            "numpy.load (.npy: three files) or for PETSc (.petsc).")
        .def(
            "transpose",
            [](const Table& self) {
                return sharedWithoutGil([&] { return stencils::transposeTable(self); });
            },
            "Returns the transpose: a StencilTable of shape (columns, rows).")
        .def("__repr__", [](const Table& self) {
            return concat("<espalier.StencilTable: ", self.rowCount(), " x ", self.columnCount(),
                          ", ", self.entryCount(), " entries>");
        });
    addPickling(type, &stateOfTable, &tableOfState);
}

}  // namespace espalier::python

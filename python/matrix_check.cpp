// SPDX-License-Identifier: Apache-2.0
#include "matrix_check.h"

#include <espalier/base/error.h>

#include <string>

#include "arrays.h"

namespace espalier::python {
namespace {

[[noreturn]] void refuse(const std::string& name, py::ssize_t at, Offset value,
                         const std::string& expected) {
    throw Error(name + "[" + std::to_string(at) + "] is " + std::to_string(value) + "; expected " +
                expected);
}

/// That the first `count` of some integers are there, and are numbers of rows or columns.
void checkNumbers(const py::object& matrix, const char* name, Offset count, Offset bound) {
    const auto numbers = integersOf(matrix, name);
    if (numbers.size() < count)
        throw Error(std::string(name) + ": expected " + std::to_string(count) + " entries, got " +
                    std::to_string(numbers.size()));
    for (py::ssize_t i = 0; i < numbers.size(); ++i)
        if (const Offset number = numbers.data()[i]; number < 0 || number >= bound)
            refuse(name, i, number, "0 to " + std::to_string(bound - 1));
}

Offset lengthOfData(const py::object& matrix) {
    const auto data = py::array::ensure(matrix.attr("data"));
    if (!data || data.ndim() == 0) throw Error("data: expected an array of numbers");
    return data.shape(0);
}

/// \param major how many rows, or columns, or rows of blocks
/// \param minor how many of the other
void checkCompressed(const py::object& matrix, Offset major, Offset minor) {
    const auto offsets = integersOf(matrix, "indptr");
    if (offsets.size() != major + 1)
        throw Error("indptr: expected " + std::to_string(major + 1) + " entries, got " +
                    std::to_string(offsets.size()));
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

}  // namespace

std::pair<Offset, Offset> shapeOf(const py::object& matrix) {
    return matrix.attr("shape").cast<std::pair<Offset, Offset>>();
}

py::array_t<Offset> integersOf(const py::object& matrix, const char* name) {
    const auto array = py::array::ensure(matrix.attr(name));
    if (!array || array.ndim() != 1 || array.dtype().kind() != 'i')
        throw Error(std::string(name) + ": expected an array of integers, of one dimension");
    const auto integers = py::array_t<Offset, kReadable>::ensure(array);
    if (!integers) throw py::error_already_set();
    return integers;
}

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
            throw Error("data: blocks of " + std::to_string(height) + " x " +
                        std::to_string(width) + " do not fill a matrix of " + std::to_string(rows) +
                        " x " + std::to_string(columns));
        checkCompressed(matrix, rows / height, columns / width);
    } else if (format == "coo") {
        const Offset length = lengthOfData(matrix);
        checkNumbers(matrix, "row", length, rows);
        checkNumbers(matrix, "col", length, columns);
    }
}

}  // namespace espalier::python

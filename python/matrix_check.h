// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <pybind11/numpy.h>

#include <utility>

// What SciPy does to a sparse matrix it does in C, as the arrays of the matrix say; and these are
// anyone's to write to.
namespace espalier::python {

namespace py = pybind11;

std::pair<Offset, Offset> shapeOf(const py::object& matrix);

/// An array of a matrix, which has to be one of integers, of one dimension.
/// \throws Error naming it
py::array_t<Offset> integersOf(const py::object& matrix, const char* name);

/// Checks the arrays of a csr, csc, bsr or coo matrix of SciPy, so that it can be converted. Those
/// of other formats SciPy checks. \throws Error naming the first entry that does not fit
void checkMatrix(const py::object& matrix);

}  // namespace espalier::python

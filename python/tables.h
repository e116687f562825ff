// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/stencils/stencil_table.h>

#include <memory>
#include <type_traits>

#include "arguments.h"

namespace espalier::python {

using Table = stencils::StencilTable<double>;

/// An argument that is a StencilTable, a Binding or a sparse matrix of SciPy.
struct TableKind {
    static constexpr auto kName = py::detail::const_name("StencilTable | Binding | csr_matrix");
};
using TableLike = Like<TableKind>;

/// Returns the table of an argument. A matrix of SciPy is copied.
/// \throws py::type_error if it is none of these; Error for a matrix that is not a valid table
std::shared_ptr<Table> tableOf(const TableLike& object);

/// Returns a table as a scipy.sparse.csr_matrix over the same memory.
py::object csrOf(const std::shared_ptr<Table>& table);

}  // namespace espalier::python

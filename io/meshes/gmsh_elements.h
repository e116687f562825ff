// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/far/standard_cells.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

// The types of the elements of Gmsh, and the orders of their nodes.

namespace espalier::io {

/// A type of element: its dimension, its number of nodes, and its kind if it is a cell of first or
/// second order.
struct GmshElementType {
    std::int64_t number;
    int dimension;
    std::size_t nodes;
    std::optional<far::StandardCell> kind = {};
    bool isCurved = true;
    bool isSecondOrderFace = false;
};

/// Returns the type of a number; nothing if it is not known.
std::optional<GmshElementType> gmshElementType(std::int64_t number);

/// Brings the nodes of a cell of second order into the order of far::cellPoints().
std::vector<Index> gmshCellInVtkOrder(far::StandardCell kind, std::span<const Index> nodes);

}  // namespace espalier::io

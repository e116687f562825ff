// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace espalier::io {

/// A type of elements of I-deas.
struct IdeasElement {
    int dimension = 0;      ///< 0 to 3
    std::size_t nodes = 0;  ///< of a solid or a face of first or second order; 0 for all others
    bool isCurved = false;  ///< of second order
    bool isBeam = false;    ///< its nodes follow a line of other numbers
};

/// Returns the type of elements that a descriptor names; nothing for an unknown one.
std::optional<IdeasElement> ideasElement(std::int64_t descriptor);

/// Brings the nodes of an element of second order into VTK's order. I-deas has the nodes between
/// corners where they are on the way around: a triangle is corner, middle, corner, …; a solid is
/// one end in this order, then the nodes between the ends, then the other end.
std::vector<Index> ideasNodesInVtkOrder(int dimension, std::span<const Index> nodes);

}  // namespace espalier::io

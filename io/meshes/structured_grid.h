// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "../files/number_types.h"

// The cells of structured grids, whose points are numbered along x first, then y, then z.

namespace espalier::io {

/// The number of points of a block along its axes.
using Extent = std::array<std::size_t, 3>;

inline std::size_t pointCountOf(const Extent& extent) {
    return saturatingProduct(saturatingProduct(extent[0], extent[1]), extent[2]);
}

/// Calls visit(points) for each cell of a block, with the 8 points of a hexahedron.
template <class Visit>
void forEachHexahedron(const Extent& extent, std::size_t first, Visit visit) {
    const auto at = [&](std::size_t i, std::size_t j, std::size_t k) {
        return static_cast<Index>(first + i + extent[0] * (j + extent[1] * k));
    };
    for (std::size_t k = 0; k + 1 < extent[2]; ++k)
        for (std::size_t j = 0; j + 1 < extent[1]; ++j)
            for (std::size_t i = 0; i + 1 < extent[0]; ++i)
                visit(std::array<Index, 8>{at(i, j, k), at(i + 1, j, k), at(i + 1, j + 1, k),
                                           at(i, j + 1, k), at(i, j, k + 1), at(i + 1, j, k + 1),
                                           at(i + 1, j + 1, k + 1), at(i, j + 1, k + 1)});
}

inline bool isVolume(const Extent& extent) {
    return std::ranges::min(extent) > 1;
}

/// Calls visit(points) for each quadrilateral of a block of one layer.
template <class Visit>
void forEachQuadrilateral(const Extent& extent, std::size_t first, Visit visit) {
    // The two axes along which the block has more than one point.
    std::array<std::size_t, 2> stride{}, size{};
    std::size_t axes = 0, step = 1;
    for (const std::size_t along : extent) {
        if (along > 1 && axes < 2) {
            stride[axes] = step;
            size[axes++] = along;
        }
        step *= along;
    }
    if (axes < 2) return;
    for (std::size_t j = 0; j + 1 < size[1]; ++j)
        for (std::size_t i = 0; i + 1 < size[0]; ++i) {
            const std::size_t corner = first + i * stride[0] + j * stride[1];
            visit(std::array<Index, 4>{static_cast<Index>(corner),
                                       static_cast<Index>(corner + stride[0]),
                                       static_cast<Index>(corner + stride[0] + stride[1]),
                                       static_cast<Index>(corner + stride[1])});
        }
}

}  // namespace espalier::io

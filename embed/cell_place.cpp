// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/cell_place.h>
#include <espalier/embed/trilinear.h>
#include <espalier/far/standard_cells.h>

namespace espalier::embed {

std::array<Index, 3> tetrahedronBase(const far::CellComplex& complex, CellId cell,
                                     Index tetrahedron) {
    const Index face = complex.relation(3, 2)[cell.value][tetrahedron / 2];
    const auto loop = complex.relation(2, 0)[face];
    return tetrahedron % 2 == 0 ? std::array{loop[0], loop[1], loop[2]}
                                : std::array{loop[0], loop[2], loop[3]};
}

Index tetrahedronCount(const far::CellComplex& complex, CellId cell) {
    return 2 * static_cast<Index>(complex.relation(3, 2)[cell.value].size());
}

std::array<double, 8> hexahedronWeights(const CellPlace& place) {
    const Eigen::Vector3d uvw(place.uvw.data());
    Trilinear::Weights weights = Trilinear::weights(uvw);
    if (place.offset != std::array<double, 3>{}) {
        const auto derivatives = Trilinear::weightDerivatives(uvw);
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (std::size_t i = 0; i < 8; ++i)
                weights[i] += place.offset[axis] * derivatives[axis][i];
    }
    return weights;
}

std::vector<VertexWeight> placeWeights(const far::CellComplex& complex, const CellPlace& place) {
    std::vector<VertexWeight> result;
    if (const auto corners = far::hexahedronVertices(complex, place.cell)) {
        const auto weights = hexahedronWeights(place);
        for (std::size_t i = 0; i < 8; ++i)
            if (weights[i] != 0) result.push_back({(*corners)[i], weights[i]});
        return result;
    }
    double rest = 1;
    const auto base = tetrahedronBase(complex, place.cell, place.tetrahedron);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double weight = place.uvw[axis] + place.offset[axis];
        rest -= weight;
        if (weight != 0) result.push_back({base[axis], weight});
    }
    const auto vertices = complex.relation(3, 0)[place.cell.value];
    for (const Index vertex : vertices)
        result.push_back({vertex, rest / static_cast<double>(vertices.size())});
    return result;
}

std::vector<VertexWeight> directionWeights(const far::CellComplex& complex, const CellPlace& place,
                                           int axis) {
    const auto number = static_cast<std::size_t>(axis);
    std::vector<VertexWeight> result;
    if (const auto corners = far::hexahedronVertices(complex, place.cell)) {
        const auto weights =
            Trilinear::weightDerivatives(Eigen::Vector3d(place.uvw.data()))[number];
        for (std::size_t i = 0; i < 8; ++i) result.push_back({(*corners)[i], weights[i]});
        return result;
    }
    // From P₀ to a vertex of the base.
    result.push_back({tetrahedronBase(complex, place.cell, place.tetrahedron)[number], 1});
    const auto vertices = complex.relation(3, 0)[place.cell.value];
    for (const Index vertex : vertices)
        result.push_back({vertex, -1 / static_cast<double>(vertices.size())});
    return result;
}

}  // namespace espalier::embed

// SPDX-License-Identifier: Apache-2.0
#include "ideas_elements.h"

#include <algorithm>
#include <array>

namespace espalier::io {
namespace {

struct Numbered {
    std::int64_t descriptor;
    IdeasElement type;
};

constexpr IdeasElement kBeam = {1, 0, false, true}, kLine = {1, 0}, kPoint = {0, 0};
constexpr IdeasElement kIdeasTriangle = {2, 3}, kTriangle6 = {2, 6, true};
constexpr IdeasElement kIdeasQuadrilateral = {2, 4}, kQuadrilateral8 = {2, 8, true};
constexpr IdeasElement kCubicFace = {2, 0}, kCubicSolid = {3, 0};

constexpr Numbered kDescriptors[] = {
    // Rods and beams.
    {11, kBeam},
    {21, kBeam},
    {22, kBeam},
    {23, kBeam},
    {24, kBeam},
    // Plane stress, plane strain, plates, membranes, axial symmetry, thin shells.
    {41, kIdeasTriangle},
    {42, kTriangle6},
    {43, kCubicFace},
    {44, kIdeasQuadrilateral},
    {45, kQuadrilateral8},
    {46, kCubicFace},
    {51, kIdeasTriangle},
    {52, kTriangle6},
    {53, kCubicFace},
    {54, kIdeasQuadrilateral},
    {55, kQuadrilateral8},
    {56, kCubicFace},
    {61, kIdeasTriangle},
    {62, kTriangle6},
    {63, kCubicFace},
    {64, kIdeasQuadrilateral},
    {65, kQuadrilateral8},
    {66, kCubicFace},
    {71, kIdeasQuadrilateral},
    {72, kTriangle6},
    {73, kCubicFace},
    {74, kIdeasTriangle},
    {75, kQuadrilateral8},
    {76, kCubicFace},
    {81, kIdeasTriangle},
    {82, kTriangle6},
    {84, kIdeasQuadrilateral},
    {85, kQuadrilateral8},
    {91, kIdeasTriangle},
    {92, kTriangle6},
    {93, kCubicFace},
    {94, kIdeasQuadrilateral},
    {95, kQuadrilateral8},
    {96, kCubicFace},
    // Thick shells and solids.
    {101, {3, 6}},
    {102, {3, 15, true}},
    {103, kCubicSolid},
    {104, {3, 8}},
    {105, {3, 20, true}},
    {106, kCubicSolid},
    {111, {3, 4}},
    {112, {3, 6}},
    {113, {3, 15, true}},
    {114, kCubicSolid},
    {115, {3, 8}},
    {116, {3, 20, true}},
    {117, kCubicSolid},
    {118, {3, 10, true}},
    // As Salome writes pyramids, and libMesh quadrilaterals with a point in the middle.
    {300, {2, 9, true}},
    {312, {3, 5}},
    {313, {3, 13, true}},
    // Rigid bars, springs, dampers, gaps, shells of axial symmetry, masses.
    {121, kLine},
    {122, kLine},
    {136, kLine},
    {137, kLine},
    {138, kLine},
    {139, kLine},
    {141, kLine},
    {142, kLine},
    {151, kLine},
    {152, kLine},
    {161, kPoint},
    {171, kLine},
    {172, kLine},
};

constexpr std::array<std::size_t, 6> kTriangleOrder = {0, 2, 4, 1, 3, 5};
constexpr std::array<std::size_t, 8> kQuadrilateralOrder = {0, 2, 4, 6, 1, 3, 5, 7};
constexpr std::array<std::size_t, 9> kQuadrilateral9Order = {0, 2, 4, 6, 1, 3, 5, 7, 8};
constexpr std::array<std::size_t, 10> kTetrahedronOrder = {0, 2, 4, 9, 1, 3, 5, 6, 7, 8};
constexpr std::array<std::size_t, 13> kPyramidOrder = {0, 2, 4, 6, 12, 1, 3, 5, 7, 8, 9, 10, 11};
constexpr std::array<std::size_t, 15> kWedgeOrder = {0, 2,  4,  9,  11, 13, 1, 3,
                                                     5, 10, 12, 14, 6,  7,  8};
constexpr std::array<std::size_t, 20> kHexahedronOrder = {0, 2, 4,  6,  12, 14, 16, 18, 1,  3,
                                                          5, 7, 13, 15, 17, 19, 8,  9,  10, 11};

std::span<const std::size_t> orderOf(int dimension, std::size_t nodes) {
    if (dimension == 2 && nodes == 8) return kQuadrilateralOrder;
    switch (nodes) {
        case 6:
            return kTriangleOrder;
        case 9:
            return kQuadrilateral9Order;
        case 10:
            return kTetrahedronOrder;
        case 13:
            return kPyramidOrder;
        case 15:
            return kWedgeOrder;
        default:
            return kHexahedronOrder;
    }
}

}  // namespace

std::optional<IdeasElement> ideasElement(std::int64_t descriptor) {
    const auto found = std::ranges::find(kDescriptors, descriptor, &Numbered::descriptor);
    return found == std::end(kDescriptors) ? std::nullopt : std::optional(found->type);
}

std::vector<Index> ideasNodesInVtkOrder(int dimension, std::span<const Index> nodes) {
    std::vector<Index> ordered;
    for (const std::size_t node : orderOf(dimension, nodes.size())) ordered.push_back(nodes[node]);
    return ordered;
}

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/far/second_order_cells.h>

#include <algorithm>
#include <array>
#include <numeric>

namespace espalier::far {
namespace {

// The points of second order follow the corners. Each table has the larger number of points of a
// kind; the smaller number is a prefix of it.
constexpr std::array<CornerBits, 10> kTetrahedron = {
    between(0),    between(1),    between(2),    between(3),    between(0, 1),
    between(1, 2), between(2, 0), between(0, 3), between(1, 3), between(2, 3)};
constexpr std::array<CornerBits, 14> kPyramid = {
    between(0),    between(1),    between(2),    between(3),         between(4),
    between(0, 1), between(1, 2), between(2, 3), between(3, 0),      between(0, 4),
    between(1, 4), between(2, 4), between(3, 4), between(0, 1, 2, 3)};
constexpr std::array<CornerBits, 18> kWedge = {
    between(0),          between(1),          between(2),         between(3),    between(4),
    between(5),          between(0, 1),       between(1, 2),      between(2, 0), between(3, 4),
    between(4, 5),       between(5, 3),       between(0, 3),      between(1, 4), between(2, 5),
    between(0, 1, 4, 3), between(1, 2, 5, 4), between(2, 0, 3, 5)};
constexpr std::array<CornerBits, 27> kHexahedron = {
    between(0),          between(1),          between(2),
    between(3),          between(4),          between(5),
    between(6),          between(7),          between(0, 1),
    between(1, 2),       between(2, 3),       between(3, 0),
    between(4, 5),       between(5, 6),       between(6, 7),
    between(7, 4),       between(0, 4),       between(1, 5),
    between(2, 6),       between(3, 7),       between(0, 4, 7, 3),
    between(1, 2, 6, 5), between(0, 1, 5, 4), between(3, 7, 6, 2),
    between(0, 3, 2, 1), between(4, 5, 6, 7), between(0, 1, 2, 3, 4, 5, 6, 7)};

/// Returns the corners of the mirror image of a cell: corner i of the image is corner result[i].
std::array<std::size_t, 8> mirroredCorners(StandardCell kind) {
    switch (kind) {
        case StandardCell::Tetrahedron:
            return {0, 2, 1, 3};
        case StandardCell::Pyramid:
            return {0, 3, 2, 1, 4};
        case StandardCell::Wedge:
            return {3, 4, 5, 0, 1, 2};
        case StandardCell::Hexahedron:
            break;
    }
    return {4, 5, 6, 7, 0, 1, 2, 3};
}

}  // namespace

std::optional<StandardCell> kindOfCell(std::size_t pointCount) {
    switch (pointCount) {
        case 4:
        case 10:
            return StandardCell::Tetrahedron;
        case 5:
        case 13:
        case 14:
            return StandardCell::Pyramid;
        case 6:
        case 15:
        case 18:
            return StandardCell::Wedge;
        case 8:
        case 20:
        case 27:
            return StandardCell::Hexahedron;
        default:
            return std::nullopt;
    }
}

bool isSecondOrder(std::size_t pointCount) {
    const auto kind = kindOfCell(pointCount);
    return kind && std::cmp_not_equal(pointCount, vertexCount(*kind));
}

std::span<const CornerBits> cellPoints(std::size_t pointCount) {
    const auto places = [&]() -> std::span<const CornerBits> {
        switch (kindOfCell(pointCount).value()) {
            case StandardCell::Tetrahedron:
                return kTetrahedron;
            case StandardCell::Pyramid:
                return kPyramid;
            case StandardCell::Wedge:
                return kWedge;
            case StandardCell::Hexahedron:
                break;
        }
        return kHexahedron;
    }();
    return places.first(pointCount);
}

std::vector<Index> reorderedCell(std::span<const Index> points, std::span<const CornerBits> places,
                                 std::span<const std::size_t> corners) {
    std::vector<Index> result;
    for (const CornerBits wanted : cellPoints(points.size())) {
        unsigned inFile = 0;
        for (std::size_t corner = 0; corner < corners.size(); ++corner)
            if (wanted >> corner & 1) inFile |= 1u << corners[corner];
        const auto found = std::ranges::find(places, static_cast<CornerBits>(inFile));
        if (found == places.end())
            throw Error("a cell of second order has no point at one of its places");
        result.push_back(points[found - places.begin()]);
    }
    return result;
}

void mirrorCell(std::span<Index> points) {
    const StandardCell kind = kindOfCell(points.size()).value();
    const std::size_t cornerCount = vertexCount(kind);
    const auto corners = mirroredCorners(kind);
    std::ranges::copy(
        reorderedCell(points, cellPoints(points.size()), std::span(corners).first(cornerCount)),
        points.begin());
}

}  // namespace espalier::far

// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/progress.h>
#include <espalier/base/sort_unique.h>
#include <espalier/base/vector3.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "cage_surface.h"

namespace espalier::cages {
namespace {

/// Finds the control points of the patches of faces.
class PatchFinder {
public:
    explicit PatchFinder(const far::Level& level)
        : strata_(level.strata),
          edgesOfVertex_(level.complex.relation(0, 1)),
          edgesOfFace_(level.complex.relation(2, 1)),
          facesOfEdge_(level.complex.relation(1, 2)),
          loops_(level.complex.relation(2, 0)) {}

    /// Returns the control points of the patch of a face, if its limit is one patch.
    std::optional<std::array<Index, 16>> controlPoints(Index face) const {
        const auto loop = loops_[face];
        for (const Index vertex : loop) {
            const auto edges = edgesOfVertex_[vertex];
            if (edges.size() != 4 || strata_.of({0, vertex}) < 2) return std::nullopt;
            for (const Index edge : edges)
                if (strata_.of({1, edge}) < 2) return std::nullopt;
        }
        // For each side: its first corner, the points beside the side, and the point across the
        // corner.
        constexpr std::array<std::array<std::size_t, 4>, 4> kPlaces = {
            {{5, 1, 2, 0}, {6, 7, 11, 3}, {10, 14, 13, 15}, {9, 8, 4, 12}}};
        std::array<Index, 16> points = {};
        for (std::size_t side = 0; side < 4; ++side) {
            const Side next = behind({face, side});
            const Side across = behind({next.face, (next.number + 1) % 4});
            points[kPlaces[side][0]] = loop[side];
            points[kPlaces[side][1]] = corner(next, 2);
            points[kPlaces[side][2]] = corner(next, 3);
            points[kPlaces[side][3]] = corner(across, 3);
        }
        return points;
    }

private:
    /// The sides of a face follow its loop.
    struct Side {
        Index face;
        std::size_t number;
    };

    /// Returns a side from the other face at it, whose loop runs along the side the other way.
    Side behind(const Side& side) const {
        const Index edge = edgesOfFace_[side.face][side.number];
        const auto pair = facesOfEdge_[edge];
        const Index other = pair[0] == side.face ? pair[1] : pair[0];
        const auto edges = edgesOfFace_[other];
        const auto place = std::ranges::find(edges, edge) - edges.begin();
        return {other, static_cast<std::size_t>(place)};
    }

    Index corner(const Side& side, std::size_t ahead) const {
        return loops_[side.face][(side.number + ahead) % 4];
    }

    const far::Strata& strata_;
    const far::Incidence &edgesOfVertex_, &edgesOfFace_, &facesOfEdge_, &loops_;
};

/// Turns 4 × 4 control points of a B-spline into Bézier points, for one coordinate.
void toBezier(std::array<double, 16>& values) {
    const auto convert = [&](std::size_t first, std::size_t step) {
        double &a = values[first], &b = values[first + step], &c = values[first + 2 * step],
               &d = values[first + 3 * step];
        const double a0 = a, b0 = b, c0 = c, d0 = d;
        a = (a0 + 4 * b0 + c0) / 6;
        b = (2 * b0 + c0) / 3;
        c = (b0 + 2 * c0) / 3;
        d = (b0 + 4 * c0 + d0) / 6;
    };
    for (std::size_t i = 0; i < 4; ++i) convert(4 * i, 1);
    for (std::size_t i = 0; i < 4; ++i) convert(i, 4);
}

}  // namespace

CageSurface::Faces::Faces(const far::Level& level, std::vector<Index> cellsOfFaces)
    : cells(std::move(cellsOfFaces)) {
    const far::CellComplex& mesh = level.complex;
    const auto& edgesOfFace = mesh.relation(2, 1);
    const auto& facesOfEdge = mesh.relation(1, 2);
    const auto& endsOfEdge = mesh.relation(1, 0);
    for (Index face = 0; face < mesh.count(2); ++face) {
        const auto loop = mesh.relation(2, 0)[face];
        loops.push_back({loop[0], loop[1], loop[2], loop[3]});
    }
    // The faces around each corner of a face count, up to the sharp edges: the limit of the face
    // does not depend on the faces beyond them.
    const PatchFinder patches(level);
    std::vector<Index> hull;
    isPatch.assign(loops.size(), 0);
    for (Index face = 0; face < mesh.count(2); ++face) {
        checkCancelledEvery(face, 12);
        if (const auto points = patches.controlPoints(face)) {
            isPatch[face] = 1;
            hulls.insert(hulls.end(), points->begin(), points->end());
            hullOffsets.push_back(static_cast<Offset>(hulls.size()));
            continue;
        }
        hull.clear();
        for (std::size_t corner = 0; corner < 4; ++corner) {
            const Index vertex = loops[face][corner];
            bool isWholeRing = false;
            for (const std::size_t side : {corner, (corner + 3) % 4}) {
                if (isWholeRing) break;
                Index at = face, edge = edgesOfFace[face][side];
                for (;;) {
                    hull.insert(hull.end(), loops[at].begin(), loops[at].end());
                    if (level.strata.of({1, edge}) < 2) break;
                    const auto pair = facesOfEdge[edge];
                    at = pair[0] == at ? pair[1] : pair[0];
                    isWholeRing = at == face;
                    if (isWholeRing) break;
                    // The other edge of the next face at the vertex.
                    const auto edges = edgesOfFace[at];
                    for (std::size_t i = 0; i < 4; ++i) {
                        const auto ends = endsOfEdge[edges[i]];
                        if (edges[i] != edge && (ends[0] == vertex || ends[1] == vertex)) {
                            edge = edges[i];
                            break;
                        }
                    }
                }
            }
        }
        sortUnique(hull);
        hulls.insert(hulls.end(), hull.begin(), hull.end());
        hullOffsets.push_back(static_cast<Offset>(hulls.size()));
    }
}

void CageSurface::Faces::limitHull(Index face, std::span<const Point3> vertices,
                                   std::vector<Point3>& points) const {
    const std::span<const Index> control = hull(face);
    points.resize(control.size());
    for (std::size_t i = 0; i < control.size(); ++i) points[i] = vertices[control[i]];
    if (isPatch[face] == 0) return;
    std::array<double, 16> values;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t i = 0; i < 16; ++i) values[i] = points[i][axis];
        toBezier(values);
        for (std::size_t i = 0; i < 16; ++i) points[i][axis] = values[i];
    }
    for (const Index vertex : loops[face]) points.push_back(vertices[vertex]);
}

double CageSurface::Faces::lowestOfPatch(Index face, std::span<const Point3> vertices,
                                         const Point3& direction) const {
    const std::span<const Index> control = hull(face);
    std::array<double, 16> heights;
    for (std::size_t i = 0; i < 16; ++i) heights[i] = dot(direction, vertices[control[i]]);
    // The four in the middle are the corners of the face.
    double lowest = std::min({heights[5], heights[6], heights[9], heights[10]});
    toBezier(heights);
    for (const double height : heights) lowest = std::min(lowest, height);
    return lowest;
}

std::span<const Index> CageSurface::Faces::hull(Index face) const {
    return std::span(hulls).subspan(hullOffsets[face], hullOffsets[face + 1] - hullOffsets[face]);
}

}  // namespace espalier::cages

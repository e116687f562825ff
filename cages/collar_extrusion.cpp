// SPDX-License-Identifier: Apache-2.0
#include "collar_extrusion.h"

#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/base/vector3.h>
#include <espalier/far/standard_cells.h>
#include <espalier/far/surface_fans.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/shapes/selection.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace espalier::cages {
namespace {

using Loop = std::vector<Index>;

/// Returns the unit vector whose largest angle with some unit vectors is smallest, as far as steps
/// of decreasing length towards the farthest one find it.
/// \cite Badoiu & Clarkson 2003, Smaller core-sets for balls
Point3 middleOf(std::span<const Point3> directions, const Point3& start) {
    constexpr int kSteps = 60;
    Point3 middle = start;
    for (int step = 1; step <= kSteps; ++step) {
        Point3 farthest = directions[0];
        for (const Point3& direction : directions)
            if (dot(direction, middle) < dot(farthest, middle)) farthest = direction;
        const Point3 moved = sum(middle, scaled(difference(farthest, middle), 1.0 / (step + 1)));
        if (!(dot(moved, moved) > 1e-12)) break;
        middle = normalised(moved);
    }
    return middle;
}

class Extrusion {
public:
    Extrusion(const Lattice& lattice, const CollarOptions& options, const OpenFaces& open)
        : lattice_(lattice), options_(options) {
        findFaces(open);
        requireManifold();
        position_.reserve(vertices_.size());
        for (const Index vertex : vertices_) position_.push_back(lattice.positions[vertex]);
        neighbours_.resize(vertices_.size());
        facesAt_.resize(vertices_.size());
        for (std::size_t face = 0; face < loops_.size(); ++face) {
            const Loop& loop = loops_[face];
            for (std::size_t i = 0; i < loop.size(); ++i) {
                facesAt_[loop[i]].push_back(face);
                neighbours_[loop[i]].push_back(loop[(i + 1) % loop.size()]);
                neighbours_[loop[i]].push_back(loop[(i + loop.size() - 1) % loop.size()]);
            }
        }
    }

    /// \param parts of the reach, per vertex of the lattice
    CollarCells cells(std::span<const double> reachParts) {
        const Index first = lattice_.complex.count(0);
        const auto count = static_cast<Index>(vertices_.size());
        const auto parts = layerParts(options_.layers, options_.reach, meanThickness());
        CollarCells result;
        const std::vector<double> reach = reaches(reachParts);
        for (int layer = 1; layer <= options_.layers; ++layer) {
            const auto steps = stepsFrom(position_);
            for (std::size_t v = 0; v < vertices_.size(); ++v) {
                const double thickness = reach[v] * (parts[layer] - parts[layer - 1]);
                position_[v] = sum(position_[v], scaled(steps[v], thickness));
                result.vertices.push_back({vertices_[v], layer, position_[v], true, planes_[v]});
            }
        }
        const auto numberOf = [&](Index vertex, int layer) {
            return layer == 0 ? vertices_[vertex] : first + (layer - 1) * count + vertex;
        };
        for (int layer = 0; layer < options_.layers; ++layer)
            for (const Loop& loop : loops_) {
                CollarPrism prism;
                for (const Index vertex : loop) {
                    prism.bottom.push_back(numberOf(vertex, layer));
                    prism.top.push_back(numberOf(vertex, layer + 1));
                }
                result.prisms.push_back(std::move(prism));
            }
        markOuter(numberOf, result.marks);
        return result;
    }

private:
    /// Gives the edges and vertices of the outer boundary the sharpness of the ones that they are
    /// over. If they were smooth, the outer boundary would be rounded by more than a thin collar is
    /// thick, and fold through the next layer.
    template <class NumberOf>
    void markOuter(const NumberOf& numberOf, far::Marks& marks) const {
        const far::CellComplex& complex = lattice_.complex;
        const far::TopologyRefiner base(complex, refinerOptions(lattice_));
        const far::Strata& strata = base.level(0).strata;
        std::vector<Index> newNumber(lattice_.positions.size(), -1);
        for (std::size_t v = 0; v < vertices_.size(); ++v)
            newNumber[vertices_[v]] = static_cast<Index>(v);
        for (std::size_t v = 0; v < vertices_.size(); ++v)
            if (const float sharpness = strata.sharpness({0, vertices_[v]}); sharpness > 0)
                marks.vertices.push_back(
                    {numberOf(static_cast<Index>(v), options_.layers), sharpness});
        for (Index edge = 0; edge < complex.count(1); ++edge) {
            const float sharpness = strata.sharpness({1, edge});
            const auto faces = complex.relation(1, 2)[edge];
            if (!(sharpness > 0) ||
                std::ranges::none_of(faces, [&](Index face) { return isExtruded_[face] != 0; }))
                continue;
            const auto ends = complex.relation(1, 0)[edge];
            marks.edges.push_back({{numberOf(newNumber[ends[0]], options_.layers),
                                    numberOf(newNumber[ends[1]], options_.layers)},
                                   sharpness});
        }
    }

    /// Finds the faces that are extruded, their vertices, and the planes of open sides.
    void findFaces(const OpenFaces& open) {
        const far::CellComplex& complex = lattice_.complex;
        isExtruded_.assign(std::size_t(complex.count(2)), 0);
        for (Index face = 0; face < complex.count(2); ++face)
            isExtruded_[face] = complex.relation(2, 3)[face].size() == 1 && !open.isOpen[face];
        std::vector<Index> newNumber(lattice_.positions.size(), -1);
        for (Index face = 0; face < complex.count(2); ++face) {
            if (!isExtruded_[face]) continue;
            loops_.push_back(outwardLoop(face));
            for (Index& vertex : loops_.back()) {
                if (newNumber[vertex] < 0) {
                    newNumber[vertex] = static_cast<Index>(vertices_.size());
                    vertices_.push_back(vertex);
                    planes_.push_back(open.planesAt[vertex]);
                }
                vertex = newNumber[vertex];
            }
        }
        if (loops_.empty())
            throw Error("a collar: all boundary faces of the lattice are in open sides");
    }

    Loop outwardLoop(Index face) const {
        const Index cell = lattice_.complex.relation(2, 3)[face][0];
        const auto faces = lattice_.complex.relation(3, 2)[cell];
        const auto at = std::ranges::find(faces, face) - faces.begin();
        return far::outwardLoops(lattice_.complex, CellId(cell))[std::size_t(at)];
    }

    void requireManifold() const {
        const far::SurfaceFans fans(lattice_.complex, isExtruded_);
        for (Index edge = 0; edge < lattice_.complex.count(1); ++edge)
            if (fans.edge(edge) == far::SurfaceFans::EdgeKind::NonManifold)
                refuse(lattice_.complex.relation(1, 0)[edge][0]);
        for (const Index vertex : vertices_)
            if (fans.vertex(vertex) != far::SurfaceFans::VertexKind::Fan) refuse(vertex);
    }

    [[noreturn]] static void refuse(Index vertex) {
        throw Error(concat("a collar: cells of the lattice touch in vertex ", vertex,
                           " without sharing a face there, so that the vertex has no single "
                           "outer side; join the cells, or move them apart"));
    }

    /// Returns the mean distance between the boundary and the next layer of vertices.
    double meanThickness() const {
        double total = 0, count = 0;
        std::vector<char> isBoundary(lattice_.positions.size(), 0);
        for (const Index vertex : vertices_) isBoundary[vertex] = 1;
        const auto ends = [&](Index edge) { return lattice_.complex.relation(1, 0)[edge]; };
        for (Index edge = 0; edge < lattice_.complex.count(1); ++edge) {
            if (isBoundary[ends(edge)[0]] == isBoundary[ends(edge)[1]]) continue;
            total += length(
                difference(lattice_.positions[ends(edge)[0]], lattice_.positions[ends(edge)[1]]));
            ++count;
        }
        if (count > 0) return total / count;
        // No vertex is inside: take the edges of the boundary.
        for (std::size_t v = 0; v < vertices_.size(); ++v)
            for (const Index other : neighbours_[v]) {
                total += length(difference(position_[v], position_[other]));
                ++count;
            }
        return total / count;
    }

    /// Returns the step of each vertex that moves the faces around it by 1, if it can.
    std::vector<Point3> stepsFrom(std::span<const Point3> positions) const {
        constexpr double kLongest = 2;
        std::vector<Point3> normals(loops_.size());
        for (std::size_t face = 0; face < loops_.size(); ++face) {
            std::vector<Point3> corners;
            for (const Index vertex : loops_[face]) corners.push_back(positions[vertex]);
            const Point3 area = areaVector(corners);
            if (dot(area, area) > 0) normals[face] = normalised(area);
        }
        std::vector<Point3> steps(vertices_.size());
        for (std::size_t v = 0; v < vertices_.size(); ++v) {
            checkCancelledEvery(v, 10);
            std::vector<Point3> around;
            Point3 total = {};
            for (const std::size_t face : facesAt_[v]) {
                const Point3 normal = planes_[v].inPlanes(normals[face]);
                if (!(dot(normal, normal) > 1e-12)) continue;
                around.push_back(normalised(normal));
                total = sum(total, around.back());
            }
            if (around.empty() || !(dot(total, total) > 1e-12)) continue;
            const Point3 direction = middleOf(around, normalised(total));
            double least = 1;
            for (const Point3& normal : around) least = std::min(least, dot(normal, direction));
            steps[v] = scaled(direction, std::min(kLongest, 1 / std::max(least, 0.1)));
        }
        return steps;
    }

    /// Returns the reach of each vertex. Where parts of the lattice face each other, the vertices
    /// on both sides get less than half of the distance.
    std::vector<double> reaches(std::span<const double> parts) const {
        constexpr double kOpposite = -0.2;
        constexpr double kPart = 0.8;
        std::vector<Point3> normals;
        for (const Point3& step : stepsFrom(position_))
            normals.push_back(dot(step, step) > 0 ? normalised(step) : step);
        std::vector<double> reach(vertices_.size(), options_.reach);
        for (std::size_t v = 0; v < vertices_.size(); ++v) {
            checkCancelledEvery(v, 6);
            for (std::size_t w = 0; w < vertices_.size(); ++w) {
                if (dot(normals[v], normals[w]) >= kOpposite) continue;
                const Point3 way = difference(position_[w], position_[v]);
                const double ahead = dot(way, normals[v]);
                if (!(ahead > 0)) continue;
                // The radius of the ball that touches v and contains w on its sphere.
                reach[v] = std::min(reach[v], kPart * dot(way, way) / (2 * ahead));
            }
        }
        for (std::size_t v = 0; v < vertices_.size(); ++v)
            reach[v] *= parts[std::size_t(vertices_[v])];
        constexpr int kRounds = 10;
        for (int round = 0; round < kRounds; ++round) {
            const std::vector<double> before = reach;
            for (std::size_t v = 0; v < vertices_.size(); ++v) {
                double total = 0;
                for (const Index other : neighbours_[v]) total += before[other];
                const auto count = static_cast<double>(neighbours_[v].size());
                reach[v] = std::min(before[v], 0.5 * (before[v] + total / count));
            }
        }
        return reach;
    }

    const Lattice& lattice_;
    const CollarOptions& options_;
    std::vector<std::uint8_t> isExtruded_;  ///< per face of the lattice
    std::vector<Index> vertices_;           ///< of the extruded faces
    std::vector<PlaneNormals> planes_;      ///< CollarVertex::planes of each
    std::vector<Loop> loops_;               ///< the extruded faces, over vertices_
    std::vector<std::vector<Index>> neighbours_;
    std::vector<std::vector<std::size_t>> facesAt_;
    std::vector<Point3> position_;  ///< in the last layer so far
};

}  // namespace

OpenFaces openFacesAtEnds(const Lattice& lattice, const std::array<bool, 6>& open) {
    const far::CellComplex& complex = lattice.complex;
    OpenFaces result{std::vector<char>(std::size_t(complex.count(2)), 0),
                     std::vector<PlaneNormals>(lattice.positions.size())};
    for (std::size_t side = 0; side < 6; ++side) {
        if (!open[side]) continue;
        const Point3 direction = sideDirection(side);
        const auto isEnd = shapes::selectEnd(lattice.positions, direction);
        bool found = false;
        for (Index face = 0; face < complex.count(2); ++face) {
            const auto loop = complex.relation(2, 0)[face];
            if (complex.relation(2, 3)[face].size() != 1 ||
                !std::ranges::all_of(loop, [&](Index vertex) { return isEnd[vertex] > 0; }))
                continue;
            result.isOpen[face] = 1;
            found = true;
            for (const Index vertex : loop) result.planesAt[vertex].add(direction);
        }
        if (!found)
            throw Error(
                concat("a collar: the lattice has no boundary face whose vertices all are "
                       "at its end ",
                       kSideWords[side], ", so that this side cannot stay open"));
    }
    return result;
}

CollarCells extrudedCollar(const Lattice& lattice, const CollarOptions& options,
                           const OpenFaces& open, std::span<const double> parts) {
    return Extrusion(lattice, options, open).cells(parts);
}

}  // namespace espalier::cages

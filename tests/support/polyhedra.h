// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>
#include <espalier/far/standard_cells.h>
#include <espalier/far/topology_error.h>
#include <espalier/shapes/lattice.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "support/random_marks.h"
#include "support/zoo.h"

namespace espalier::test {

/// Builds random polyhedral lattices. Cells are loops of vertices, anticlockwise from outside.
class Polyhedra {
public:
    /// Starts with some cells of a grid of hexahedra, with vertices moved a little. A few cells are
    /// split into two wedges, or into pyramids and tetrahedra around a point inside; some faces are
    /// cut into two triangles.
    Polyhedra(const std::array<Index, 3>& n, Draws& draws) {
        for (const Point3& p : gridPositions(n)) {
            Point3 moved = p;
            for (double& x : moved) x += 0.15 * draws.fromMinusToOne();
            positions_.push_back(moved);
        }
        std::set<Face> cutFaces;
        const bool isWhole = draws.oneIn(3);
        for (Index k = 0; k < n[2]; ++k)
            for (Index j = 0; j < n[1]; ++j)
                for (Index i = 0; i < n[0]; ++i) {
                    const bool isLeftOut = draws.oneIn(4);
                    const bool isFirst = i + j + k == 0;
                    if (isLeftOut && !isWhole && !isFirst) continue;
                    addHexahedron(gridCell(n, i, j, k), draws, cutFaces);
                }
        for (Loops& loops : cells_) cut(loops, cutFaces);
        const std::vector<Loops> whole = std::exchange(cells_, {});
        for (const Loops& loops : whole)
            if (draws.oneIn(6))
                addStar(loops);
            else
                cells_.push_back(loops);
    }

    /// Merges pairs of neighbouring cells until `target` cells are left, or no pair has a union
    /// that is bounded by a sphere.
    void mergeCells(std::size_t target, Draws& draws) {
        for (bool hasMerged = true; hasMerged && cells_.size() > target;) {
            std::set<std::pair<std::size_t, std::size_t>> neighbours;
            for (const auto& [face, places] : facePlaces())
                if (places.size() == 2) neighbours.insert({places[0].first, places[1].first});
            std::vector<std::pair<std::size_t, std::size_t>> pairs(neighbours.begin(),
                                                                   neighbours.end());
            draws.shuffle(pairs);
            hasMerged = std::any_of(pairs.begin(), pairs.end(), [&](const auto& pair) {
                return mergePair(pair.first, pair.second);
            });
        }
    }

    /// Merges pairs of faces between the same cells that share exactly one edge.
    void mergeFaces(Draws& draws) {
        const auto places = facePlaces();
        std::map<std::pair<Index, Index>, std::vector<Face>> facesAt;
        for (const auto& [face, placesOfFace] : places) {
            const auto& loop = loopAt(placesOfFace[0]);
            for (std::size_t i = 0; i < loop.size(); ++i)
                facesAt[std::minmax(loop[i], loop[(i + 1) % loop.size()])].push_back(face);
        }
        std::vector<std::pair<Face, Face>> pairs;
        for (const auto& [edge, faces] : facesAt)
            if (faces.size() == 2 && cellsOf(places.at(faces[0])) == cellsOf(places.at(faces[1])))
                pairs.emplace_back(faces[0], faces[1]);
        if (pairs.empty()) return;
        const auto& [first, second] = pairs[draws.below(pairs.size())];
        Face common;
        std::set_intersection(first.begin(), first.end(), second.begin(), second.end(),
                              std::back_inserter(common));
        if (common.size() != 2) return;
        std::vector<Loops> merged = cells_;
        for (const std::size_t cell : cellsOf(places.at(first))) {
            joinLoops(merged[cell], first, second);
            if (!isSphere(merged[cell])) return;
        }
        cells_ = std::move(merged);
    }

    /// Returns the lattice, without unused vertices.
    Lattice lattice() const {
        std::vector<Index> names(positions_.size(), 0);
        for (const Loops& loops : cells_)
            for (const auto& loop : loops)
                for (const Index vertex : loop) names[vertex] = 1;
        std::vector<Point3> positions;
        for (std::size_t vertex = 0; vertex < names.size(); ++vertex)
            if (names[vertex] != 0) {
                names[vertex] = Index(positions.size());
                positions.push_back(positions_[vertex]);
            }
        std::vector<Loops> cells = cells_;
        for (Loops& loops : cells)
            for (auto& loop : loops)
                for (Index& vertex : loop) vertex = names[vertex];
        return {test::lattice(Index(positions.size()), cells), positions, {}, {}};
    }

private:
    using Face = std::vector<Index>;                    ///< its vertices, ascending
    using Place = std::pair<std::size_t, std::size_t>;  ///< a cell, and a loop of it
    using Places = std::map<Face, std::vector<Place>>;

    static Face faceOf(std::vector<Index> loop) {
        std::sort(loop.begin(), loop.end());
        return loop;
    }
    const std::vector<Index>& loopAt(const Place& place) const {
        return cells_[place.first][place.second];
    }
    Places facePlaces() const {
        Places places;
        for (std::size_t cell = 0; cell < cells_.size(); ++cell)
            for (std::size_t i = 0; i < cells_[cell].size(); ++i)
                places[faceOf(cells_[cell][i])].push_back({cell, i});
        return places;
    }
    static std::vector<std::size_t> cellsOf(const std::vector<Place>& places) {
        std::vector<std::size_t> cells;
        for (const Place& place : places) cells.push_back(place.first);
        return cells;
    }

    static Loops loopsOf(far::StandardCell kind, std::span<const Index> vertices) {
        Loops loops = far::faceLoops(kind);
        for (auto& loop : loops)
            for (Index& vertex : loop) vertex = vertices[vertex];
        return loops;
    }

    void addHexahedron(const std::array<Index, 8>& v, Draws& draws, std::set<Face>& cutFaces) {
        if (draws.oneIn(6)) {
            // Two wedges, one on each side of the plane through v[0], v[2], v[4] and v[6].
            for (const std::size_t at : {std::size_t{1}, std::size_t{2}})
                cells_.push_back(
                    loopsOf(far::StandardCell::Wedge,
                            std::array{v[0], v[at + 1], v[at], v[4], v[at + 5], v[at + 4]}));
            cutFaces.insert(faceOf({v[0], v[1], v[2], v[3]}));
            cutFaces.insert(faceOf({v[4], v[5], v[6], v[7]}));
        } else {
            cells_.push_back(loopsOf(far::StandardCell::Hexahedron, v));
            for (const auto& loop : cells_.back())
                if (draws.oneIn(24)) cutFaces.insert(faceOf(loop));
        }
    }

    /// Adds a pyramid on each face, with a common apex inside.
    void addStar(const Loops& loops) {
        std::set<Index> vertices;
        for (const auto& loop : loops) vertices.insert(loop.begin(), loop.end());
        Point3 middle = {0, 0, 0};
        for (const Index vertex : vertices)
            for (std::size_t c = 0; c < 3; ++c)
                middle[c] += positions_[vertex][c] / double(vertices.size());
        const auto apex = Index(positions_.size());
        positions_.push_back(middle);
        for (const auto& loop : loops) {
            Loops pyramid = {loop};
            for (std::size_t i = 0; i < loop.size(); ++i)
                pyramid.push_back({loop[(i + 1) % loop.size()], loop[i], apex});
            cells_.push_back(std::move(pyramid));
        }
    }

    /// Cuts quadrilaterals into two triangles, from their smallest vertex, so that both cells of a
    /// face cut it in the same way.
    static void cut(Loops& loops, const std::set<Face>& cutFaces) {
        Loops result;
        for (auto& loop : loops) {
            if (loop.size() != 4 || cutFaces.count(faceOf(loop)) == 0) {
                result.push_back(loop);
                continue;
            }
            std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
            result.push_back({loop[0], loop[1], loop[2]});
            result.push_back({loop[0], loop[2], loop[3]});
        }
        loops = std::move(result);
    }

    /// Returns true if the library accepts the loops as a cell.
    static bool isSphere(const Loops& loops) {
        std::map<Index, Index> names;
        Loops renamed = loops;
        for (auto& loop : renamed)
            for (Index& vertex : loop)
                vertex = names.emplace(vertex, Index(names.size())).first->second;
        try {
            test::lattice(Index(names.size()), {renamed});
            return true;
        } catch (const far::TopologyError&) {
            return false;
        }
    }

    bool mergePair(std::size_t first, std::size_t second) {
        std::map<Face, int> count;
        for (const std::size_t cell : {first, second})
            for (const auto& loop : cells_[cell]) ++count[faceOf(loop)];
        Loops merged;
        for (const std::size_t cell : {first, second})
            for (const auto& loop : cells_[cell])
                if (count[faceOf(loop)] == 1) merged.push_back(loop);
        if (!isSphere(merged)) return false;
        cells_[first] = std::move(merged);
        cells_.erase(cells_.begin() + std::ptrdiff_t(second));
        return true;
    }

    /// Replaces the loops of two faces that share one edge by the loop around both.
    static void joinLoops(Loops& loops, const Face& first, const Face& second) {
        const auto find = [&](const Face& face) {
            return std::find_if(loops.begin(), loops.end(),
                                [&](const auto& loop) { return faceOf(loop) == face; });
        };
        std::vector<Index> a = *find(first), b = *find(second);
        // Rotates both loops until the edge joins the last vertex of each to its first.
        while (!far::contains(b, a.front()) || !far::contains(b, a.back()))
            std::rotate(a.begin(), a.begin() + 1, a.end());
        while (b.front() != a.back()) std::rotate(b.begin(), b.begin() + 1, b.end());
        a.insert(a.end(), b.begin() + 1, b.end() - 1);
        *find(first) = std::move(a);
        loops.erase(find(second));
    }

    std::vector<Point3> positions_;
    std::vector<Loops> cells_;
};

}  // namespace espalier::test

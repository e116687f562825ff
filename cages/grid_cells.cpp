// SPDX-License-Identifier: Apache-2.0
#include "grid_cells.h"

#include <espalier/base/disjoint_sets.h>
#include <espalier/base/progress.h>
#include <espalier/far/complex_builder.h>

#include <algorithm>
#include <array>
#include <map>
#include <utility>

namespace espalier::cages {
namespace {

/// A part is left out to resolve a conflict if the model reaches less than this into it, in edges.
constexpr double kConflictReach = 0.6;

}  // namespace

GridCells::GridCells(const ModelVoxels& voxels, const GridCellOptions& options)
    : parts_(voxels, options.voxelsPerEdge, options.offset, options.joinDistance,
             options.mirrorAxes) {
    constexpr int kMaxRepairs = 100;
    for (int round = 0; round < kMaxRepairs && !isManifold_; ++round) {
        do leaveOut(options.reach);
        while (joinConflicts(kConflictReach * options.voxelsPerEdge));
        isManifold_ = !repair();
    }
    numberVertices();
}

/// Leaves out parts with a small depth, the least depth first.
void GridCells::leaveOut(double reach) {
    for (;;) {
        std::vector<std::pair<double, Index>> candidates;
        for (Index part = 0; part < parts_.count(); ++part) {
            checkCancelledEvery(part, 6);
            if (!parts_.isRemovable(part)) continue;
            if (double depth = 0; parts_.isShallow(part, reach, depth))
                candidates.emplace_back(depth, part);
        }
        if (candidates.empty()) return;
        std::sort(candidates.begin(), candidates.end());
        bool isChanged = false;
        for (const auto& [depth, part] : candidates)
            if (parts_.leaveOut(part, reach)) isChanged = true;
        if (!isChanged) return;
    }
}

/// Resolves faces with several parts behind them. Returns true if there were any.
/// \param reach a part may be left out if it is at most this deep, in voxels
bool GridCells::joinConflicts(double reach) {
    bool isChanged = false;
    for (Index part = 0; part < parts_.count(); ++part)
        for (Index direction = 0; direction < CubeParts::kDirections; ++direction)
            while (parts_[part].isUsed && parts_.hasSeveral(part, direction)) {
                resolveConflict(part, direction, reach);
                isChanged = true;
            }
    return isChanged;
}

/// Leaves out one of the parts behind a face, or joins two of them.
void GridCells::resolveConflict(Index number, Index direction, double reach) {
    std::vector<std::pair<Index, Index>> behind;  // count, part
    for (const CubeParts::Contact& contact : parts_[number].contacts)
        if (contact.direction == direction) behind.emplace_back(contact.count, contact.to);
    // The smallest first.
    std::sort(behind.begin(), behind.end());
    for (const auto& [count, part] : behind)
        if (parts_.leaveOut(part, reach)) return;
    parts_.join(behind.back().second, behind.front().second, parts_[number].joins + 1);
}

/// Numbers the cells and the vertices by layers.
void GridCells::numberVertices() {
    const std::size_t count = parts_.count();
    DisjointSets sets(count * 8);
    for (std::size_t p = 0; p < count; ++p)
        for (const CubeParts::Contact& contact : parts_.all()[p].contacts) {
            if (contact.to < static_cast<Index>(p)) continue;
            for (unsigned corner = 0; corner < 8; ++corner)
                if (isOnFace(corner, contact.direction))
                    sets.join(p * 8 + corner,
                              Offset{contact.to} * 8 + (corner ^ (1u << (contact.direction / 2))));
        }
    // Added parts come last, but take their places in the layers.
    order_.clear();
    for (Index part = 0; part < parts_.count(); ++part)
        if (parts_[part].isUsed) order_.push_back(part);
    std::stable_sort(order_.begin(), order_.end(), [&](Index a, Index b) {
        return parts_.numberOf(parts_[a].cube) < parts_.numberOf(parts_[b].cube);
    });
    std::vector<std::optional<Index>> numbers(count * 8);
    corners_.assign(count, {});
    cellOfPart_.assign(count, std::nullopt);
    vertexCount_ = cellCount_ = 0;
    for (const Index part : order_) {
        const std::size_t p = part;
        cellOfPart_[p] = cellCount_++;
        for (unsigned corner = 0; corner < 8; ++corner) {
            auto& number = numbers[sets.rootOf(p * 8 + corner)];
            if (!number) number = vertexCount_++;
            corners_[p][corner] = *number;
        }
    }
}

/// Finds places where the boundary is not a manifold, and adds parts or joins parts there. Returns
/// true if there are any.
bool GridCells::repair() {
    return closeDoubleFaces() || repairVertices();
}

/// Puts two free faces with the same vertices in contact. Returns true, before the end, if two
/// parts were joined instead.
bool GridCells::closeDoubleFaces() {
    struct Face {
        std::array<Index, 4> key;
        Index part, direction;
        auto operator<=>(const Face&) const = default;
    };
    std::vector<Face> faces;
    for (bool isChanged = true; isChanged;) {
        numberVertices();
        faces.clear();
        for (Index part = 0; part < parts_.count(); ++part) {
            if (!parts_[part].isUsed) continue;
            const unsigned shared = parts_.sharedFaces(part);
            for (Index d = 0; d < CubeParts::kDirections; ++d) {
                if ((shared >> d & 1) != 0) continue;
                Face face{{}, part, d};
                int count = 0;
                for (unsigned corner = 0; corner < 8; ++corner)
                    if (isOnFace(corner, d)) face.key[count++] = corners_[part][corner];
                std::sort(face.key.begin(), face.key.end());
                faces.push_back(face);
            }
        }
        std::sort(faces.begin(), faces.end());
        isChanged = false;
        for (std::size_t i = 0; i + 1 < faces.size(); ++i) {
            const Face &a = faces[i], &b = faces[i + 1];
            if (a.key != b.key) continue;
            if (parts_[a.part].cube == parts_[b.part].cube) {
                parts_.join(a.part, b.part, 1);
                return true;
            }
            parts_.addContact(a.part, {b.part, a.direction, 0});
            isChanged = true;
            ++i;
        }
    }
    return false;
}

/// Adds parts around vertices where the boundary is not a manifold, and closes slits. Returns true
/// if there are any.
bool GridCells::repairVertices() {
    // Around each vertex, the free faces must form one fan: each edge has two of them.
    struct Corner {
        Index vertex, part, corner;
        auto operator<=>(const Corner&) const = default;
    };
    std::vector<Corner> corners;
    for (Index part = 0; part < parts_.count(); ++part)
        if (parts_[part].isUsed)
            for (Index corner = 0; corner < 8; ++corner)
                corners.push_back({corners_[part][corner], part, corner});
    std::sort(corners.begin(), corners.end());
    std::map<Index, std::vector<std::size_t>> facesOfEdge;  // by the other end
    std::vector<std::pair<Index, Index>> free;              // part, direction
    std::vector<Index> members;                             // parts at the vertex
    std::vector<char> isTouched(parts_.count(), 0);
    bool isBad = false;
    for (std::size_t first = 0, last = 0; first < corners.size(); first = last) {
        while (last < corners.size() && corners[last].vertex == corners[first].vertex) ++last;
        facesOfEdge.clear();
        members.clear();
        free.clear();
        for (std::size_t i = first; i < last; ++i) {
            const auto [vertex, part, corner] = corners[i];
            members.push_back(part);
            const unsigned shared = parts_.sharedFaces(part);
            for (Index axis = 0; axis < 3; ++axis) {
                const Index d = 2 * axis + (corner >> axis & 1);
                if ((shared >> d & 1) != 0) continue;
                for (Index other = 0; other < 3; ++other)
                    if (other != axis)
                        facesOfEdge[corners_[part][corner ^ (1 << other)]].push_back(free.size());
                free.emplace_back(part, d);
            }
        }
        const std::size_t faceCount = free.size();
        if (faceCount == 2 && facesOfEdge.size() == 2) {
            // Two faces with two common edges at the vertex: the end of a slit. Closes it.
            const auto [a, directionA] = free[0];
            const auto [b, directionB] = free[1];
            if (parts_[a].cube == parts_[b].cube)
                parts_.join(std::min(a, b), std::max(a, b), 1);
            else if (directionA == opposite(directionB))
                parts_.addContact(a, {b, directionA, 0});
            else
                continue;
            return true;
        }
        DisjointSets fans(faceCount);
        bool isManifold = true;
        for (const auto& [end, list] : facesOfEdge) {
            if (list.size() != 2) isManifold = false;
            for (const std::size_t face : list) fans.join(face, list[0]);
        }
        if (isManifold && (faceCount == 0 || fans.setCount() == 1)) continue;
        isBad = true;
        // Parts at a vertex beside an added part wait for the next round.
        if (std::any_of(members.begin(), members.end(),
                        [&](Index part) { return isTouched[part] != 0; }))
            continue;
        for (const Index part : members)
            for (const Index image : parts_.orbitOf(part)) isTouched[image] = 1;
        const auto [vertex, part, corner] = corners[first];
        CubeParts::Cube low = parts_[part].cube;
        for (int axis = 0; axis < 3; ++axis) low[axis] += (corner >> axis & 1) - 1;
        parts_.add(low, members);
    }
    return isBad;
}

Lattice GridCells::build() const {
    Lattice lattice;
    lattice.positions.resize(vertexCount_);
    far::ComplexBuilder builder(3, vertexCount_);
    constexpr std::array<unsigned, 8> kHexahedron = {0, 1, 3, 2, 4, 5, 7, 6};
    for (const Index p : order_) {
        std::array<Index, 8> vertices;
        for (std::size_t i = 0; i < 8; ++i) vertices[i] = corners_[p][kHexahedron[i]];
        builder.addCell(far::StandardCell::Hexahedron, vertices);
        for (unsigned corner = 0; corner < 8; ++corner) {
            CubeParts::Cube cube = parts_[p].cube;
            for (int axis = 0; axis < 3; ++axis)
                cube[axis] += static_cast<Index>(corner >> axis & 1);
            lattice.positions[corners_[p][corner]] = parts_.cornerOf(cube);
        }
    }
    lattice.complex = builder.build();
    return lattice;
}

std::vector<Index> GridCells::vertexImages(int axis) const {
    std::vector<Index> images(vertexCount_);
    for (const Index part : order_) {
        const auto& ofImage = corners_[parts_.imageOf(part, axis)];
        for (unsigned corner = 0; corner < 8; ++corner)
            images[corners_[part][corner]] = ofImage[corner ^ 1u << axis];
    }
    return images;
}

std::optional<Index> GridCells::cellOf(const Point3& point) const {
    const auto part = parts_.partAt(point);
    return part ? cellOfPart_[*part] : std::nullopt;
}

}  // namespace espalier::cages

// SPDX-License-Identifier: Apache-2.0
#include "grid_cells.h"

#include <espalier/base/disjoint_sets.h>
#include <espalier/base/sort_unique.h>
#include <espalier/far/complex_builder.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <utility>

namespace espalier::cages {
namespace {

/// A part is left out to resolve a conflict if the model reaches less than this into it, in edges.
constexpr double kConflictReach = 0.6;

constexpr Index kDirections = 6;  ///< axis · 2 + 1 for the higher side

Index opposite(Index direction) {
    return direction ^ 1;
}

/// Bit i of a corner is set on the higher side of axis i.
bool isOnFace(unsigned corner, Index direction) {
    return (corner >> (direction / 2) & 1) == static_cast<unsigned>(direction & 1);
}

/// Returns true if some faces of a cube are connected over edges.
bool areConnected(unsigned faces) {
    unsigned reached = faces & (~faces + 1);
    for (int round = 0; round < 3; ++round)
        for (Index d = 0; d < kDirections; ++d)
            if ((reached >> d & 1) != 0) reached |= faces & ~(3u << (d / 2 * 2));
    return reached == faces;
}

/// Returns true if some faces of a cube form a disk.
bool isDisk(unsigned faces) {
    return faces != 0 && faces != 63 && areConnected(faces) && areConnected(63 & ~faces);
}

}  // namespace

GridCells::GridCells(const ModelVoxels& voxels, const GridCellOptions& options)
    : voxels_(voxels), options_(options) {
    for (int axis = 0; axis < 3; ++axis) {
        // A layer of cubes on both sides.
        options_.offset[axis] += options_.voxelsPerEdge;
        counts_[axis] =
            (voxels.grid().counts[axis] + options_.offset[axis]) / options_.voxelsPerEdge + 2;
    }
    findParts();
    findContacts();
    constexpr int kMaxRepairs = 100;
    for (int round = 0; round < kMaxRepairs && !isManifold_; ++round) {
        do leaveOut(options_.reach);
        while (joinConflicts());
        isManifold_ = !repair();
    }
    countVertices();
}

void GridCells::findParts() {
    const auto& n = voxels_.grid().counts;
    const auto isUsed = voxels_.isUsed();
    const Index k = options_.voxelsPerEdge;
    parts_.clear();
    partOf_.assign(isUsed.size(), -1);
    std::vector<Index> front;
    Cube cube;
    for (cube[2] = 0; cube[2] < counts_[2]; ++cube[2])
        for (cube[1] = 0; cube[1] < counts_[1]; ++cube[1])
            for (cube[0] = 0; cube[0] < counts_[0]; ++cube[0]) {
                std::array<Index, 3> low, high;
                for (int axis = 0; axis < 3; ++axis) {
                    low[axis] = std::max(cube[axis] * k - options_.offset[axis], 0);
                    high[axis] = std::min((cube[axis] + 1) * k - options_.offset[axis], n[axis]);
                }
                const std::size_t first = parts_.size();
                for (Index z = low[2]; z < high[2]; ++z)
                    for (Index y = low[1]; y < high[1]; ++y)
                        for (Index x = low[0]; x < high[0]; ++x) {
                            const Index voxel = (z * n[1] + y) * n[0] + x;
                            if (isUsed[voxel] == 0 || partOf_[voxel] >= 0) continue;
                            const auto part = static_cast<Index>(parts_.size());
                            parts_.emplace_back();
                            parts_.back().cube = cube;
                            auto& members = parts_.back().voxels;
                            partOf_[voxel] = part;
                            members.push_back(voxel);
                            for (std::size_t i = 0; i < members.size(); ++i) {
                                const Index at = members[i];
                                const std::array<Index, 3> place = {at % n[0], at / n[0] % n[1],
                                                                    at / n[0] / n[1]};
                                Index stride = 1;
                                for (int axis = 0; axis < 3; stride *= n[axis], ++axis)
                                    for (const Index side : {-1, 1}) {
                                        const Index next = place[axis] + side;
                                        if (next < low[axis] || next >= high[axis]) continue;
                                        const Index other = at + side * stride;
                                        if (isUsed[other] == 0 || partOf_[other] >= 0) continue;
                                        partOf_[other] = part;
                                        members.push_back(other);
                                    }
                            }
                        }
                // Parts that are near to each other are one part.
                for (std::size_t a = first; a < parts_.size(); ++a)
                    for (std::size_t b = a + 1; b < parts_.size();) {
                        if (!areNear(parts_[a], parts_[b])) {
                            ++b;
                            continue;
                        }
                        auto& members = parts_[a].voxels;
                        members.insert(members.end(), parts_[b].voxels.begin(),
                                       parts_[b].voxels.end());
                        parts_.erase(parts_.begin() + static_cast<std::ptrdiff_t>(b));
                        b = a + 1;
                    }
                for (std::size_t a = first; a < parts_.size(); ++a)
                    for (const Index voxel : parts_[a].voxels)
                        partOf_[voxel] = static_cast<Index>(a);
            }
}

Index GridCells::numberOf(const Cube& cube) const {
    return (cube[2] * counts_[1] + cube[1]) * counts_[0] + cube[0];
}

std::array<Index, 3> GridCells::placeOf(Index voxel) const {
    const auto& n = voxels_.grid().counts;
    return {voxel % n[0], voxel / n[0] % n[1], voxel / n[0] / n[1]};
}

/// Returns true if a voxel of one part is at most the join distance from a voxel of another part.
bool GridCells::areNear(const Part& a, const Part& b) const {
    const double distance = options_.joinDistance;
    // Voxels with a common face are in one part, or in contact.
    if (distance <= 1) return false;
    // First the boxes around the two.
    std::array<std::array<Index, 3>, 2> low, high;
    for (const int side : {0, 1}) {
        low[side].fill(kMaxIndex);
        high[side].fill(-1);
        for (const Index voxel : side == 0 ? a.voxels : b.voxels) {
            const auto place = placeOf(voxel);
            for (int axis = 0; axis < 3; ++axis) {
                low[side][axis] = std::min(low[side][axis], place[axis]);
                high[side][axis] = std::max(high[side][axis], place[axis]);
            }
        }
    }
    const auto away = [](const std::array<Index, 3>& way) {
        return way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
    };
    std::array<Index, 3> way;
    for (int axis = 0; axis < 3; ++axis)
        way[axis] = std::max({low[0][axis] - high[1][axis], low[1][axis] - high[0][axis], 0});
    if (away(way) > distance * distance) return false;
    for (const Index p : a.voxels) {
        const auto place = placeOf(p);
        for (int axis = 0; axis < 3; ++axis)
            way[axis] = std::max({low[1][axis] - place[axis], place[axis] - high[1][axis], 0});
        if (away(way) > distance * distance) continue;
        for (const Index q : b.voxels) {
            const auto other = placeOf(q);
            for (int axis = 0; axis < 3; ++axis) way[axis] = place[axis] - other[axis];
            if (away(way) <= distance * distance) return true;
        }
    }
    return false;
}

void GridCells::findContacts() {
    const auto& n = voxels_.grid().counts;
    for (std::size_t p = 0; p < parts_.size(); ++p) {
        Part& part = parts_[p];
        for (const Index voxel : part.voxels) {
            const std::array<Index, 3> place = {voxel % n[0], voxel / n[0] % n[1],
                                                voxel / n[0] / n[1]};
            Index stride = 1;
            for (int axis = 0; axis < 3; stride *= n[axis], ++axis)
                for (const Index side : {0, 1}) {
                    const Index next = place[axis] + 2 * side - 1;
                    if (next < 0 || next >= n[axis]) continue;
                    const Index other = partOf_[voxel + (2 * side - 1) * stride];
                    if (other < 0 || other == static_cast<Index>(p)) continue;
                    if (parts_[other].cube == part.cube) continue;
                    const Index direction = 2 * axis + side;
                    auto found = std::find_if(
                        part.contacts.begin(), part.contacts.end(), [&](const Contact& contact) {
                            return contact.to == other && contact.direction == direction;
                        });
                    if (found == part.contacts.end())
                        found = part.contacts.insert(found, {other, direction});
                    ++found->count;
                }
        }
    }
    // So do parts in neighbouring cubes that are near to each other.
    const Index cubeCount = counts_[0] * counts_[1] * counts_[2];
    std::vector<Index> firstPart(cubeCount + 1, static_cast<Index>(parts_.size()));
    for (std::size_t p = parts_.size(); p-- > 0;)
        firstPart[numberOf(parts_[p].cube)] = static_cast<Index>(p);
    for (Index cube = cubeCount; cube-- > 0;)
        firstPart[cube] = std::min(firstPart[cube], firstPart[cube + 1]);
    for (std::size_t p = 0; p < parts_.size(); ++p)
        for (Index axis = 0; axis < 3; ++axis) {
            Cube cube = parts_[p].cube;
            ++cube[axis];
            const Index number = numberOf(cube);
            for (Index q = firstPart[number]; q < firstPart[number + 1]; ++q) {
                const auto isThis = [&](const Contact& contact) { return contact.to == q; };
                if (std::any_of(parts_[p].contacts.begin(), parts_[p].contacts.end(), isThis) ||
                    !areNear(parts_[p], parts_[q]))
                    continue;
                parts_[p].contacts.push_back({q, 2 * axis + 1});
                parts_[q].contacts.push_back({static_cast<Index>(p), 2 * axis});
            }
        }
}

/// Returns the part behind a face; −1 if there is none, −2 if there are several.
Index GridCells::neighbour(Index part, Index direction) const {
    Index found = -1;
    for (const Contact& contact : parts_[part].contacts) {
        if (contact.direction != direction) continue;
        if (found >= 0) return -2;
        found = contact.to;
    }
    return found;
}

/// Returns the faces with a part behind them, as bits.
int GridCells::sharedFaces(Index part) const {
    int faces = 0;
    for (const Contact& contact : parts_[part].contacts) faces |= 1 << contact.direction;
    return faces;
}

/// Returns true if the parts around an edge of a part form a ring. The edge is between two faces
/// with parts behind them.
bool GridCells::isClosedAround(Index part, Index first, Index second) const {
    const Index a = neighbour(part, first), b = neighbour(part, second);
    if (a < 0 || b < 0) return false;
    const Index across = neighbour(a, second);
    return across >= 0 && neighbour(b, first) == across;
}

/// Returns true if the topology stays the same without a part.
bool GridCells::isRemovable(Index number) const {
    const Part& part = parts_[number];
    if (part.isAdded || !part.isUsed) return false;
    const auto faces = static_cast<unsigned>(sharedFaces(number));
    if (!isDisk(faces)) return false;
    for (Index d = 0; d < kDirections; ++d) {
        if ((faces >> d & 1) == 0) continue;
        if (neighbour(number, d) < 0) return false;
        for (Index e = d + 1; e < kDirections; ++e)
            if ((faces >> e & 1) != 0 && d / 2 != e / 2 && !isClosedAround(number, d, e))
                return false;
    }
    return true;
}

/// Returns the distance of the centre of a voxel from a face of a cube, in voxels.
double GridCells::distanceToFace(const Cube& cube, Index direction, Index voxel) const {
    const auto& n = voxels_.grid().counts;
    const std::array<Index, 3> place = {voxel % n[0], voxel / n[0] % n[1], voxel / n[0] / n[1]};
    double square = 0;
    for (Index axis = 0; axis < 3; ++axis) {
        const Index low = cube[axis] * options_.voxelsPerEdge - options_.offset[axis];
        const double at = place[axis] + 0.5 - low, high = options_.voxelsPerEdge;
        double way;
        if (axis == direction / 2)
            way = at - ((direction & 1) != 0 ? high : 0);
        else
            way = at - std::clamp(at, 0.0, high);
        square += way * way;
    }
    return std::sqrt(square);
}

/// Returns how far the voxels of a part are from its shared faces, in voxels.
double GridCells::depthOf(Index number) const {
    const Part& part = parts_[number];
    const int faces = sharedFaces(number);
    double depth = 0;
    for (const Index voxel : part.voxels) {
        double least = 1e9;
        for (Index d = 0; d < kDirections; ++d)
            if ((faces >> d & 1) != 0) least = std::min(least, distanceToFace(part.cube, d, voxel));
        depth = std::max(depth, least + 0.5);
        if (depth > options_.voxelsPerEdge) break;
    }
    return depth;
}

/// Leaves out a part. Its voxels go to the neighbours.
void GridCells::leaveOutPart(Index number) {
    Part& part = parts_[number];
    std::array<Index, kDirections> behind;
    for (Index d = 0; d < kDirections; ++d) behind[d] = neighbour(number, d);
    for (const Index voxel : part.voxels) {
        Index best = -1;
        double least = 0;
        for (Index d = 0; d < kDirections; ++d) {
            if (behind[d] < 0) continue;
            const double distance = distanceToFace(part.cube, d, voxel);
            if (best >= 0 && distance >= least) continue;
            best = behind[d];
            least = distance;
        }
        parts_[best].voxels.push_back(voxel);
        partOf_[voxel] = best;
    }
    for (const Contact& contact : part.contacts)
        std::erase_if(parts_[contact.to].contacts,
                      [&](const Contact& back) { return back.to == number; });
    part.contacts.clear();
    part.voxels.clear();
    part.isUsed = false;
}

/// Leaves out parts with a small depth, the least depth first.
void GridCells::leaveOut(double reach) {
    for (;;) {
        std::vector<std::pair<double, Index>> candidates;
        for (std::size_t p = 0; p < parts_.size(); ++p) {
            const auto part = static_cast<Index>(p);
            if (!isRemovable(part)) continue;
            const double depth = depthOf(part);
            if (depth <= reach) candidates.emplace_back(depth, part);
        }
        if (candidates.empty()) return;
        std::sort(candidates.begin(), candidates.end());
        bool isChanged = false;
        for (const auto& [depth, part] : candidates) {
            if (!isRemovable(part) || depthOf(part) > reach) continue;
            leaveOutPart(part);
            isChanged = true;
        }
        if (!isChanged) return;
    }
}

/// Joins a part to another one in the same cube.
void GridCells::joinParts(Index kept, Index other, int joins) {
    Part &a = parts_[kept], &b = parts_[other];
    a.joins = std::max({a.joins, b.joins, joins});
    if (a.joins > 1 && !joined_) {
        joined_.emplace();
        for (int axis = 0; axis < 3; ++axis)
            (*joined_)[axis] =
                voxels_.grid().origin[axis] +
                ((a.cube[axis] + 0.5) * options_.voxelsPerEdge - options_.offset[axis]) *
                    voxels_.grid().size;
    }
    for (const Index voxel : b.voxels) partOf_[voxel] = kept;
    a.voxels.insert(a.voxels.end(), b.voxels.begin(), b.voxels.end());
    a.isAdded = a.isAdded || b.isAdded;
    for (const Contact& contact : b.contacts) {
        auto& backs = parts_[contact.to].contacts;
        std::erase_if(backs, [&](const Contact& back) { return back.to == other; });
        addContact(kept, contact);
    }
    b.contacts.clear();
    b.voxels.clear();
    b.isUsed = false;
}

/// Adds a contact, on both sides, to what the two parts share already.
void GridCells::addContact(Index part, const Contact& contact) {
    const auto add = [](std::vector<Contact>& contacts, const Contact& more) {
        for (Contact& old : contacts) {
            if (old.to != more.to || old.direction != more.direction) continue;
            old.count += more.count;
            return;
        }
        contacts.push_back(more);
    };
    add(parts_[part].contacts, contact);
    Contact back = contact;
    back.to = part;
    back.direction = opposite(contact.direction);
    add(parts_[contact.to].contacts, back);
}

/// Resolves faces with several parts behind them. Returns true if there were any.
bool GridCells::joinConflicts() {
    bool isChanged = false;
    for (std::size_t p = 0; p < parts_.size(); ++p) {
        const auto number = static_cast<Index>(p);
        if (!parts_[p].isUsed) continue;
        for (Index direction = 0; direction < kDirections; ++direction) {
            while (parts_[p].isUsed && neighbour(number, direction) == -2) {
                resolveConflict(number, direction);
                isChanged = true;
            }
        }
    }
    return isChanged;
}

/// Leaves out one of the parts behind a face, or joins two of them.
void GridCells::resolveConflict(Index number, Index direction) {
    std::vector<std::pair<Index, Index>> behind;  // count, part
    for (const Contact& contact : parts_[number].contacts)
        if (contact.direction == direction) behind.emplace_back(contact.count, contact.to);
    // The smallest first.
    std::sort(behind.begin(), behind.end());
    const double reach = kConflictReach * options_.voxelsPerEdge;
    for (const auto& [count, part] : behind)
        if (isRemovable(part) && depthOf(part) <= reach) return leaveOutPart(part);
    joinParts(behind.back().second, behind.front().second, parts_[number].joins + 1);
}

void GridCells::countVertices() {
    DisjointSets sets(parts_.size() * 8);
    for (std::size_t p = 0; p < parts_.size(); ++p)
        for (const Contact& contact : parts_[p].contacts) {
            if (contact.to < static_cast<Index>(p)) continue;
            for (unsigned corner = 0; corner < 8; ++corner)
                if (isOnFace(corner, contact.direction))
                    sets.join(p * 8 + corner, static_cast<std::size_t>(contact.to) * 8 +
                                                  (corner ^ (1u << (contact.direction / 2))));
        }
    std::vector<Index> numbers(parts_.size() * 8, -1);
    corners_.assign(parts_.size(), {});
    cellOfPart_.assign(parts_.size(), -1);
    vertexCount_ = cellCount_ = 0;
    // Added parts come last in parts_, but take their places in the layers.
    order_.clear();
    for (std::size_t p = 0; p < parts_.size(); ++p)
        if (parts_[p].isUsed) order_.push_back(static_cast<Index>(p));
    std::stable_sort(order_.begin(), order_.end(), [&](Index a, Index b) {
        return numberOf(parts_[a].cube) < numberOf(parts_[b].cube);
    });
    for (const Index part : order_) {
        const auto p = static_cast<std::size_t>(part);
        cellOfPart_[p] = cellCount_++;
        for (unsigned corner = 0; corner < 8; ++corner) {
            Index& number = numbers[sets.rootOf(p * 8 + corner)];
            if (number < 0) number = vertexCount_++;
            corners_[p][corner] = number;
        }
    }
}

/// Finds edges and vertices where the boundary is not a manifold, and adds parts or joins parts
/// there. Returns true if there are any.
bool GridCells::repair() {
    struct Face {
        std::array<Index, 4> key;
        Index part, direction;
        auto operator<=>(const Face&) const = default;
    };
    std::vector<Face> faces;
    for (;;) {
        countVertices();
        faces.clear();
        for (std::size_t p = 0; p < parts_.size(); ++p) {
            if (!parts_[p].isUsed) continue;
            const int shared = sharedFaces(static_cast<Index>(p));
            for (Index d = 0; d < kDirections; ++d) {
                if ((shared >> d & 1) != 0) continue;
                Face face{{}, static_cast<Index>(p), d};
                int count = 0;
                for (unsigned corner = 0; corner < 8; ++corner)
                    if (isOnFace(corner, d)) face.key[count++] = corners_[p][corner];
                std::sort(face.key.begin(), face.key.end());
                faces.push_back(face);
            }
        }
        std::sort(faces.begin(), faces.end());
        // Two free faces with the same vertices are one face.
        bool isChanged = false;
        for (std::size_t i = 0; i + 1 < faces.size(); ++i) {
            const Face &a = faces[i], &b = faces[i + 1];
            if (a.key != b.key) continue;
            if (parts_[a.part].cube == parts_[b.part].cube) {
                joinParts(a.part, b.part, 1);
                return true;
            }
            addContact(a.part, {b.part, a.direction, 0});
            isChanged = true;
            ++i;
        }
        if (!isChanged) break;
    }
    // Around each vertex, the free faces must form one fan: each edge has two of them.
    struct Corner {
        Index vertex, part, corner;
        auto operator<=>(const Corner&) const = default;
    };
    std::vector<Corner> corners;
    for (std::size_t p = 0; p < parts_.size(); ++p)
        if (parts_[p].isUsed)
            for (Index corner = 0; corner < 8; ++corner)
                corners.push_back({corners_[p][corner], static_cast<Index>(p), corner});
    std::sort(corners.begin(), corners.end());
    std::map<Index, std::vector<std::size_t>> facesOfEdge;  // by the other end
    std::vector<std::pair<Index, Index>> free;              // part, direction
    std::vector<Index> members;                             // parts at the vertex
    std::vector<char> isTouched(parts_.size(), 0);
    bool isBad = false;
    for (std::size_t first = 0, last = 0; first < corners.size(); first = last) {
        while (last < corners.size() && corners[last].vertex == corners[first].vertex) ++last;
        facesOfEdge.clear();
        members.clear();
        free.clear();
        for (std::size_t i = first; i < last; ++i) {
            const auto [vertex, part, corner] = corners[i];
            members.push_back(part);
            const int shared = sharedFaces(part);
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
                joinParts(std::min(a, b), std::max(a, b), 1);
            else if (directionA == opposite(directionB))
                addContact(a, {b, directionA, 0});
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
        for (const Index part : members) isTouched[part] = 1;
        const auto [vertex, part, corner] = corners[first];
        Cube low = parts_[part].cube;
        for (int axis = 0; axis < 3; ++axis) low[axis] += (corner >> axis & 1) - 1;
        addPart(low, members);
    }
    return isBad;
}

/// Adds a part in one of the eight cubes from `low` on, beside the parts around a vertex.
void GridCells::addPart(const Cube& low, std::span<const Index> members) {
    // The one with the most neighbours.
    Part added;
    added.isAdded = true;
    std::vector<Contact> contacts;
    for (unsigned octant = 0; octant < 8; ++octant) {
        Cube cube = low;
        for (int axis = 0; axis < 3; ++axis) cube[axis] += static_cast<Index>(octant >> axis & 1);
        contacts.clear();
        bool isFree = true;
        for (const Index member : members) {
            const Cube& other = parts_[member].cube;
            isFree = isFree && other != cube;
            for (Index direction = 0; direction < kDirections; ++direction) {
                Cube next = cube;
                next[direction / 2] += 2 * (direction & 1) - 1;
                if (next == other) contacts.push_back({member, direction});
            }
        }
        if (!isFree || contacts.size() <= added.contacts.size()) continue;
        added.cube = cube;
        added.contacts = contacts;
    }
    contacts = std::exchange(added.contacts, {});
    parts_.push_back(std::move(added));
    const auto number = static_cast<Index>(parts_.size()) - 1;
    for (const Contact& contact : contacts) addContact(number, contact);
}

Lattice GridCells::build() const {
    Lattice lattice;
    lattice.positions.resize(vertexCount_);
    far::ComplexBuilder builder(3, vertexCount_);
    const CubeGrid& grid = voxels_.grid();
    constexpr std::array<unsigned, 8> kHexahedron = {0, 1, 3, 2, 4, 5, 7, 6};
    for (const Index p : order_) {
        const Part& part = parts_[p];
        std::array<Index, 8> vertices;
        for (std::size_t i = 0; i < 8; ++i) vertices[i] = corners_[p][kHexahedron[i]];
        builder.addCell(far::StandardCell::Hexahedron, vertices);
        for (unsigned corner = 0; corner < 8; ++corner)
            for (int axis = 0; axis < 3; ++axis) {
                const Index place = part.cube[axis] + static_cast<Index>(corner >> axis & 1);
                lattice.positions[corners_[p][corner]][axis] =
                    grid.origin[axis] +
                    (place * options_.voxelsPerEdge - options_.offset[axis]) * grid.size;
            }
    }
    lattice.complex = builder.build();
    return lattice;
}

Index GridCells::cellOf(const Point3& point) const {
    const Index part = partOf_[voxels_.grid().cubeOf(point)];
    return part < 0 ? -1 : cellOfPart_[part];
}

}  // namespace espalier::cages

// SPDX-License-Identifier: Apache-2.0
#include "find_parts.h"

#include <espalier/base/progress.h>

#include <algorithm>
#include <utility>

#include "ranked_bits.h"

namespace espalier::cages {
namespace {

/// Finds parts and contacts. Call findParts(), then findContacts().
class PartSearch {
public:
    PartSearch(const ModelVoxels& voxels, const Cubes& cubes, double joinDistance)
        : voxels_(voxels), cubes_(cubes), joinDistance_(joinDistance) {}

    void findParts();
    void findContacts();
    /// Returns the result. The search is empty then.
    FoundParts take() { return std::move(found_); }

private:
    /// A voxel at faces of its cube.
    struct FaceVoxel {
        Index voxel = 0;
        unsigned directions = 0;  ///< bits of the faces with a voxel of the grid behind them
    };
    RankedBits usedCubes() const;
    bool areNear(const CubePart& a, const CubePart& b) const;

    const ModelVoxels& voxels_;
    const Cubes& cubes_;
    double joinDistance_;
    FoundParts found_;
    std::vector<std::vector<FaceVoxel>> faces_;  ///< of each part, the voxels at faces of its cube
};

/// Returns the cubes that hold voxels of the model, by their numbers.
RankedBits PartSearch::usedCubes() const {
    const auto& n = voxels_.grid().counts;
    RankedBits cubes(cubes_.numberOf({0, 0, cubes_.counts[2]}));
    for (Index z = 0; z < n[2]; ++z) {
        for (Index y = 0; y < n[1]; ++y) {
            const std::size_t row = (Offset{z} * n[1] + y) * n[0];
            if (!voxels_.used().hasAny(row, row + n[0])) continue;
            Cubes::Cube cube = {0, (y + cubes_.offset[1]) / cubes_.perEdge,
                                (z + cubes_.offset[2]) / cubes_.perEdge};
            for (; cube[0] < cubes_.counts[0]; ++cube[0]) {
                const Index low = std::max(cube[0] * cubes_.perEdge - cubes_.offset[0], 0);
                const Index high =
                    std::min((cube[0] + 1) * cubes_.perEdge - cubes_.offset[0], n[0]);
                if (voxels_.used().hasAny(row + low, row + std::max(low, high)))
                    cubes.insert(cubes_.numberOf(cube));
            }
        }
    }
    return cubes;
}

/// Finds the connected parts of the model in each cube.
void PartSearch::findParts() {
    const auto& n = voxels_.grid().counts;
    const Index k = cubes_.perEdge, wide = k + 2;
    found_.partOf.resize(voxels_.used().count());
    // A copy of one cube, with a layer of voxels around it that are not used: 1 for voxels that are
    // in no part yet. The layer saves a bounds test and a rank for each neighbour.
    std::vector<char> isFree(Offset{wide} * wide * wide, 0);
    const std::array<Index, 3> localStrides = {1, wide, wide * wide};
    struct Member {
        Index local;
        std::array<Index, 3> place;  ///< in the cube
    };
    std::vector<Member> members;
    usedCubes().forEach([&](std::size_t number) {
        checkCancelled();
        const auto row = static_cast<Index>(number) / cubes_.counts[0];
        const Cubes::Cube cube = {static_cast<Index>(number) % cubes_.counts[0],
                                  row % cubes_.counts[1], row / cubes_.counts[1]};
        std::array<Index, 3> origin, low, high;  // the first voxel of the cube; in the cube
        for (int axis = 0; axis < 3; ++axis) {
            origin[axis] = cube[axis] * k - cubes_.offset[axis];
            low[axis] = std::max(-origin[axis], 0);
            high[axis] = std::min(k, n[axis] - origin[axis]);
        }
        const auto forEachPlace = [&](auto visit) {
            for (Index z = low[2]; z < high[2]; ++z)
                for (Index y = low[1]; y < high[1]; ++y)
                    for (Index x = low[0]; x < high[0]; ++x)
                        visit(std::array<Index, 3>{x, y, z},
                              x + 1 + (y + 1) * wide + (z + 1) * wide * wide);
        };
        const auto voxelAt = [&](const std::array<Index, 3>& place) {
            return ((origin[2] + place[2]) * n[1] + origin[1] + place[1]) * n[0] + origin[0] +
                   place[0];
        };
        forEachPlace([&](const std::array<Index, 3>& place, Index local) {
            isFree[local] = voxels_.used()[voxelAt(place)] ? 1 : 0;
        });
        const std::size_t first = found_.parts.size();
        forEachPlace([&](const std::array<Index, 3>& start, Index local) {
            if (isFree[local] == 0) return;
            CubePart part;
            part.cube = cube;
            std::vector<FaceVoxel> atFaces;
            members = {{local, start}};
            isFree[local] = 0;
            for (std::size_t i = 0; i < members.size(); ++i) {
                const Member at = members[i];
                const Index voxel = voxelAt(at.place);
                part.voxels.push_back(voxel);
                unsigned directions = 0;
                for (int axis = 0; axis < 3; ++axis) {
                    for (const Index side : {0, 1}) {
                        const Index step = 2 * side - 1;
                        Member next = at;
                        next.place[axis] += step;
                        const bool isInGrid = next.place[axis] >= -origin[axis] &&
                                              next.place[axis] < n[axis] - origin[axis];
                        if (isInGrid && (next.place[axis] < 0 || next.place[axis] >= k))
                            directions |= 1u << (2 * axis + side);
                        next.local += step * localStrides[axis];
                        if (isFree[next.local] == 0) continue;
                        isFree[next.local] = 0;
                        members.push_back(next);
                    }
                }
                if (directions != 0) atFaces.push_back({voxel, directions});
            }
            found_.parts.push_back(std::move(part));
            faces_.push_back(std::move(atFaces));
        });
        // Parts that are near to each other are one part.
        for (std::size_t a = first; a < found_.parts.size(); ++a) {
            for (std::size_t b = a + 1; b < found_.parts.size();) {
                if (!areNear(found_.parts[a], found_.parts[b])) {
                    ++b;
                    continue;
                }
                const auto append = [](auto& to, const auto& more) {
                    to.insert(to.end(), more.begin(), more.end());
                };
                append(found_.parts[a].voxels, found_.parts[b].voxels);
                append(faces_[a], faces_[b]);
                found_.parts.erase(found_.parts.begin() + static_cast<std::ptrdiff_t>(b));
                faces_.erase(faces_.begin() + static_cast<std::ptrdiff_t>(b));
                b = a + 1;
            }
        }
        for (std::size_t a = first; a < found_.parts.size(); ++a)
            for (const Index voxel : found_.parts[a].voxels)
                found_.partOf[voxels_.used().rank(voxel)] = static_cast<Index>(a);
    });
}

/// Returns true if a voxel of one part is at most the join distance from a voxel of another part.
bool PartSearch::areNear(const CubePart& a, const CubePart& b) const {
    const double distance = joinDistance_;
    // Voxels with a common face are in one part, or in contact.
    if (distance <= 1) return false;
    // First the boxes around the two.
    std::array<std::array<Index, 3>, 2> low, high;
    for (const int side : {0, 1}) {
        low[side].fill(kMaxIndex);
        high[side].fill(-1);
        for (const Index voxel : side == 0 ? a.voxels : b.voxels) {
            const auto place = voxels_.grid().coordinatesOf(voxel);
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
    std::size_t step = 0;
    for (const Index p : a.voxels) {
        checkCancelledEvery(step++, 6);
        const auto place = voxels_.grid().coordinatesOf(p);
        for (int axis = 0; axis < 3; ++axis)
            way[axis] = std::max({low[1][axis] - place[axis], place[axis] - high[1][axis], 0});
        if (away(way) > distance * distance) continue;
        for (const Index q : b.voxels) {
            const auto other = voxels_.grid().coordinatesOf(q);
            for (int axis = 0; axis < 3; ++axis) way[axis] = place[axis] - other[axis];
            if (away(way) <= distance * distance) return true;
        }
    }
    return false;
}

void PartSearch::findContacts() {
    const auto& n = voxels_.grid().counts;
    const std::array<Index, 3> strides = {1, n[0], n[0] * n[1]};
    for (std::size_t p = 0; p < found_.parts.size(); ++p) {
        CubePart& part = found_.parts[p];
        checkCancelled();
        for (const auto& [voxel, directions] : faces_[p]) {
            for (Index direction = 0; direction < kDirections; ++direction) {
                if ((directions >> direction & 1) == 0) continue;
                const Index next = voxel + (2 * (direction & 1) - 1) * strides[direction / 2];
                if (!voxels_.used()[next]) continue;
                const Index other = found_.partOf[voxels_.used().rank(next)];
                auto found =
                    std::find_if(part.contacts.begin(), part.contacts.end(),
                                 [&](const CubePart::Contact& contact) {
                                     return contact.to == other && contact.direction == direction;
                                 });
                if (found == part.contacts.end())
                    found = part.contacts.insert(found, {other, direction});
                ++found->count;
            }
        }
    }
    // Parts in neighbouring cubes that are near to each other have contacts, too.
    const Index cubeCount = cubes_.counts[0] * cubes_.counts[1] * cubes_.counts[2];
    std::vector<Index> firstPart(cubeCount + 1, static_cast<Index>(found_.parts.size()));
    for (std::size_t p = found_.parts.size(); p-- > 0;)
        firstPart[cubes_.numberOf(found_.parts[p].cube)] = static_cast<Index>(p);
    for (Index cube = cubeCount; cube-- > 0;)
        firstPart[cube] = std::min(firstPart[cube], firstPart[cube + 1]);
    for (std::size_t p = 0; p < found_.parts.size(); ++p) {
        for (Index axis = 0; axis < 3; ++axis) {
            Cubes::Cube cube = found_.parts[p].cube;
            ++cube[axis];
            const Index number = cubes_.numberOf(cube);
            for (Index q = firstPart[number]; q < firstPart[number + 1]; ++q) {
                const auto isThis = [&](const CubePart::Contact& contact) {
                    return contact.to == q;
                };
                if (std::any_of(found_.parts[p].contacts.begin(), found_.parts[p].contacts.end(),
                                isThis) ||
                    !areNear(found_.parts[p], found_.parts[q]))
                    continue;
                found_.parts[p].contacts.push_back({q, 2 * axis + 1});
                found_.parts[q].contacts.push_back({static_cast<Index>(p), 2 * axis});
            }
        }
    }
}

}  // namespace

Cubes::Cubes(const CubeGrid& grid, Index edge, const Cube& before) : perEdge(edge), offset(before) {
    for (int axis = 0; axis < 3; ++axis) {
        // A layer of cubes on both sides.
        offset[axis] += perEdge;
        counts[axis] = (grid.counts[axis] + offset[axis]) / perEdge + 2;
    }
}

FoundParts findParts(const ModelVoxels& voxels, const Cubes& cubes, double joinDistance) {
    PartSearch search(voxels, cubes, joinDistance);
    search.findParts();
    search.findContacts();
    return search.take();
}

}  // namespace espalier::cages

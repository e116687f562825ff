// SPDX-License-Identifier: Apache-2.0
#include "cube_parts.h"

#include <espalier/base/progress.h>
#include <espalier/base/vector3.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <utility>

namespace espalier::cages {
namespace {

constexpr Index kNone = -1;  ///< stands for no part

/// Returns true if some faces of a cube are connected over edges.
bool areConnected(unsigned faces) {
    unsigned reached = faces & (~faces + 1);
    for (int round = 0; round < 3; ++round)
        for (Index d = 0; d < CubeParts::kDirections; ++d)
            if ((reached >> d & 1) != 0) reached |= faces & ~(3u << (d / 2 * 2));
    return reached == faces;
}

/// Returns a direction mirrored across axes.
Index mirroredDirection(Index direction, unsigned axes) {
    return (axes >> (direction / 2) & 1) != 0 ? opposite(direction) : direction;
}

/// Returns true if some faces of a cube form a disk.
bool isDisk(unsigned faces) {
    return faces != 0 && faces != 63 && areConnected(faces) && areConnected(63 & ~faces);
}

}  // namespace

CubeParts::CubeParts(const ModelVoxels& voxels, Index perEdge, const Cube& offset,
                     double joinDistance, unsigned mirrorAxes)
    : voxels_(voxels),
      perEdge_(perEdge),
      offset_(offset),
      joinDistance_(joinDistance),
      mirrorAxes_(mirrorAxes) {
    for (int axis = 0; axis < 3; ++axis) {
        // A layer of cubes on both sides.
        offset_[axis] += perEdge_;
        counts_[axis] = (voxels.grid().counts[axis] + offset_[axis]) / perEdge_ + 2;
    }
    std::vector<std::vector<FaceVoxel>> faces;
    findParts(faces);
    findContacts(faces);
    findImages();
}

void CubeParts::findImages() {
    joinedTo_.resize(parts_.size());
    std::iota(joinedTo_.begin(), joinedTo_.end(), 0);
    images_.assign(parts_.size(), {});
    for (std::size_t p = 0; p < parts_.size(); ++p)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if ((mirrorAxes_ >> axis & 1) == 0) continue;
            auto place = placeOf(parts_[p].voxels.front());
            place[axis] = voxels_.grid().counts[axis] - 1 - place[axis];
            images_[p][axis] = partOf_[voxels_.used().rank(voxels_.grid().cubeAt(place))];
        }
}

/// Returns the mirror image of a cube.
/// \param axes bits of the axes across which it is mirrored
CubeParts::Cube CubeParts::mirrored(Cube cube, unsigned axes) const {
    for (std::size_t axis = 0; axis < 3; ++axis)
        if ((axes >> axis & 1) != 0)
            cube[axis] =
                (voxels_.grid().counts[axis] + 2 * offset_[axis]) / perEdge_ - 1 - cube[axis];
    return cube;
}

/// Returns the part that a part was joined to; itself if it was not joined.
Index CubeParts::alive(Index part) const {
    while (joinedTo_[part] != part) part = joinedTo_[part];
    return part;
}

Index CubeParts::imageOf(Index part, int axis) const {
    return alive(images_[part][axis]);
}

Index CubeParts::imageOf(Index part, unsigned axes) const {
    part = alive(part);
    for (int axis = 0; axis < 3; ++axis)
        if ((axes >> axis & 1) != 0) part = imageOf(part, axis);
    return part;
}

/// Calls visit(axes) for each set of axes to mirror across: none first.
template <class Visit>
void CubeParts::forEachMirror(Visit visit) const {
    for (unsigned axes = 0; axes < 8; ++axes)
        if ((axes & ~mirrorAxes_) == 0) visit(axes);
}

/// Returns a part and its images, each once.
std::vector<Index> CubeParts::orbitOf(Index part) const {
    std::vector<Index> orbit;
    forEachMirror([&](unsigned axes) {
        const Index image = imageOf(part, axes);
        if (std::ranges::find(orbit, image) == orbit.end()) orbit.push_back(image);
    });
    return orbit;
}

/// Returns the cubes that hold voxels of the model, by their numbers.
RankedBits CubeParts::usedCubes() const {
    const auto& n = voxels_.grid().counts;
    RankedBits cubes(numberOf({0, 0, counts_[2]}));
    for (Index z = 0; z < n[2]; ++z)
        for (Index y = 0; y < n[1]; ++y) {
            const std::size_t row = (Offset{z} * n[1] + y) * n[0];
            if (!voxels_.used().hasAny(row, row + n[0])) continue;
            Cube cube = {0, (y + offset_[1]) / perEdge_, (z + offset_[2]) / perEdge_};
            for (; cube[0] < counts_[0]; ++cube[0]) {
                const Index low = std::max(cube[0] * perEdge_ - offset_[0], 0);
                const Index high = std::min((cube[0] + 1) * perEdge_ - offset_[0], n[0]);
                if (voxels_.used().hasAny(row + low, row + std::max(low, high)))
                    cubes.insert(numberOf(cube));
            }
        }
    return cubes;
}

/// Finds the connected parts of the model in each cube.
/// \param faces gets, for each part, its voxels at the faces of its cube
void CubeParts::findParts(std::vector<std::vector<FaceVoxel>>& faces) {
    const auto& n = voxels_.grid().counts;
    const Index k = perEdge_, wide = k + 2;
    parts_.clear();
    partOf_.assign(voxels_.used().count(), kNone);
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
        const auto row = static_cast<Index>(number) / counts_[0];
        const Cube cube = {static_cast<Index>(number) % counts_[0], row % counts_[1],
                           row / counts_[1]};
        std::array<Index, 3> origin, low, high;  // the first voxel of the cube; in the cube
        for (int axis = 0; axis < 3; ++axis) {
            origin[axis] = cube[axis] * k - offset_[axis];
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
        const std::size_t first = parts_.size();
        forEachPlace([&](const std::array<Index, 3>& start, Index local) {
            if (isFree[local] == 0) return;
            Part part;
            part.cube = cube;
            std::vector<FaceVoxel> atFaces;
            members = {{local, start}};
            isFree[local] = 0;
            for (std::size_t i = 0; i < members.size(); ++i) {
                const Member at = members[i];
                const Index voxel = voxelAt(at.place);
                part.voxels.push_back(voxel);
                unsigned directions = 0;
                for (int axis = 0; axis < 3; ++axis)
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
                if (directions != 0) atFaces.push_back({voxel, directions});
            }
            parts_.push_back(std::move(part));
            faces.push_back(std::move(atFaces));
        });
        // Parts that are near to each other are one part.
        for (std::size_t a = first; a < parts_.size(); ++a)
            for (std::size_t b = a + 1; b < parts_.size();) {
                if (!areNear(parts_[a], parts_[b])) {
                    ++b;
                    continue;
                }
                const auto append = [](auto& to, const auto& more) {
                    to.insert(to.end(), more.begin(), more.end());
                };
                append(parts_[a].voxels, parts_[b].voxels);
                append(faces[a], faces[b]);
                parts_.erase(parts_.begin() + static_cast<std::ptrdiff_t>(b));
                faces.erase(faces.begin() + static_cast<std::ptrdiff_t>(b));
                b = a + 1;
            }
        for (std::size_t a = first; a < parts_.size(); ++a)
            for (const Index voxel : parts_[a].voxels)
                partOf_[voxels_.used().rank(voxel)] = static_cast<Index>(a);
    });
}

Index CubeParts::numberOf(const Cube& cube) const {
    return (cube[2] * counts_[1] + cube[1]) * counts_[0] + cube[0];
}

Point3 CubeParts::cornerOf(const Cube& cube) const {
    const CubeGrid& grid = voxels_.grid();
    Point3 corner;
    for (int axis = 0; axis < 3; ++axis)
        corner[axis] = grid.origin[axis] + (cube[axis] * perEdge_ - offset_[axis]) * grid.size;
    return corner;
}

std::optional<Index> CubeParts::partAt(const Point3& point) const {
    const Index voxel = voxels_.grid().cubeOf(point);
    if (!voxels_.used()[voxel]) return std::nullopt;
    return partOf_[voxels_.used().rank(voxel)];
}

std::array<Index, 3> CubeParts::placeOf(Index voxel) const {
    const auto& n = voxels_.grid().counts;
    return {voxel % n[0], voxel / n[0] % n[1], voxel / n[0] / n[1]};
}

/// Returns true if a voxel of one part is at most the join distance from a voxel of another part.
bool CubeParts::areNear(const Part& a, const Part& b) const {
    const double distance = joinDistance_;
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
    std::size_t step = 0;
    for (const Index p : a.voxels) {
        checkCancelledEvery(step++, 6);
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

void CubeParts::findContacts(std::span<const std::vector<FaceVoxel>> faces) {
    const auto& n = voxels_.grid().counts;
    const std::array<Index, 3> strides = {1, n[0], n[0] * n[1]};
    for (std::size_t p = 0; p < parts_.size(); ++p) {
        Part& part = parts_[p];
        checkCancelled();
        for (const auto& [voxel, directions] : faces[p])
            for (Index direction = 0; direction < kDirections; ++direction) {
                if ((directions >> direction & 1) == 0) continue;
                const Index next = voxel + (2 * (direction & 1) - 1) * strides[direction / 2];
                if (!voxels_.used()[next]) continue;
                const Index other = partOf_[voxels_.used().rank(next)];
                auto found = std::find_if(
                    part.contacts.begin(), part.contacts.end(), [&](const Contact& contact) {
                        return contact.to == other && contact.direction == direction;
                    });
                if (found == part.contacts.end())
                    found = part.contacts.insert(found, {other, direction});
                ++found->count;
            }
    }
    // Parts in neighbouring cubes that are near to each other have contacts, too.
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

std::optional<Index> CubeParts::neighbour(Index part, Index direction) const {
    std::optional<Index> found;
    for (const Contact& contact : parts_[part].contacts) {
        if (contact.direction != direction) continue;
        if (found) return std::nullopt;
        found = contact.to;
    }
    return found;
}

bool CubeParts::hasSeveral(Index part, Index direction) const {
    const auto hasDirection = [&](const Contact& contact) {
        return contact.direction == direction;
    };
    return std::ranges::count_if(parts_[part].contacts, hasDirection) > 1;
}

unsigned CubeParts::sharedFaces(Index part) const {
    unsigned faces = 0;
    for (const Contact& contact : parts_[part].contacts) faces |= 1u << contact.direction;
    return faces;
}

/// Returns true if the parts around an edge of a part form a ring. The edge is between two faces
/// with parts behind them.
bool CubeParts::isClosedAround(Index part, Index first, Index second) const {
    const auto a = neighbour(part, first), b = neighbour(part, second);
    if (!a || !b) return false;
    const auto across = neighbour(*a, second);
    return across && neighbour(*b, first) == across;
}

bool CubeParts::isRemovable(Index number) const {
    const Part& part = parts_[number];
    if (part.isAdded || !part.isUsed) return false;
    const unsigned faces = sharedFaces(number);
    if (!isDisk(faces)) return false;
    for (Index d = 0; d < kDirections; ++d) {
        if ((faces >> d & 1) == 0) continue;
        if (!neighbour(number, d)) return false;
        for (Index e = d + 1; e < kDirections; ++e)
            if ((faces >> e & 1) != 0 && d / 2 != e / 2 && !isClosedAround(number, d, e))
                return false;
    }
    return true;
}

/// Returns the square of the distance of the centre of a voxel from a face of a cube, in voxels.
double CubeParts::squareToFace(const Cube& cube, Index direction,
                               const std::array<Index, 3>& place) const {
    double square = 0;
    for (Index axis = 0; axis < 3; ++axis) {
        const Index low = cube[axis] * perEdge_ - offset_[axis];
        const double at = place[axis] + 0.5 - low, high = perEdge_;
        double way;
        if (axis == direction / 2)
            way = at - ((direction & 1) != 0 ? high : 0);
        else
            way = at - std::clamp(at, 0.0, high);
        square += way * way;
    }
    return square;
}

bool CubeParts::isShallow(Index number, double most, double& depth) const {
    return areShallow(parts_[number], sharedFaces(number), most, depth);
}

/// Returns true if no voxel of a part is further than `most` from some of its faces.
bool CubeParts::areShallow(const Part& part, unsigned faces, double most, double& depth) const {
    depth = 0;
    double largest = -1;
    for (const Index voxel : part.voxels) {
        const auto place = placeOf(voxel);
        double least = std::numeric_limits<double>::infinity();
        for (Index d = 0; d < kDirections; ++d)
            if ((faces >> d & 1) != 0) least = std::min(least, squareToFace(part.cube, d, place));
        if (least <= largest) continue;
        largest = least;
        depth = std::sqrt(least) + 0.5;
        if (depth > most) return false;
    }
    return true;
}

bool CubeParts::leaveOut(Index number, double most) {
    double depth = 0;
    if (!isRemovable(number) || !isShallow(number, most, depth)) return false;
    const std::vector<Index> orbit = orbitOf(number);
    // The voxels go to neighbours that stay.
    std::vector<std::array<std::optional<Index>, kDirections>> behind(orbit.size());
    for (std::size_t i = 0; i < orbit.size(); ++i)
        for (Index d = 0; d < kDirections; ++d) {
            const auto next = neighbour(orbit[i], d);
            if (next && std::ranges::find(orbit, *next) == orbit.end()) behind[i][d] = next;
        }
    if (areApart(orbit)) {
        for (const Index part : orbit) detach(part);
    } else {
        // Images that touch each other: the topology must stay the same as they leave one by one.
        unsigned faces = 0;
        for (Index d = 0; d < kDirections; ++d)
            if (behind.front()[d]) faces |= 1u << d;
        if (faces == 0 || !areShallow(parts_[number], faces, most, depth) || !detachAll(orbit))
            return false;
    }
    for (std::size_t i = 0; i < orbit.size(); ++i) giveVoxels(orbit[i], behind[i]);
    return true;
}

/// Returns true if parts are so far apart that none of them matters to isRemovable() of another.
bool CubeParts::areApart(std::span<const Index> orbit) const {
    for (std::size_t i = 0; i < orbit.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            const Cube &a = parts_[orbit[i]].cube, &b = parts_[orbit[j]].cube;
            Index distance = 0;
            for (std::size_t axis = 0; axis < 3; ++axis)
                distance = std::max(distance, std::abs(a[axis] - b[axis]));
            if (distance <= 1) return false;
        }
    return true;
}

/// Detaches parts one by one, if each of them is removable then. Else changes nothing.
bool CubeParts::detachAll(std::span<const Index> orbit) {
    std::vector<std::pair<Index, std::vector<Contact>>> before;
    for (const Index part : orbit) {
        before.emplace_back(part, parts_[part].contacts);
        for (const Contact& contact : parts_[part].contacts)
            before.emplace_back(contact.to, parts_[contact.to].contacts);
    }
    for (const Index part : orbit) {
        if (isRemovable(part)) {
            detach(part);
            continue;
        }
        for (const Index old : orbit) parts_[old].isUsed = true;
        for (auto& [old, contacts] : before) parts_[old].contacts = std::move(contacts);
        return false;
    }
    return true;
}

/// Takes a part out, with its contacts.
void CubeParts::detach(Index number) {
    Part& part = parts_[number];
    for (const Contact& contact : part.contacts)
        std::erase_if(parts_[contact.to].contacts,
                      [&](const Contact& back) { return back.to == number; });
    part.contacts.clear();
    part.isUsed = false;
}

/// Gives each voxel of a part to the nearest one of its neighbours.
void CubeParts::giveVoxels(Index number,
                           const std::array<std::optional<Index>, kDirections>& neighbours) {
    Part& part = parts_[number];
    for (const Index voxel : part.voxels) {
        const auto place = placeOf(voxel);
        Index best = kNone;
        double least = 0;
        for (Index d = 0; d < kDirections; ++d) {
            if (!neighbours[d]) continue;
            const double distance = squareToFace(part.cube, d, place);
            if (best != kNone && distance >= least) continue;
            best = *neighbours[d];
            least = distance;
        }
        parts_[best].voxels.push_back(voxel);
        partOf_[voxels_.used().rank(voxel)] = best;
    }
    part.voxels.clear();
}

void CubeParts::join(Index kept, Index other, int joins) {
    // The joins change the images, so all pairs are found first.
    std::vector<std::pair<Index, Index>> pairs;
    forEachMirror(
        [&](unsigned axes) { pairs.emplace_back(imageOf(kept, axes), imageOf(other, axes)); });
    for (const auto& [first, second] : pairs)
        if (const Index a = alive(first), b = alive(second); a != b) joinPair(a, b, joins);
}

void CubeParts::joinPair(Index kept, Index other, int joins) {
    Part &a = parts_[kept], &b = parts_[other];
    a.joins = std::max({a.joins, b.joins, joins});
    if (a.joins > 1 && !joined_) {
        const Cube next = {a.cube[0] + 1, a.cube[1] + 1, a.cube[2] + 1};
        joined_ = between(cornerOf(a.cube), cornerOf(next), 0.5);
    }
    for (const Index voxel : b.voxels) partOf_[voxels_.used().rank(voxel)] = kept;
    a.voxels.insert(a.voxels.end(), b.voxels.begin(), b.voxels.end());
    a.isAdded = a.isAdded || b.isAdded;
    for (const Contact& contact : b.contacts) {
        auto& backs = parts_[contact.to].contacts;
        std::erase_if(backs, [&](const Contact& back) { return back.to == other; });
        addOneContact(kept, contact);
    }
    b.contacts.clear();
    b.voxels.clear();
    b.isUsed = false;
    joinedTo_[other] = kept;
}

void CubeParts::addContact(Index part, const Contact& contact) {
    forEachMirror([&](unsigned axes) {
        addOneContact(
            imageOf(part, axes),
            {imageOf(contact.to, axes), mirroredDirection(contact.direction, axes), contact.count});
    });
}

void CubeParts::addOneContact(Index part, const Contact& contact) {
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

void CubeParts::add(const Cube& low, std::span<const Index> members) {
    // Takes the free cube with the most neighbours.
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
    if (added.contacts.empty()) return;
    contacts = std::exchange(added.contacts, {});
    // The images that lie in one cube are one part.
    const auto first = static_cast<Index>(parts_.size());
    std::array<Index, 8> numbers = {};
    forEachMirror([&](unsigned axes) {
        const Cube cube = mirrored(added.cube, axes);
        Index& number = numbers[axes];
        for (number = first; number < count() && parts_[number].cube != cube;) ++number;
        if (number < count()) return;
        parts_.push_back(added);
        parts_.back().cube = cube;
        joinedTo_.push_back(number);
        images_.emplace_back();
    });
    forEachMirror([&](unsigned axes) {
        for (std::size_t axis = 0; axis < 3; ++axis)
            if ((mirrorAxes_ >> axis & 1) != 0)
                images_[numbers[axes]][axis] = numbers[axes ^ 1u << axis];
    });
    for (const Contact& contact : contacts) addContact(first, contact);
}

}  // namespace espalier::cages

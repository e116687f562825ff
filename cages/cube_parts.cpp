// SPDX-License-Identifier: Apache-2.0
#include "cube_parts.h"

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
    : voxels_(voxels), cubes_(voxels.grid(), perEdge, offset), mirrorAxes_(mirrorAxes) {
    FoundParts found = findParts(voxels, cubes_, joinDistance);
    parts_ = std::move(found.parts);
    partOf_ = std::move(found.partOf);
    findImages();
}

void CubeParts::findImages() {
    joinedTo_.resize(parts_.size());
    std::iota(joinedTo_.begin(), joinedTo_.end(), 0);
    images_.assign(parts_.size(), {});
    for (std::size_t p = 0; p < parts_.size(); ++p)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if ((mirrorAxes_ >> axis & 1) == 0) continue;
            auto place = voxels_.grid().coordinatesOf(parts_[p].voxels.front());
            place[axis] = voxels_.grid().counts[axis] - 1 - place[axis];
            images_[p][axis] = partOf_[voxels_.used().rank(voxels_.grid().cubeAt(place))];
        }
}

/// Returns the mirror image of a cube.
/// \param axes bits of the axes across which it is mirrored
CubeParts::Cube CubeParts::mirrored(Cube cube, unsigned axes) const {
    for (std::size_t axis = 0; axis < 3; ++axis)
        if ((axes >> axis & 1) != 0)
            cube[axis] = (voxels_.grid().counts[axis] + 2 * cubes_.offset[axis]) / cubes_.perEdge -
                         1 - cube[axis];
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

Point3 CubeParts::cornerOf(const Cube& cube) const {
    const CubeGrid& grid = voxels_.grid();
    Point3 corner;
    for (int axis = 0; axis < 3; ++axis)
        corner[axis] =
            grid.origin[axis] + (cube[axis] * cubes_.perEdge - cubes_.offset[axis]) * grid.size;
    return corner;
}

std::optional<Index> CubeParts::partAt(const Point3& point) const {
    const Index voxel = voxels_.grid().cubeOf(point);
    if (!voxels_.used()[voxel]) return std::nullopt;
    return partOf_[voxels_.used().rank(voxel)];
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
        const Index low = cube[axis] * cubes_.perEdge - cubes_.offset[axis];
        const double at = place[axis] + 0.5 - low, high = cubes_.perEdge;
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
        const auto place = voxels_.grid().coordinatesOf(voxel);
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
        const auto place = voxels_.grid().coordinatesOf(voxel);
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

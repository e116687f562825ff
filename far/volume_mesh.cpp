// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/far/second_order_cells.h>
#include <espalier/far/topology_error.h>
#include <espalier/far/volume_mesh.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "canonical_loop.h"

namespace espalier::far {

struct VolumeMesh::Data {
    Index pointCount = 0;
    Rows<Index> faces;
    std::vector<Index> owners;
    std::vector<Index> neighbours;  ///< the neighbours of the internal faces
    Rows<Index> facesOfCells;
    Rows<Index> points;  ///< the points of each cell, corners first; empty rows for polyhedra
};

namespace {

Index checkedCount(std::size_t count, const char* what) {
    if (std::cmp_greater(count, kMaxIndex))
        throw TopologyError(
            TopologyCause::TooManyEntities, {2, kMaxIndex},
            concat("the mesh has ", count, " ", what, "; at most ", kMaxIndex, " can be counted"));
    return static_cast<Index>(count);
}

/// Finds the corners of a cell that is standard, from its faces. The loops are anticlockwise seen
/// from outside.
class CornerFinder {
public:
    /// Takes the next face of the cell.
    void add(std::span<const Index> loop, bool isOwner) {
        if (count_ == kMaxFaces || loop.size() > kMaxSize) {
            count_ = kMaxFaces + 1;
            return;
        }
        if (count_ > kMaxFaces) return;
        Loop& copy = loops_[count_++];
        copy.size = loop.size();
        for (std::size_t i = 0; i < loop.size(); ++i)
            copy.points[isOwner ? i : loop.size() - 1 - i] = loop[i];
    }

    /// Returns the corners in VTK's order; empty if the cell is not standard.
    std::span<const Index> find() {
        std::size_t triangles = 0;
        if (count_ > kMaxFaces) return {};
        for (std::size_t f = 0; f < count_; ++f) triangles += loops_[f].size == 3 ? 1 : 0;
        const std::size_t quadrilaterals = count_ - triangles;
        if (triangles == 4 && quadrilaterals == 0) return withApex(3);
        if (triangles == 4 && quadrilaterals == 1) return withApex(4);
        if (triangles == 2 && quadrilaterals == 3) return prism(3);
        if (triangles == 0 && quadrilaterals == 6) return prism(4);
        return {};
    }

private:
    static constexpr std::size_t kMaxFaces = 6, kMaxSize = 4;
    struct Loop {
        std::array<Index, kMaxSize> points{};
        std::size_t size = 0;
    };

    /// Returns the first face of this size.
    const Loop& firstOf(std::size_t size) const {
        return *std::find_if(loops_.begin(), loops_.end(),
                             [&](const Loop& loop) { return loop.size == size; });
    }

    /// Returns the point after the step from a to b in one of the faces; nothing if no face has
    /// that step.
    std::optional<Index> follower(Index a, Index b) const {
        for (std::size_t f = 0; f < count_; ++f) {
            const Loop& loop = loops_[f];
            for (std::size_t i = 0; i < loop.size; ++i)
                if (loop.points[i] == a && loop.points[(i + 1) % loop.size] == b)
                    return loop.points[(i + 2) % loop.size];
        }
        return std::nullopt;
    }

    /// Returns the corners of a tetrahedron or a pyramid.
    std::span<const Index> withApex(std::size_t baseSize) {
        const Loop& base = firstOf(baseSize);
        for (std::size_t i = 0; i < baseSize; ++i) corners_[i] = base.points[baseSize - 1 - i];
        const auto apex = follower(corners_[0], corners_[1]);
        if (!apex) return {};
        corners_[baseSize] = *apex;
        return verified(baseSize == 3 ? StandardCell::Tetrahedron : StandardCell::Pyramid);
    }

    /// Returns the corners of a wedge or a hexahedron.
    std::span<const Index> prism(std::size_t baseSize) {
        const Loop& base = firstOf(baseSize);
        for (std::size_t i = 0; i < baseSize; ++i) corners_[i] = base.points[baseSize - 1 - i];
        for (std::size_t i = 0; i < baseSize; ++i) {
            const Index before = corners_[(i + baseSize - 1) % baseSize];
            const auto above = follower(before, corners_[i]);
            if (!above) return {};
            corners_[baseSize + i] = *above;
        }
        // VTK's wedge begins with the triangle that is clockwise seen from the other one.
        if (baseSize == 3) {
            std::swap(corners_[1], corners_[2]);
            std::swap(corners_[4], corners_[5]);
        }
        return verified(baseSize == 3 ? StandardCell::Wedge : StandardCell::Hexahedron);
    }

    /// Returns the corners if they are different and a cell of this kind on them has exactly the
    /// added faces.
    std::span<const Index> verified(StandardCell kind) const {
        const std::size_t size = vertexCount(kind);
        for (std::size_t i = 0; i < size; ++i)
            for (std::size_t j = 0; j < i; ++j)
                if (corners_[i] == corners_[j]) return {};
        // No two of the faces have the same first step, since an edge is in two faces, once in each
        // direction. So different faces of the kind are different faces of the cell.
        for (const std::vector<Index>& pattern : faceLoops(kind)) {
            const bool found =
                std::any_of(loops_.begin(), loops_.begin() + count_, [&](const Loop& loop) {
                    if (loop.size != pattern.size()) return false;
                    for (std::size_t start = 0; start < loop.size; ++start) {
                        std::size_t same = 0;
                        while (same < loop.size &&
                               loop.points[(start + same) % loop.size] == corners_[pattern[same]])
                            ++same;
                        if (same == loop.size) return true;
                    }
                    return false;
                });
            if (!found) return {};
        }
        return {corners_.data(), size};
    }

    std::array<Loop, kMaxFaces> loops_;
    std::size_t count_ = 0;
    std::array<Index, 8> corners_{};
};

/// A face of a cell before faces are shared.
struct HalfFace {
    Index cell;
    Index number;  ///< among the faces of the cell
};

/// The faces of cells that a builder has.
struct CellLoops {
    const Rows<Index>& points;
    const Rows<Index>& loops;
    const Rows<Index>& loopsOfCells;

    std::size_t count(Index cell) const {
        const auto kind = kindOfCell(points[cell].size());
        return kind ? faceLoops(*kind).size() : loopsOfCells[cell].size();
    }

    void read(const HalfFace& half, std::vector<Index>& loop) const {
        const auto ofCell = points[half.cell];
        if (const auto kind = kindOfCell(ofCell.size())) {
            const std::vector<Index>& places = faceLoops(*kind)[half.number];
            loop.resize(places.size());
            for (std::size_t i = 0; i < places.size(); ++i) loop[i] = ofCell[places[i]];
        } else {
            const auto ofFace = loops[loopsOfCells[half.cell][half.number]];
            loop.assign(ofFace.begin(), ofFace.end());
        }
    }
};

/// Numbers that are equal for equal loops with the same smallest point: the neighbours of this
/// point, and the point across. Loops of three or four points are equal if these numbers are.
struct LoopKey {
    static constexpr Index kTriangle = -1, kPolygon = -2;

    Index low, high;
    Index across;  ///< the point across, of a quadrilateral; else one of the constants
    Index half;
    friend auto operator<=>(const LoopKey&, const LoopKey&) = default;

    bool hasSameLoop(const LoopKey& other) const {
        return low == other.low && high == other.high && across == other.across;
    }
};

/// Joins pairs of half faces of different cells, in the order given.
/// \param isSame whether two consecutive half faces have the same loop
template <class Halves, class IsSame>
void joinPairs(const Halves& sorted, const std::vector<HalfFace>& halves, IsSame isSame,
               std::vector<Index>& mates) {
    for (std::size_t i = 0; i + 1 < sorted.size(); ++i) {
        const Index one = sorted[i].half, other = sorted[i + 1].half;
        if (!isSame(sorted[i], sorted[i + 1]) || halves[one].cell == halves[other].cell) continue;
        mates[one] = other;
        mates[other] = one;
        ++i;
    }
}

/// Returns the half face that shares the face of each half face; itself if there is none.
std::vector<Index> matesOf(const std::vector<HalfFace>& halves, const CellLoops& loops,
                           Index pointCount) {
    std::vector<Index> mates(halves.size());
    std::vector<Offset> ends(Offset{pointCount} + 1, 0);
    std::vector<Index> loop;
    // Calls f(half, position of the smallest point in `loop`), where `loop` is the loop of the
    // half.
    const auto forEachLoop = [&](auto f) {
        for (std::size_t half = 0; half < halves.size(); ++half) {
            checkCancelledEvery(half, 14);
            loops.read(halves[half], loop);
            f(half, std::min_element(loop.begin(), loop.end()) - loop.begin());
        }
    };
    // Twice, instead of keeping the keys: they take 16 bytes each.
    forEachLoop([&](std::size_t half, std::ptrdiff_t start) {
        mates[half] = static_cast<Index>(half);
        ++ends[loop[start] + 1];
    });
    for (std::size_t point = 0; point + 1 < ends.size(); ++point) ends[point + 1] += ends[point];
    std::vector<LoopKey> grouped(halves.size());
    std::vector<Offset> next(ends.begin(), ends.end() - 1);
    forEachLoop([&](std::size_t half, std::ptrdiff_t start) {
        const auto n = std::ssize(loop);
        const auto at = [&](std::ptrdiff_t i) {
            return loop[start + i < n ? start + i : start + i - n];
        };
        const Index after = at(1), before = at(n - 1);
        grouped[next[loop[start]]++] = {std::min(after, before), std::max(after, before),
                                        n == 3   ? LoopKey::kTriangle
                                        : n == 4 ? at(2)
                                                 : LoopKey::kPolygon,
                                        static_cast<Index>(half)};
    });

    struct Polygon {
        std::vector<Index> loop;
        Index half;
        auto operator<=>(const Polygon&) const = default;
    };
    std::vector<Polygon> polygons;
    for (std::size_t point = 0; point + 1 < ends.size(); ++point) {
        checkCancelledEvery(point, 12);
        const std::span group(grouped.data() + ends[point], grouped.data() + ends[point + 1]);
        std::sort(group.begin(), group.end());
        joinPairs(
            group, halves,
            [](const LoopKey& a, const LoopKey& b) {
                return a.across != LoopKey::kPolygon && a.hasSameLoop(b);
            },
            mates);
        polygons.clear();
        for (const LoopKey& key : group)
            if (key.across == LoopKey::kPolygon) {
                loops.read(halves[key.half], loop);
                appendCanonicalLoop(loop, polygons.emplace_back(Polygon{{}, key.half}).loop);
            }
        std::sort(polygons.begin(), polygons.end());
        joinPairs(
            polygons, halves, [](const Polygon& a, const Polygon& b) { return a.loop == b.loop; },
            mates);
    }
    return mates;
}

}  // namespace

VolumeMesh::VolumeMesh() : data_(std::make_shared<Data>()) {}

VolumeMesh::VolumeMesh(Index pointCount, Index cellCount, Rows<Index> faces,
                       std::vector<Index> owners, std::vector<Index> neighbours) {
    const Index faceCount = checkedCount(faces.count(), "faces");
    if (owners.size() != faces.count() || neighbours.size() > owners.size())
        throw Error(concat("got ", owners.size(), " owners and ", neighbours.size(),
                           " neighbours of ", faceCount, " faces"));
    auto data = std::make_shared<Data>();
    data->pointCount = pointCount;
    for (Index face = 0; face < faceCount; ++face) {
        checkCancelledEvery(face, 14);
        const auto loop = faces[face];
        if (loop.size() < 3)
            throw TopologyError(TopologyCause::TooFewVertices, {2, face},
                                concat("face ", face, " has fewer than 3 points"));
        for (const Index point : loop)
            if (point < 0 || point >= pointCount)
                throw TopologyError(
                    TopologyCause::VertexOutOfRange, {2, face},
                    concat("face ", face, " names point ", point, "; there are ", pointCount));
    }
    std::vector<Offset> ends(Offset{cellCount} + 1, 0);
    const auto count = [&](const std::vector<Index>& cells, const char* role) {
        for (std::size_t face = 0; face < cells.size(); ++face) {
            if (cells[face] < 0 || cells[face] >= cellCount)
                throw TopologyError(TopologyCause::EntityOutOfRange, {2, static_cast<Index>(face)},
                                    concat("face ", face, " has the ", role, " ", cells[face],
                                           "; there are ", cellCount, " cells"));
            ++ends[cells[face] + 1];
        }
    };
    count(owners, "owner");
    count(neighbours, "neighbour");
    for (Index cell = 0; cell < cellCount; ++cell) ends[cell + 1] += ends[cell];
    Rows<Index>& ofCells = data->facesOfCells;
    ofCells.offsets.assign(ends.begin(), ends.end());
    ofCells.values.resize(ends.back());
    for (Index face = 0; face < faceCount; ++face) {
        checkCancelledEvery(face, 16);
        ofCells.values[ends[owners[face]]++] = face;
        if (face < std::ssize(neighbours)) ofCells.values[ends[neighbours[face]]++] = face;
    }
    for (Index cell = 0; cell < cellCount; ++cell) {
        checkCancelledEvery(cell, 12);
        CornerFinder finder;
        for (const Index face : ofCells[cell]) finder.add(faces[face], owners[face] == cell);
        data->points.push(finder.find());
    }
    data->faces = std::move(faces);
    data->owners = std::move(owners);
    data->neighbours = std::move(neighbours);
    data_ = std::move(data);
}

Index VolumeMesh::pointCount() const {
    return data_->pointCount;
}

Index VolumeMesh::cellCount() const {
    return static_cast<Index>(data_->points.count());
}

Index VolumeMesh::faceCount() const {
    return static_cast<Index>(data_->owners.size());
}

Index VolumeMesh::internalFaceCount() const {
    return static_cast<Index>(data_->neighbours.size());
}

std::span<const Index> VolumeMesh::face(Index face) const {
    return data_->faces[face];
}

Index VolumeMesh::owner(Index face) const {
    return data_->owners[face];
}

Index VolumeMesh::neighbour(Index face) const {
    return data_->neighbours[face];
}

std::span<const Index> VolumeMesh::faces(Index cell) const {
    return data_->facesOfCells[cell];
}

std::optional<StandardCell> VolumeMesh::kind(Index cell) const {
    return kindOfCell(points(cell).size());
}

std::span<const Index> VolumeMesh::points(Index cell) const {
    return data_->points[cell];
}

std::span<const Index> VolumeMesh::corners(Index cell) const {
    const auto all = points(cell);
    const auto kind = kindOfCell(all.size());
    return kind ? all.first(vertexCount(*kind)) : all;
}

bool VolumeMesh::isSecondOrder(Index cell) const {
    return far::isSecondOrder(points(cell).size());
}

void VolumeMeshBuilder::checkPoints(std::span<const Index> points, Index cell) const {
    for (const Index point : points)
        if (point < 0 || point >= pointCount_)
            throw TopologyError(
                TopologyCause::VertexOutOfRange, {3, cell},
                concat("cell ", cell, " names point ", point, "; there are ", pointCount_));
}

Index VolumeMeshBuilder::addCell(StandardCell kind, std::span<const Index> points) {
    const Index cell = cellCount();
    checkCancelledEvery(cell, 12);
    if (kindOfCell(points.size()) != kind)
        throw TopologyError(
            TopologyCause::TooFewVertices, {3, cell},
            concat("cell ", cell, " has ", points.size(), " points; expected ", vertexCount(kind)));
    checkPoints(points, cell);
    points_.push(points);
    loopsOfCells_.push({});
    return cell;
}

Index VolumeMeshBuilder::addCell(std::span<const std::vector<Index>> loops) {
    const Index cell = cellCount();
    checkCancelledEvery(cell, 12);
    std::vector<Index> rows;
    for (const std::vector<Index>& loop : loops) {
        if (loop.size() < 3)
            throw TopologyError(TopologyCause::TooFewVertices, {3, cell},
                                concat("cell ", cell, " has a face of fewer than 3 points"));
        checkPoints(loop, cell);
    }
    for (const std::vector<Index>& loop : loops) {
        rows.push_back(static_cast<Index>(loops_.count()));
        loops_.push(loop);
    }
    points_.push({});
    loopsOfCells_.push(rows);
    return cell;
}

VolumeMesh VolumeMeshBuilder::build() {
    const CellLoops loops{points_, loops_, loopsOfCells_};
    std::vector<HalfFace> halves;
    std::size_t loopCount = 0;
    for (Index cell = 0; cell < cellCount(); ++cell) loopCount += loops.count(cell);
    halves.reserve(loopCount);
    for (Index cell = 0; cell < cellCount(); ++cell) {
        checkCancelledEvery(cell, 14);
        for (std::size_t i = 0; i < loops.count(cell); ++i)
            halves.push_back({cell, static_cast<Index>(i)});
    }
    const Index halfCount = checkedCount(halves.size(), "faces of cells");
    const std::vector<Index> mates = matesOf(halves, loops, pointCount_);

    auto data = std::make_shared<VolumeMesh::Data>();
    data->pointCount = pointCount_;
    Index internalCount = 0;
    Offset cornerCount = 0;
    std::vector<Index> loop;
    for (Index half = 0; half < halfCount; ++half) {
        checkCancelledEvery(half, 14);
        if (mates[half] < half) continue;
        internalCount += mates[half] != half;
        loops.read(halves[half], loop);
        cornerCount += std::ssize(loop);
    }
    data->faces.offsets.reserve(Offset{halfCount} - internalCount + 1);
    data->faces.values.reserve(cornerCount);
    data->owners.reserve(halfCount - internalCount);
    data->neighbours.reserve(internalCount);
    // Internal faces first, each at its first half.
    std::vector<Index> faceOfHalf(halves.size());
    for (const bool internal : {true, false})
        for (Index half = 0; half < halfCount; ++half) {
            checkCancelledEvery(half, 14);
            const Index mate = mates[half];
            if ((mate != half) != internal || mate < half) continue;
            loops.read(halves[half], loop);
            faceOfHalf[half] = static_cast<Index>(data->owners.size());
            data->faces.push(loop);
            data->owners.push_back(halves[half].cell);
            if (!internal) continue;
            faceOfHalf[mate] = faceOfHalf[half];
            data->neighbours.push_back(halves[mate].cell);
        }
    Rows<Index>& ofCells = data->facesOfCells;
    ofCells.offsets.reserve(points_.offsets.size());
    ofCells.values.reserve(halfCount);
    for (Index half = 0, cell = 0; cell < cellCount(); ++cell) {
        checkCancelledEvery(cell, 14);
        for (; half < halfCount && halves[half].cell == cell; ++half)
            ofCells.values.push_back(faceOfHalf[half]);
        ofCells.offsets.push_back(static_cast<Offset>(ofCells.values.size()));
    }
    data->points = std::move(points_);
    return VolumeMesh(std::move(data));
}

}  // namespace espalier::far

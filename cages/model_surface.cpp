// SPDX-License-Identifier: Apache-2.0
#include "model_surface.h"

#include <espalier/base/disjoint_sets.h>
#include <espalier/base/error.h>
#include <espalier/base/sort_unique.h>
#include <espalier/base/vector3.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace espalier::cages {
namespace {

bool isDegenerate(const Triangle& t) {
    return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

Triangle sorted(Triangle t) {
    std::sort(t.begin(), t.end());
    return t;
}

/// Turns a triangle so that its least corner comes first.
Triangle leastFirst(Triangle t) {
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    return t;
}

/// A side of a triangle.
struct Side {
    std::array<Index, 2> ends;  ///< ascending
    Index triangle = 0;
    bool isBackwards = false;  ///< if the triangle goes from the second end to the first

    friend bool operator<(const Side& a, const Side& b) {
        return std::pair(a.ends, a.triangle) < std::pair(b.ends, b.triangle);
    }
};

std::vector<Side> sidesOf(std::span<const Triangle> triangles) {
    std::vector<Side> sides;
    sides.reserve(3 * triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (std::size_t i = 0; i < 3; ++i) {
            const Index a = triangles[t][i], b = triangles[t][(i + 1) % 3];
            sides.push_back({{std::min(a, b), std::max(a, b)}, static_cast<Index>(t), b < a});
        }
    std::sort(sides.begin(), sides.end());
    return sides;
}

/// Calls visit(sides) for the sides of each edge.
template <class Visit>
void forEachEdge(std::span<const Side> sides, Visit visit) {
    for (std::size_t first = 0, last = 0; first < sides.size(); first = last) {
        while (last < sides.size() && sides[last].ends == sides[first].ends) ++last;
        visit(sides.subspan(first, last - first));
    }
}

double areaOf(const Triangle& t, std::span<const Point3> points) {
    return length(cross(difference(points[t[1]], points[t[0]]),
                        difference(points[t[2]], points[t[0]]))) /
           2;
}

}  // namespace

ModelSurface::ModelSurface(const SurfaceModel& model) {
    join(model);
    split();
}

void ModelSurface::join(const SurfaceModel& model) {
    std::size_t begin = 0;
    for (std::size_t face = 0; face < model.ends.size(); ++face) {
        if (model.ends[face] < begin || model.ends[face] > model.corners.size())
            throw Error(concat("cage: face ", face, " ends at corner ", model.ends[face],
                               "; expected ", begin, " to ", model.corners.size()));
        begin = model.ends[face];
    }
    for (std::size_t i = 0; i < model.points.size(); ++i)
        for (const double coordinate : model.points[i])
            if (!(std::abs(coordinate) <= 1e90))
                throw Error(concat(
                    "cage: point ", i,
                    std::isfinite(coordinate) ? " is too far from the origin" : " is not finite"));
    if (model.ends.empty()) throw Error("cage: the model has no faces");
    // Points at one place get one number. Adding 0 turns −0 into 0.
    std::vector<std::pair<Point3, Index>> keyed;
    keyed.reserve(model.points.size());
    for (std::size_t i = 0; i < model.points.size(); ++i)
        keyed.emplace_back(sum(model.points[i], {0, 0, 0}), static_cast<Index>(i));
    std::sort(keyed.begin(), keyed.end());
    std::vector<Index> numbers(model.points.size());
    for (const auto& [point, number] : keyed) {
        if (points_.empty() || points_.back() != point) points_.push_back(point);
        numbers[number] = static_cast<Index>(points_.size()) - 1;
    }
    modelPointCount_ = points_.size();

    std::vector<char> isUsed(points_.size(), 0);
    std::vector<Triangle> all;
    begin = 0;
    for (const std::size_t end : model.ends) {
        const auto corners = model.corners.subspan(begin, end - begin);
        begin = end;
        for (const Index corner : corners) {
            if (corner < 0 || corner >= std::ssize(model.points))
                throw Error(concat("cage: a face names point ", corner, "; expected 0 to ",
                                   std::ssize(model.points) - 1));
            isUsed[numbers[corner]] = 1;
        }
        for (std::size_t i = 1; i + 1 < std::max<std::size_t>(corners.size(), 3); ++i) {
            if (corners.empty()) break;
            const auto at = [&](std::size_t k) {
                return numbers[corners[std::min(k, corners.size() - 1)]];
            };
            const Triangle t = {at(0), at(i), at(i + 1)};
            all.push_back(isDegenerate(t) ? sorted(t) : leastFirst(t));
        }
    }
    for (std::size_t i = 0; i < points_.size(); ++i)
        if (isUsed[i] == 0) {
            const auto point = static_cast<Index>(i);
            all.push_back({point, point, point});
        }
    const auto key = [](const Triangle& t) { return std::pair(sorted(t), t); };
    std::sort(all.begin(), all.end(),
              [&](const Triangle& a, const Triangle& b) { return key(a) < key(b); });
    all.erase(
        std::unique(all.begin(), all.end(),
                    [](const Triangle& a, const Triangle& b) { return sorted(a) == sorted(b); }),
        all.end());
    triangles_ = std::move(all);
}

void ModelSurface::split() {
    std::vector<Triangle> proper;
    for (const Triangle& t : triangles_) (isDegenerate(t) ? openTriangles_ : proper).push_back(t);
    const std::vector<Side> sides = sidesOf(proper);
    // The neighbours of each triangle over edges of two triangles.
    struct Neighbour {
        Index triangle = -1;
        bool isOpposed = false;  ///< if the two triangles are wound differently
    };
    std::vector<std::array<Neighbour, 3>> neighbours(proper.size());
    std::vector<int> counts(proper.size(), 0);
    forEachEdge(sides, [&](std::span<const Side> edge) {
        if (edge.size() != 2) return;
        const bool isOpposed = edge[0].isBackwards == edge[1].isBackwards;
        for (const std::size_t i : {0, 1}) {
            const Index t = edge[i].triangle;
            neighbours[t][counts[t]++] = {edge[1 - i].triangle, isOpposed};
        }
    });
    std::vector<char> isTurned(proper.size(), 0), isReached(proper.size(), 0);
    std::vector<Index> members;
    std::vector<Triangle> piece;
    std::vector<char> turnedOf;
    for (std::size_t first = 0; first < proper.size(); ++first) {
        if (isReached[first] != 0) continue;
        members = {static_cast<Index>(first)};
        isReached[first] = 1;
        bool isOrientable = true;
        for (std::size_t i = 0; i < members.size(); ++i) {
            const Index t = members[i];
            for (int k = 0; k < counts[t]; ++k) {
                const auto& [next, isOpposed] = neighbours[t][k];
                const char turned = isOpposed ? 1 - isTurned[t] : isTurned[t];
                if (isReached[next] == 0) {
                    isReached[next] = 1;
                    isTurned[next] = turned;
                    members.push_back(next);
                } else if (isTurned[next] != turned) {
                    isOrientable = false;
                }
            }
        }
        std::sort(members.begin(), members.end());
        piece.clear();
        turnedOf.clear();
        for (const Index t : members) {
            piece.push_back(proper[t]);
            turnedOf.push_back(isTurned[t]);
        }
        addPiece(piece, turnedOf, isOrientable);
    }
    // A model that is inside out as a whole.
    double volume = 0;
    for (const ClosedPiece& closed : closedPieces_)
        volume += closed.isInward ? -closed.volume : closed.volume;
    if (volume < 0)
        for (ClosedPiece& closed : closedPieces_) closed.isInward = !closed.isInward;
}

void ModelSurface::addPiece(std::span<const Triangle> piece, std::span<const char> isTurned,
                            bool isOrientable) {
    const auto addOpen = [&] {
        openTriangles_.insert(openTriangles_.end(), piece.begin(), piece.end());
    };
    if (!isOrientable) return addOpen();
    ClosedPiece closed;
    double area = 0, turnedArea = 0;
    for (std::size_t i = 0; i < piece.size(); ++i) {
        Triangle t = piece[i];
        const double size = areaOf(t, points_);
        area += size;
        if (isTurned[i] != 0) {
            std::swap(t[1], t[2]);
            turnedArea += size;
        }
        closed.triangles.push_back(t);
    }
    if (turnedArea > area / 2)
        for (Triangle& t : closed.triangles) std::swap(t[1], t[2]);
    // The edges of the boundary, as many times as the piece runs along them.
    std::vector<std::array<Index, 2>> boundary;
    const std::vector<Side> sides = sidesOf(closed.triangles);
    forEachEdge(sides, [&](std::span<const Side> edge) {
        int total = 0;
        for (const Side& side : edge) total += side.isBackwards ? -1 : 1;
        for (; total > 0; --total) boundary.push_back(edge[0].ends);
        for (; total < 0; ++total) boundary.push_back({edge[0].ends[1], edge[0].ends[0]});
    });
    std::vector<Index> names;
    for (const auto& edge : boundary) names.insert(names.end(), edge.begin(), edge.end());
    sortUnique(names);
    DisjointSets groups(names.size());
    for (const auto& edge : boundary) groups.join(placeIn(names, edge[0]), placeIn(names, edge[1]));
    std::vector<Index> capOf(names.size(), -1), sizes;
    std::vector<Point3> apexes;
    for (std::size_t i = 0; i < names.size(); ++i) {
        Index& cap = capOf[groups.rootOf(i)];
        if (cap < 0) {
            cap = static_cast<Index>(apexes.size());
            apexes.push_back({0, 0, 0});
            sizes.push_back(0);
        }
        apexes[cap] = sum(apexes[cap], points_[names[i]]);
        ++sizes[cap];
    }
    for (std::size_t cap = 0; cap < apexes.size(); ++cap)
        apexes[cap] = scaled(apexes[cap], 1.0 / sizes[cap]);
    double capArea = 0;
    for (const auto& [a, b] : boundary) {
        const Point3& apex = apexes[capOf[groups.rootOf(placeIn(names, a))]];
        capArea += length(cross(difference(points_[a], apex), difference(points_[b], apex))) / 2;
    }
    if (!(capArea <= kMostOpen * area)) return addOpen();
    closed.capBegin = piece.size();
    const auto firstApex = static_cast<Index>(points_.size());
    for (const auto& [a, b] : boundary)
        closed.triangles.push_back({b, a, firstApex + capOf[groups.rootOf(placeIn(names, a))]});
    points_.insert(points_.end(), apexes.begin(), apexes.end());
    double volume = 0;
    const Point3& origin = points_[piece[0][0]];
    for (const Triangle& t : closed.triangles)
        volume += dot(difference(points_[t[0]], origin),
                      cross(difference(points_[t[1]], origin), difference(points_[t[2]], origin)));
    closed.volume = std::abs(volume) / 6;
    closed.isInward = volume < 0;
    if (closed.isInward)
        for (Triangle& t : closed.triangles) std::swap(t[1], t[2]);
    closedPieces_.push_back(std::move(closed));
}

}  // namespace espalier::cages

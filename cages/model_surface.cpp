// SPDX-License-Identifier: Apache-2.0
#include "model_surface.h"

#include <espalier/base/cancellable_sort.h>
#include <espalier/base/disjoint_sets.h>
#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/base/sort_unique.h>
#include <espalier/base/vector3.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace espalier::cages {
namespace {

bool isDegenerate(const Triangle& t) {
    return t[1] == t[2];
}

/// Returns a triangle wound the other way.
Triangle turned(const Triangle& t) {
    return {t[0], t[2], t[1]};
}

/// Returns the place in a loop from which its numbers are least, compared one by one. Two starts
/// compete: the one that loses a comparison moves behind the numbers that were equal.
/// \cost O(n)
std::size_t leastStart(std::span<const Index> loop) {
    const std::size_t n = loop.size();
    std::size_t a = 0, b = 1, equal = 0;
    while (a < n && b < n && equal < n) {
        const Index atA = loop[(a + equal) % n], atB = loop[(b + equal) % n];
        if (atA == atB) {
            ++equal;
            continue;
        }
        (atB < atA ? a : b) += equal + 1;
        if (a == b) ++b;
        equal = 0;
    }
    return std::min(a, b);
}

/// Makes the same loop of all loops that differ in their start and direction only. Removes corners
/// that repeat the corner before them.
/// \return true if the loop is turned around
bool makeCanonical(std::vector<Index>& loop) {
    loop.erase(std::unique(loop.begin(), loop.end()), loop.end());
    while (loop.size() > 1 && loop.front() == loop.back()) loop.pop_back();
    const auto start = [](std::vector<Index>& corners) {
        const auto first = static_cast<std::ptrdiff_t>(leastStart(corners));
        std::rotate(corners.begin(), corners.begin() + first, corners.end());
    };
    start(loop);
    std::vector<Index> backwards(loop.rbegin(), loop.rend());
    start(backwards);
    if (!(backwards < loop)) return false;
    loop = std::move(backwards);
    return true;
}

/// A triangle with ascending corners; a line has its higher end twice.
struct WoundTriangle {
    Triangle corners;
    int winding = 0;  ///< 1 or −1, as of ModelSurface::windings_; 0: a line or a point

    friend auto operator<=>(const WoundTriangle&, const WoundTriangle&) = default;
};

WoundTriangle woundTriangle(Triangle t, bool isTurned) {
    const bool isOdd = ((t[1] < t[0]) != (t[2] < t[1])) != (t[2] < t[0]);
    std::sort(t.begin(), t.end());
    if (t[0] == t[1]) t[1] = t[2];
    return {t, isDegenerate(t) ? 0 : isOdd == isTurned ? 1 : -1};
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
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        checkCancelledEvery(t, 16);
        for (std::size_t i = 0; i < 3; ++i) {
            const Index a = triangles[t][i], b = triangles[t][(i + 1) % 3];
            sides.push_back({{std::min(a, b), std::max(a, b)}, static_cast<Index>(t), b < a});
        }
    }
    sortCancellably(sides.begin(), sides.end());
    return sides;
}

/// Calls visit(sides) for the sides of each edge.
template <class Visit>
void forEachEdge(std::span<const Side> sides, Visit visit) {
    std::size_t edge = 0;
    for (std::size_t first = 0, last = 0; first < sides.size(); first = last) {
        checkCancelledEvery(edge++, 12);
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

ModelSurface::Sizes ModelSurface::sizes() const {
    Sizes sizes;
    for (const Triangle& t : triangles_) {
        sizes.area += areaOf(t, points_);
        for (std::size_t i = 0; i < 3; ++i)
            sizes.perimeter += length(difference(points_[t[(i + 1) % 3]], points_[t[i]]));
    }
    return sizes;
}

void ModelSurface::join(const SurfaceModel& model) {
    std::size_t begin = 0;
    for (std::size_t face = 0; face < model.ends.size(); ++face) {
        if (model.ends[face] < begin || model.ends[face] > model.corners.size())
            throw Error(concat("face ", face, " ends at corner ", model.ends[face], "; expected ",
                               begin, " to ", model.corners.size()));
        begin = model.ends[face];
    }
    for (std::size_t i = 0; i < model.points.size(); ++i)
        for (const double coordinate : model.points[i])
            if (!(std::abs(coordinate) <= 1e90))
                throw Error(concat(
                    "point ", i,
                    std::isfinite(coordinate) ? " is too far from the origin" : " is not finite"));
    if (model.ends.empty()) throw Error("the model has no faces");
    // Points at one place get one number. Adding 0 turns −0 into 0.
    std::vector<std::pair<Point3, Index>> keyed;
    keyed.reserve(model.points.size());
    for (std::size_t i = 0; i < model.points.size(); ++i)
        keyed.emplace_back(sum(model.points[i], {0, 0, 0}), static_cast<Index>(i));
    sortCancellably(keyed.begin(), keyed.end());
    std::vector<Index> numbers(model.points.size());
    for (const auto& [point, number] : keyed) {
        if (points_.empty() || points_.back() != point) points_.push_back(point);
        numbers[number] = static_cast<Index>(points_.size()) - 1;
    }
    modelPointCount_ = points_.size();

    std::vector<char> isUsed(points_.size(), 0);
    std::vector<WoundTriangle> all;
    std::vector<Index> loop;
    begin = 0;
    std::size_t face = 0;
    for (const std::size_t end : model.ends) {
        checkCancelledEvery(face++, 12);
        loop.clear();
        for (const Index corner : model.corners.subspan(begin, end - begin)) {
            if (corner < 0 || corner >= std::ssize(model.points))
                throw Error(concat("a face names point ", corner, "; expected 0 to ",
                                   std::ssize(model.points) - 1));
            loop.push_back(numbers[corner]);
            isUsed[numbers[corner]] = 1;
        }
        begin = end;
        if (loop.empty()) continue;
        const bool isTurned = makeCanonical(loop);
        const std::size_t last = loop.size() - 1;
        for (std::size_t i = 1; i < std::max<std::size_t>(last, 2); ++i)
            all.push_back(woundTriangle(
                {loop[0], loop[std::min(i, last)], loop[std::min(i + 1, last)]}, isTurned));
    }
    for (std::size_t i = 0; i < points_.size(); ++i)
        if (isUsed[i] == 0) {
            const auto point = static_cast<Index>(i);
            all.push_back({{point, point, point}, 0});
        }
    sortCancellably(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    for (const WoundTriangle& triangle : all) {
        if (triangles_.empty() || triangles_.back() != triangle.corners) {
            triangles_.push_back(triangle.corners);
            windings_.push_back(0);
        }
        windings_.back() += triangle.winding;
    }
}

void ModelSurface::split() {
    std::vector<Triangle> proper;
    std::vector<int> windings;
    std::vector<char> isCorner(points_.size(), 0);
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
        const Triangle& t = triangles_[i];
        if (isDegenerate(t)) continue;
        proper.push_back(t);
        windings.push_back(windings_[i]);
        for (const Index corner : t) isCorner[corner] = 1;
    }
    const std::vector<Side> sides = sidesOf(proper);
    // Lines first: a point at the end of a line is not needed.
    const auto addLoose = [&](bool isLine) {
        for (const Triangle& t : triangles_) {
            if (!isDegenerate(t) || (t[0] != t[1]) != isLine) continue;
            const std::array<Index, 2> ends = {t[0], t[1]};
            if (isLine ? std::ranges::binary_search(sides, ends, {}, &Side::ends)
                       : isCorner[t[0]] != 0)
                continue;
            openTriangles_.push_back(t);
            for (const Index corner : t) isCorner[corner] = 1;
        }
    };
    addLoose(true);
    addLoose(false);
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
    std::vector<int> windingsOf;
    for (std::size_t first = 0; first < proper.size(); ++first) {
        checkCancelledEvery(first, 12);
        if (isReached[first] != 0) continue;
        members = {static_cast<Index>(first)};
        isReached[first] = 1;
        bool isOrientable = true;
        for (std::size_t i = 0; i < members.size(); ++i) {
            checkCancelledEvery(i, 12);
            const Index t = members[i];
            for (int k = 0; k < counts[t]; ++k) {
                const auto& [next, isOpposed] = neighbours[t][k];
                const char isNextTurned = isOpposed ? 1 - isTurned[t] : isTurned[t];
                if (isReached[next] == 0) {
                    isReached[next] = 1;
                    isTurned[next] = isNextTurned;
                    members.push_back(next);
                } else if (isTurned[next] != isNextTurned) {
                    isOrientable = false;
                }
            }
        }
        sortCancellably(members.begin(), members.end());
        piece.clear();
        windingsOf.clear();
        for (const Index t : members) {
            piece.push_back(isTurned[t] != 0 ? turned(proper[t]) : proper[t]);
            windingsOf.push_back(isTurned[t] != 0 ? -windings[t] : windings[t]);
        }
        if (isOrientable && addClosed(piece, windingsOf)) continue;
        for (const Index t : members) openTriangles_.push_back(proper[t]);
    }
    // The model may be inside out as a whole.
    double volume = 0;
    int firstWinding = 0;  // decides if the volumes cancel
    for (const ClosedPiece& closed : closedPieces_) {
        volume += closed.winding * closed.volume;
        if (firstWinding == 0) firstWinding = closed.winding;
    }
    if (volume < 0 || (volume == 0 && firstWinding < 0))
        for (ClosedPiece& closed : closedPieces_) closed.winding = -closed.winding;
}

/// Adds a piece, if little area closes it.
/// \param piece triangles that are all wound one way round
/// \param windings of each triangle of `piece`: 1 if the model winds it in this way, −1 the other
///        way, 0 both ways
bool ModelSurface::addClosed(std::span<const Triangle> piece, std::span<const int> windings) {
    ClosedPiece closed;
    closed.triangles.assign(piece.begin(), piece.end());
    double area = 0, along = 0, against = 0;
    for (std::size_t i = 0; i < piece.size(); ++i) {
        const double size = areaOf(piece[i], points_);
        area += size;
        if (windings[i] > 0) along += size;
        if (windings[i] < 0) against += size;
    }
    closed.winding = along > against ? 1 : along < against ? -1 : 0;
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
    for (const auto& edge : boundary) groups.join(indexIn(names, edge[0]), indexIn(names, edge[1]));
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
        const Point3& apex = apexes[capOf[groups.rootOf(indexIn(names, a))]];
        capArea += length(cross(difference(points_[a], apex), difference(points_[b], apex))) / 2;
    }
    if (!(capArea <= kMostOpen * area)) return false;
    closed.capBegin = piece.size();
    const auto firstApex = static_cast<Index>(points_.size());
    for (const auto& [a, b] : boundary)
        closed.triangles.push_back({b, a, firstApex + capOf[groups.rootOf(indexIn(names, a))]});
    points_.insert(points_.end(), apexes.begin(), apexes.end());
    double volume = 0;
    const Point3& origin = points_[piece[0][0]];
    for (const Triangle& t : closed.triangles)
        volume += dot(difference(points_[t[0]], origin),
                      cross(difference(points_[t[1]], origin), difference(points_[t[2]], origin)));
    closed.volume = std::abs(volume) / 6;
    if (volume < 0) {
        closed.winding = -closed.winding;
        for (Triangle& t : closed.triangles) t = turned(t);
    }
    closedPieces_.push_back(std::move(closed));
    return true;
}

}  // namespace espalier::cages

// SPDX-License-Identifier: Apache-2.0
#include "shared_points.h"

#include <espalier/base/cancellable_sort.h>
#include <espalier/base/error.h>
#include <espalier/base/progress.h>

#include <cmath>
#include <cstddef>

namespace espalier::io {
namespace {

/// A point of a part.
struct Occurrence {
    Point3 place;
    std::size_t part;
    Index point;
};

/// Compares coordinates. All numbers that are not finite are equal, and so are 0 and -0.
int compare(const Point3& a, const Point3& b) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const bool isFinite = std::isfinite(a[axis]), isOtherFinite = std::isfinite(b[axis]);
        if (isFinite != isOtherFinite) return isFinite ? -1 : 1;
        if (isFinite && a[axis] != b[axis]) return a[axis] < b[axis] ? -1 : 1;
    }
    return 0;
}

}  // namespace

SharedPoints findSharedPoints(std::span<const std::span<const Point3>> parts) {
    std::vector<Occurrence> all;
    std::size_t total = 0;
    for (const auto& points : parts) total += points.size();
    if (std::cmp_greater(total, kMaxIndex))
        throw Error(
            concat("has ", total, " points in its parts; at most ", kMaxIndex, " can be read"));
    all.reserve(total);
    for (std::size_t part = 0; part < parts.size(); ++part)
        for (std::size_t point = 0; point < parts[part].size(); ++point)
            all.push_back({parts[part][point], part, static_cast<Index>(point)});
    sortCancellably(all.begin(), all.end(), [](const Occurrence& a, const Occurrence& b) {
        if (const int order = compare(a.place, b.place); order != 0) return order < 0;
        return a.part != b.part ? a.part < b.part : a.point < b.point;
    });

    // The first occurrence of each point of the mesh stands for it.
    struct First {
        std::size_t part;
        Index point;
    };
    std::vector<std::vector<First>> firsts(parts.size());
    for (std::size_t part = 0; part < parts.size(); ++part) firsts[part].resize(parts[part].size());
    std::vector<First> atPlace;
    std::size_t rank = 0;  // among the points of one part at one place
    for (std::size_t i = 0; i < all.size(); ++i) {
        checkCancelledEvery(i, 16);
        const Occurrence& each = all[i];
        if (i == 0 || compare(all[i - 1].place, each.place) != 0) {
            atPlace.clear();
            rank = 0;
        } else {
            rank = all[i - 1].part == each.part ? rank + 1 : 0;
        }
        if (rank == atPlace.size()) atPlace.push_back({each.part, each.point});
        firsts[each.part][each.point] = atPlace[rank];
    }

    SharedPoints result;
    result.numbers.resize(parts.size());
    for (std::size_t part = 0; part < parts.size(); ++part)
        for (std::size_t point = 0; point < parts[part].size(); ++point) {
            const First& first = firsts[part][point];
            const bool isNew = first.part == part && std::cmp_equal(first.point, point);
            result.numbers[part].push_back(isNew ? result.count++
                                                 : result.numbers[first.part][first.point]);
        }
    return result;
}

}  // namespace espalier::io

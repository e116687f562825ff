// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/parallel.h>
#include <espalier/embed/box_tree.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

namespace espalier::embed {

using Eigen::Vector3d;

namespace {

/// The fastest to query among 2, 4, 8 and 16.
constexpr Index kLeafSize = 8;

/// Without a branch per side: which side fails first is unpredictable.
bool meets(const BoxTree::Box& a, const BoxTree::Box& b) {
    const auto isAtMost = [](double low, double high) {
        return static_cast<unsigned>(low <= high);
    };
    unsigned isMet = 1;
    for (Eigen::Index axis = 0; axis < 3; ++axis)
        isMet &= isAtMost(a.min()[axis], b.max()[axis]) & isAtMost(b.min()[axis], a.max()[axis]);
    return isMet != 0;
}

bool contains(const BoxTree::Box& box, const Vector3d& point) {
    return meets(box, {point, point});
}

/// Returns the box around some points. Coordinates that are no numbers do not count.
BoxTree::Box boxAround(std::span<const Point3> points) {
    BoxTree::Box box;
    for (const Point3& point : points)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto at = static_cast<Eigen::Index>(axis);
            // The arguments are in the order in which a NaN is not taken.
            box.min()[at] = std::min(box.min()[at], point[axis]);
            box.max()[at] = std::max(box.max()[at], point[axis]);
        }
    return box;
}

/// Returns how many of some sorted places go to the left child: those whose key lacks the highest
/// bit in which the keys differ. There must be at least two places.
Index leftCount(std::span<const CurveItem> places) {
    const std::uint64_t differing = places.front().key ^ places.back().key;
    if (differing == 0) return static_cast<Index>(places.size() / 2);
    const std::uint64_t bit = std::bit_floor(differing);
    const auto right =
        std::partition_point(places.begin(), places.end(),
                             [&](const CurveItem& place) { return (place.key & bit) == 0; });
    return static_cast<Index>(right - places.begin());
}

}  // namespace

BoxTree::BoxTree(std::span<const Box> boxes) {
    // In the order of the curve, a node's items are consecutive and in one part of space, so that
    // splitting moves nothing. This takes a sixth of the time of splits at the median.
    Box all;
    for (const Box& box : boxes) all.extend(box);
    const MortonCurve curve(all);
    Array<CurveItem> places(boxes.size());
    parallelFor(static_cast<Offset>(boxes.size()), 4096, [&](Offset first, Offset last) {
        for (Offset i = first; i < last; ++i) {
            places[i] = {curve.key(boxes[i].center()), static_cast<Index>(i)};
        }
    });
    sortAlongCurve(places);
    nodes_.reserve(boxes.size() / 2);
    order_.reserve(boxes.size());
    boxes_.reserve(boxes.size());
    for (const CurveItem& place : places) {
        order_.push_back(place.item);
        boxes_.push_back(boxes[place.item]);
    }
    if (!places.empty()) build(places, 0, static_cast<Index>(places.size()));
}

void BoxTree::build(std::span<const CurveItem> places, Index first, Index count) {
    const std::size_t at = nodes_.size();
    nodes_.emplace_back();
    Box box;
    if (count <= kLeafSize) {
        for (Index i = first; i < first + count; ++i) box.extend(boxes_[i]);
        nodes_[at] = {box, first, count, 1};
        return;
    }
    const Index left = leftCount(places.subspan(first, count));
    build(places, first, left);
    box.extend(nodes_[at + 1].box);
    const std::size_t right = nodes_.size();
    build(places, first + left, count - left);
    box.extend(nodes_[right].box);
    nodes_[at] = {box, 0, 0, static_cast<Index>(nodes_.size() - at)};
}

/// Calls use(i) for each boxes_[i] that satisfies isIn, which must also hold for every box around
/// such a box.
template <class IsIn, class Use>
void BoxTree::forEach(IsIn isIn, Use use) const {
    for (std::size_t at = 0; at < nodes_.size();) {
        const Node& node = nodes_[at];
        const bool enters = isIn(node.box);
        if (enters)
            for (Index i = node.first; i < node.first + node.count; ++i)
                if (isIn(boxes_[i])) use(i);
        at += enters ? 1 : node.size;
    }
}

void BoxTree::findContaining(const Vector3d& point, std::vector<Index>& found) const {
    forEach([&](const Box& box) { return contains(box, point); },
            [&](Index i) { found.push_back(order_[i]); });
}

void BoxTree::findContaining(std::span<const Point3> points,
                             FunctionRef<void(std::size_t, std::span<const Index>)> use) const {
    // The boxes that meet the box of some points are tested for each of these points. The number of
    // points is such that these boxes are few.
    constexpr std::size_t kMaxPoints = 64, kMaxNear = 64;
    std::vector<Index> near;
    std::vector<Box> nearBoxes;
    std::vector<Index> found;
    std::size_t count = 1;
    for (std::size_t first = 0; first < points.size();) {
        count = std::min(count, points.size() - first);
        const auto some = points.subspan(first, count);
        near.clear();
        const Box around = boxAround(some);
        forEach([&](const Box& box) { return meets(box, around); },
                [&](Index i) { near.push_back(i); });
        if (near.size() > kMaxNear && count > 1) {
            count /= 2;
            continue;
        }
        std::sort(near.begin(), near.end(),
                  [&](Index i, Index k) { return order_[i] < order_[k]; });
        nearBoxes.clear();
        for (const Index i : near) nearBoxes.push_back(boxes_[i]);
        for (const Point3& p : some) {
            const Vector3d point(p.data());
            found.clear();
            for (std::size_t k = 0; k < near.size(); ++k)
                if (contains(nearBoxes[k], point)) found.push_back(order_[near[k]]);
            use(first++, found);
        }
        if (near.size() <= kMaxNear / 2) count = std::min(2 * count, kMaxPoints);
    }
}

void BoxTree::findWithin(const Vector3d& point, double distance, std::vector<Index>& found) const {
    forEach([&](const Box& box) { return !(box.exteriorDistance(point) > distance); },
            [&](Index i) { found.push_back(order_[i]); });
}

BoxTree::Nearest BoxTree::findNearest(const Vector3d& point,
                                      const std::function<double(Index)>& distance) const {
    Nearest best{0, std::numeric_limits<double>::infinity()};
    const auto boxDistance = [&](std::size_t node) {
        return nodes_[node].box.exteriorDistance(point);
    };
    std::vector<std::pair<double, std::size_t>> stack;
    if (!nodes_.empty()) stack.emplace_back(boxDistance(0), 0);
    while (!stack.empty()) {
        const auto [lowerBound, at] = stack.back();
        stack.pop_back();
        // An equal bound may still hide an item of lower index.
        if (lowerBound > best.distance) continue;
        const Node& node = nodes_[at];
        if (node.isLeaf()) {
            for (Index i = node.first; i < node.first + node.count; ++i) {
                if (boxes_[i].exteriorDistance(point) > best.distance) continue;
                const Index item = order_[i];
                const double d = distance(item);
                if (std::pair(d, item) < std::pair(best.distance, best.index)) best = {item, d};
            }
            continue;
        }
        // Push the nearer child last, so that it is visited first.
        const std::size_t second = at + 1 + nodes_[at + 1].size;
        std::pair left(boxDistance(at + 1), at + 1), right(boxDistance(second), second);
        if (left.first < right.first) std::swap(left, right);
        stack.push_back(left);
        stack.push_back(right);
    }
    return best;
}

}  // namespace espalier::embed

// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/parallel.h>
#include <espalier/stencils/box_tree.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace espalier::stencils {

using far::Index;

namespace {

constexpr Index kLeafSize = 4;

/// Nodes of a tree over `count` items: it is split at the middle, so its shape depends on the
/// number alone.
std::size_t nodeCount(Index count) {
    return count <= kLeafSize ? 1 : 1 + nodeCount(count / 2) + nodeCount(count - count / 2);
}

}  // namespace

BoxTree::BoxTree(std::span<const Box> boxes) : order_(boxes.size()) {
    if (boxes.empty()) return;
    std::iota(order_.begin(), order_.end(), Index{0});
    nodes_.resize(nodeCount(static_cast<Index>(boxes.size())));
    build(boxes, 0, static_cast<Index>(boxes.size()), 0, nodes_.size());
    boxes_.reserve(boxes.size());
    for (const Index item : order_) boxes_.push_back(boxes[static_cast<std::size_t>(item)]);
}

void BoxTree::build(std::span<const Box> boxes, Index first, Index count, std::size_t at,
                    std::size_t next) {
    const auto items =
        std::span(order_).subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(count));
    const auto boxOf = [&](Index item) -> const Box& {
        return boxes[static_cast<std::size_t>(item)];
    };
    Box box, centres;
    for (const Index item : items) {
        box.extend(boxOf(item));
        centres.extend(boxOf(item).center());
    }
    Node& node = nodes_[at];
    node = {box, first, count, 0, next, count <= kLeafSize};
    if (node.isLeaf) return;

    Eigen::Index axis = 0;
    centres.sizes().maxCoeff(&axis);
    const Index half = count / 2;
    std::nth_element(items.begin(), items.begin() + half, items.end(), [&](Index a, Index b) {
        // Twice the centre will do. Ties by index: the order must not depend on the library.
        const double centreA = boxOf(a).min()[axis] + boxOf(a).max()[axis];
        const double centreB = boxOf(b).min()[axis] + boxOf(b).max()[axis];
        return std::pair(centreA, a) < std::pair(centreB, b);
    });
    const std::size_t right = at + 1 + nodeCount(half);
    node.right = right;
    // Small trees are not worth a task.
    constexpr Index kTaskSize = 20000;
    const std::array<std::function<void()>, 2> halves = {
        [&] { build(boxes, first, half, at + 1, right); },
        [&] { build(boxes, first + half, count - half, right, next); }};
    if (count < kTaskSize) {
        for (const auto& buildHalf : halves) buildHalf();
    } else {
        far::parallelFor(2, 1, [&](far::Offset half0, far::Offset half1) {
            for (far::Offset i = half0; i < half1; ++i) halves[static_cast<std::size_t>(i)]();
        });
    }
}

void BoxTree::findContaining(const Eigen::Vector3d& point, std::vector<Index>& found) const {
    for (std::size_t at = 0; at < nodes_.size();) {
        const Node& node = nodes_[at];
        const bool enters = node.box.contains(point);
        if (enters && node.isLeaf)
            for (Index i = node.first; i < node.first + node.count; ++i)
                if (boxes_[static_cast<std::size_t>(i)].contains(point))
                    found.push_back(order_[static_cast<std::size_t>(i)]);
        at = enters ? at + 1 : node.next;
    }
}

BoxTree::Nearest BoxTree::findNearest(const Eigen::Vector3d& point,
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
        if (node.isLeaf) {
            for (Index i = node.first; i < node.first + node.count; ++i) {
                if (boxes_[static_cast<std::size_t>(i)].exteriorDistance(point) > best.distance)
                    continue;
                const Index item = order_[static_cast<std::size_t>(i)];
                const double d = distance(item);
                if (std::pair(d, item) < std::pair(best.distance, best.index)) best = {item, d};
            }
            continue;
        }
        // The nearer child last, so that it is looked into first.
        std::pair left(boxDistance(at + 1), at + 1), right(boxDistance(node.right), node.right);
        if (left.first < right.first) std::swap(left, right);
        stack.push_back(left);
        stack.push_back(right);
    }
    return best;
}

}  // namespace espalier::stencils

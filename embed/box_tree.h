// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/array.h>
#include <espalier/base/function_ref.h>
#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/embed/space_curve.h>

#include <Eigen/Geometry>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace espalier::embed {

/// Finds the boxes that contain a point, and the item nearest to a point, by a bounding-volume
/// tree. Immutable once built; any number of threads may use it at once.
class ESPALIER_API BoxTree {
public:
    using Box = Eigen::AlignedBox<double, 3>;

    /// \cost O(n): 0.06 s for 500,000 boxes on one thread
    explicit BoxTree(std::span<const Box> boxes);

    /// Appends the indices of the boxes that contain `point`, in no particular order.
    void findContaining(const Eigen::Vector3d& point, std::vector<Index>& found) const;

    /// The same for many points: calls use(i, found) for each points[i]; `found` are the indices of
    /// the boxes that contain it, ascending. Points that are each near the one before share a
    /// search of the tree.
    void findContaining(std::span<const Point3> points,
                        FunctionRef<void(std::size_t i, std::span<const Index> found)> use) const;

    /// Appends the indices of the boxes whose distance from `point` is at most `distance`.
    void findWithin(const Eigen::Vector3d& point, double distance, std::vector<Index>& found) const;

    struct Nearest {
        Index index = 0;
        double distance = 0;
    };

    /// Returns the item nearest to `point`; among equally near items, the lowest index.
    /// \param distance returns the distance of an item from the point; it must be at least the
    ///        distance of the item's box
    Nearest findNearest(const Eigen::Vector3d& point,
                        const std::function<double(Index)>& distance) const;

private:
    /// Nodes are stored in depth-first order: the left child follows its parent, and the right
    /// child follows the whole left subtree. A leaf has the items first to first + count; an inner
    /// node has count 0.
    struct Node {
        Box box;
        Index first = 0;
        Index count = 0;
        Index size = 1;  ///< number of nodes of the subtree

        bool isLeaf() const { return count > 0; }
    };

    template <class IsIn, class Use>
    void forEach(IsIn isIn, Use use) const;
    void build(std::span<const CurveItem> places, Index first, Index count);

    Array<Node> nodes_;
    Array<Index> order_;  ///< the items, leaf after leaf
    Array<Box> boxes_;    ///< boxes_[i] is the box of order_[i]
};

}  // namespace espalier::embed

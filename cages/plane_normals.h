// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/base/vector3.h>

#include <array>
#include <cstddef>

namespace espalier::cages {

/// The planes that a vertex must stay in, by up to three orthonormal vectors that span their
/// normals. None: the vertex may move anywhere; three: it may not move.
class PlaneNormals {
public:
    /// Adds a plane. A plane that is parallel to the intersection of the others changes nothing.
    /// \param normal of length 1
    void add(const Point3& normal) {
        constexpr double kParallel = 1e-6;
        // The second pass removes the rounding errors of the first.
        const Point3 rest = inPlanes(inPlanes(normal));
        if (count_ < normals_.size() && dot(rest, rest) > kParallel * kParallel)
            normals_[count_++] = normalised(rest);
    }

    /// Returns the part of a vector that is in all planes.
    Point3 inPlanes(Point3 vector) const {
        for (std::size_t i = 0; i < count_; ++i)
            vector = difference(vector, scaled(normals_[i], dot(vector, normals_[i])));
        return vector;
    }

private:
    std::array<Point3, 3> normals_ = {};
    std::size_t count_ = 0;
};

}  // namespace espalier::cages

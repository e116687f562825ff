// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/io/directions.h>
#include <espalier/io/model.h>

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace espalier::io {

/// The points of a model that are not finite. Some programs write NaN for points that they do not
/// use. Such a point stays as it is in the file, and a finite point stands in for it in
/// Model::positions().
class HeldPoints {
public:
    /// Replaces each point that is not finite by the first finite one.
    explicit HeldPoints(std::span<Point3> points);

    /// Model::heldPoints().
    std::vector<Index> numbers() const;

    bool empty() const { return points_.empty(); }

    /// Returns a held point that must not be: a corner of a face or a cell with finite corners; or
    /// any, if no point is finite. Returns nothing if all may be held.
    /// \param model whose positions have the stand-ins
    /// \throws as Model::readSurface() and Model::readCells()
    std::optional<Index> findUsed(const Model& model) const;

    /// Puts the numbers of the file back.
    /// \param points all points of the model
    void restore(std::span<Point3> points) const;

    /// Returns new positions, in which the held points stay at their stand-ins.
    std::vector<Point3> held(std::span<const Point3> moved) const;

    /// Returns gradients, which are the identity at held points.
    std::vector<DeformationGradient> held(std::span<const DeformationGradient> gradients) const;

    /// Returns "kept 2 points that are not finite and in no face (the first is point 17)".
    std::string note() const;

private:
    struct Held {
        std::size_t point;
        Point3 inFile;
    };

    /// Returns the held point of a face with held and other corners.
    std::optional<Index> findMixed(std::span<const Index> face) const;

    std::vector<Held> points_;  ///< ascending
    std::vector<bool> isHeld_;  ///< one per point of the model
    std::optional<Point3> standIn_;
};

}  // namespace espalier::io

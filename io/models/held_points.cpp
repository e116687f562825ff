// SPDX-License-Identifier: Apache-2.0
#include "held_points.h"

#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/base/vector3.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace espalier::io {
namespace {}  // namespace

HeldPoints::HeldPoints(std::span<Point3> points) {
    for (std::size_t i = 0; i < points.size(); ++i) {
        checkCancelledEvery(i, 16);
        if (!isFinite(points[i]))
            points_.push_back({i, points[i]});
        else if (!standIn_)
            standIn_ = points[i];
    }
    if (empty()) return;
    isHeld_.resize(points.size());
    for (const Held& held : points_) {
        isHeld_[held.point] = true;
        points[held.point] = standIn_.value_or(Point3{});
    }
}

std::vector<Index> HeldPoints::numbers() const {
    std::vector<Index> numbers;
    numbers.reserve(points_.size());
    for (const Held& held : points_) numbers.push_back(static_cast<Index>(held.point));
    return numbers;
}

std::optional<Index> HeldPoints::findUsed(const Model& model) const {
    if (empty()) return std::nullopt;
    if (!standIn_) return static_cast<Index>(points_.front().point);
    const ModelSurface surface = model.readSurface();
    if (surface.dropsLoosePoints) {
        // Points at one place are one corner in the faces: facets are looked at as they are
        // written.
        for (Index point = 0; point + 2 < std::ssize(isHeld_); point += 3)
            if (const auto used = findMixed(std::array{point, point + 1, point + 2})) return used;
        return std::nullopt;
    }
    for (std::size_t face = 0; face < surface.faces.count(); ++face)
        if (const auto used = findMixed(surface.faces[face])) return used;
    const ModelCells cells = model.readCells();
    for (Index face = 0; face < cells.volume.faceCount(); ++face)
        if (const auto used = findMixed(cells.volume.face(face))) return used;
    // The points between the corners of cells and faces of second order.
    for (Index cell = 0; cell < cells.volume.cellCount(); ++cell)
        if (const auto used = findMixed(cells.volume.points(cell))) return used;
    for (Index face = 0; face < cells.surface.faceCount(); ++face)
        if (const auto used = findMixed(cells.surface.points(face))) return used;
    // Shapes that are not read may use any point.
    const bool isReadInFull = cells.curvedCells == 0 && cells.curvedFaces == 0 &&
                              cells.unknownElements == 0 &&
                              (surface.otherShapes.empty() || cells.cellCount() > 0);
    if (isReadInFull) return std::nullopt;
    return static_cast<Index>(points_.front().point);
}

std::optional<Index> HeldPoints::findMixed(std::span<const Index> face) const {
    const auto isHeld = [&](Index point) { return bool(isHeld_[point]); };
    const auto held = std::ranges::find_if(face, isHeld);
    if (held == face.end() || std::ranges::all_of(face, isHeld)) return std::nullopt;
    return *held;
}

void HeldPoints::restore(std::span<Point3> points) const {
    for (const Held& held : points_) points[held.point] = held.inFile;
}

std::vector<Point3> HeldPoints::held(std::span<const Point3> moved) const {
    std::vector<Point3> result(moved.begin(), moved.end());
    for (const Held& held : points_) result[held.point] = *standIn_;
    return result;
}

std::vector<DeformationGradient> HeldPoints::held(
    std::span<const DeformationGradient> gradients) const {
    std::vector<DeformationGradient> result(gradients.begin(), gradients.end());
    for (const Held& held : points_)
        if (!result.empty()) result[held.point] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    return result;
}

std::string HeldPoints::note() const {
    const bool isOne = points_.size() == 1;
    return concat("kept ", points_.size(),
                  isOne ? " point that is not finite and in no face (point "
                        : " points that are not finite and in no face (the first is point ",
                  points_.front().point, ")");
}

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>

#include <limits>

#include "mesh_centres.h"

namespace espalier::solve {

FaceCentre faceCentre(std::span<const Index> loop, std::span<const Point3> positions,
                      std::vector<double>* weights) {
    const std::size_t size = loop.size();
    const double count = static_cast<double>(size);
    // All points relative to the first, so that a face far from the origin loses no digits.
    const Point3& origin = positions[loop[0]];
    const auto at = [&](std::size_t i) { return difference(positions[loop[i % size]], origin); };
    Point3 middle{};
    for (std::size_t i = 1; i < size; ++i) middle = sum(middle, at(i));
    middle = scaled(middle, 1 / count);
    if (weights) weights->assign(size, 1 / count);
    if (size == 3) return {sum(origin, middle), scaled(cross(at(1), at(2)), 0.5)};

    Point3 area{}, moment{};
    double total = 0;
    const auto normal = [&](std::size_t i) {
        return cross(difference(at(i + 1), at(i)), difference(middle, at(i)));
    };
    for (std::size_t i = 0; i < size; ++i) {
        const Point3 twice = normal(i);
        const double share = length(twice);
        if (weights) (*weights)[i] = share;
        area = sum(area, scaled(twice, 0.5));
        moment = sum(moment, scaled(sum(sum(at(i), at(i + 1)), middle), share / 3));
        total += share;
    }
    if (!(total > std::numeric_limits<double>::min())) {
        if (weights) weights->assign(size, 1 / count);
        return {sum(origin, middle), {0, 0, 0}};
    }
    if (weights) {
        // A point gets a third of the weight of each of its two triangles, and of the middle.
        const double last = weights->back() / (3 * total);
        double before = 0;
        for (std::size_t i = 0; i < size; ++i) {
            const double third = (*weights)[i] / (3 * total);
            (*weights)[i] = 1 / (3 * count) + before + third;
            before = third;
        }
        weights->front() += last;
    }
    return {sum(origin, scaled(moment, 1 / total)), area};
}

CellCentre cellCentre(const far::VolumeMesh& mesh, Index cell, std::span<const Point3> centres,
                      std::span<const Point3> areas, std::vector<double>* weights) {
    const auto faces = mesh.faces(cell);
    const double count = static_cast<double>(faces.size());
    if (weights) weights->assign(faces.size(), 1 / count);
    if (faces.empty()) return {{0, 0, 0}, 0};
    const Point3& origin = centres[faces[0]];
    const auto at = [&](Index face) { return difference(centres[face], origin); };
    Point3 middle{};
    for (const Index face : faces) middle = sum(middle, scaled(at(face), 1 / count));
    const auto volumeOf = [&](Index face) {
        const double volume = dot(areas[face], difference(at(face), middle)) / 3;
        return mesh.owner(face) == cell ? volume : -volume;
    };
    Point3 moment{};
    double volume = 0;
    for (const Index face : faces) {
        const double part = volumeOf(face);
        volume += part;
        moment = sum(moment, scaled(sum(scaled(at(face), 0.75), scaled(middle, 0.25)), part));
    }
    if (!(std::abs(volume) > std::numeric_limits<double>::min()))
        return {sum(origin, middle), volume};
    if (weights)
        for (std::size_t i = 0; i < faces.size(); ++i)
            (*weights)[i] = 0.75 * volumeOf(faces[i]) / volume + 0.25 / count;
    return {sum(origin, scaled(moment, 1 / volume)), volume};
}

}  // namespace espalier::solve

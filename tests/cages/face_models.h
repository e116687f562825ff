// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/vector3.h>
#include <espalier/cages/cage.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <numeric>
#include <random>
#include <span>
#include <utility>
#include <vector>

// Models of faces to make cages of.
namespace espalier::test {

/// A model that owns its points and faces.
struct FaceModel {
    std::vector<Point3> points;
    std::vector<Index> corners = {};
    std::vector<std::size_t> ends = {};

    operator cages::SurfaceModel() const { return {points, corners, ends}; }

    void addFace(std::initializer_list<Index> loop) {
        corners.insert(corners.end(), loop);
        ends.push_back(corners.size());
    }
    std::span<Index> face(std::size_t number) {
        const std::size_t begin = number == 0 ? 0 : ends[number - 1];
        return std::span(corners).subspan(begin, ends[number] - begin);
    }
};

/// A sphere of 8 · 4^rounds triangles, wound anticlockwise from outside, stretched by `radii`.
inline FaceModel ballModel(int rounds, const Point3& radii = {1, 1, 1},
                           const Point3& centre = {0, 0, 0}) {
    std::vector<std::array<Point3, 3>> triangles;
    for (unsigned octant = 0; octant < 8; ++octant) {
        std::array<Point3, 3> t = {};
        for (unsigned axis = 0; axis < 3; ++axis) t[axis][axis] = (octant >> axis & 1) ? -1 : 1;
        if (std::popcount(octant) % 2 == 1) std::swap(t[1], t[2]);
        triangles.push_back(t);
    }
    for (int round = 0; round < rounds; ++round) {
        std::vector<std::array<Point3, 3>> finer;
        for (const auto& [a, b, c] : triangles) {
            const Point3 ab = normalised(sum(a, b)), bc = normalised(sum(b, c)),
                         ca = normalised(sum(c, a));
            finer.push_back({a, ab, ca});
            finer.push_back({ab, b, bc});
            finer.push_back({ca, bc, c});
            finer.push_back({ab, bc, ca});
        }
        triangles = finer;
    }
    // Each triangle has corners of its own: models may leave it to the cage to join them.
    FaceModel model;
    for (const auto& t : triangles) {
        const auto first = static_cast<Index>(model.points.size());
        for (const Point3& corner : t) {
            Point3 p = centre;
            for (int axis = 0; axis < 3; ++axis) p[axis] += radii[axis] * corner[axis];
            model.points.push_back(p);
        }
        model.addFace({first, first + 1, first + 2});
    }
    return model;
}

/// A ring of quadrilaterals around the z axis.
inline FaceModel ringModel(double radius, double thickness, int around = 40, int sides = 12) {
    FaceModel model;
    for (int i = 0; i < around; ++i)
        for (int k = 0; k < sides; ++k) {
            const double a = 2 * std::numbers::pi * i / around,
                         b = 2 * std::numbers::pi * k / sides;
            const double r = radius + thickness * std::cos(b);
            model.points.push_back({r * std::cos(a), r * std::sin(a), thickness * std::sin(b)});
            const int i2 = (i + 1) % around, k2 = (k + 1) % sides;
            model.addFace({i * sides + k, i2 * sides + k, i2 * sides + k2, i * sides + k2});
        }
    return model;
}

/// A wavy sheet of quadrilaterals.
inline FaceModel sheetModel() {
    FaceModel model;
    constexpr int kCount = 24;
    for (int i = 0; i < kCount; ++i)
        for (int k = 0; k < kCount; ++k) {
            const double u = -1.5 + 3.0 * i / (kCount - 1), v = -1 + 2.0 * k / (kCount - 1);
            model.points.push_back({u, v, 0.3 * std::sin(2 * u) * std::cos(v)});
            const int at = i * kCount + k;
            if (i + 1 < kCount && k + 1 < kCount)
                model.addFace({at, at + kCount, at + kCount + 1, at + 1});
        }
    return model;
}

inline FaceModel joined(const std::vector<FaceModel>& models) {
    FaceModel result;
    for (const FaceModel& model : models) {
        const auto firstPoint = static_cast<Index>(result.points.size());
        const std::size_t firstCorner = result.corners.size();
        result.points.insert(result.points.end(), model.points.begin(), model.points.end());
        for (const Index corner : model.corners) result.corners.push_back(firstPoint + corner);
        for (const std::size_t end : model.ends) result.ends.push_back(firstCorner + end);
    }
    return result;
}

/// The same faces, wound the other way.
inline FaceModel reversed(FaceModel model) {
    for (std::size_t f = 0; f < model.ends.size(); ++f) {
        const auto face = model.face(f);
        std::reverse(face.begin(), face.end());
    }
    return model;
}

inline FaceModel moved(FaceModel model, const Point3& way) {
    for (Point3& p : model.points) p = sum(p, way);
    return model;
}

/// The same faces in another order, with other numbers of their points, from other corners; some
/// faces and points occur twice.
inline FaceModel inAnotherOrder(const FaceModel& model, unsigned seed) {
    std::mt19937 random(seed);
    FaceModel source = model, result;
    // Two copies of each point, in a random order.
    std::vector<Index> numbers(2 * model.points.size());
    std::iota(numbers.begin(), numbers.end(), 0);
    std::shuffle(numbers.begin(), numbers.end(), random);
    result.points.resize(numbers.size());
    for (std::size_t i = 0; i < numbers.size(); ++i)
        result.points[numbers[i]] = model.points[i / 2];
    std::vector<std::size_t> order(model.ends.size());
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), random);
    for (const std::size_t f : order) {
        const auto face = source.face(f);
        for (int copies = f % 7 == 0 ? 2 : 1; copies > 0; --copies) {
            const std::size_t start = random() % face.size();
            for (std::size_t i = 0; i < face.size(); ++i)
                result.corners.push_back(
                    numbers[2 * static_cast<std::size_t>(face[(start + i) % face.size()]) +
                            random() % 2]);
            result.ends.push_back(result.corners.size());
        }
    }
    return result;
}

/// A figure of ellipsoids that intersect: a body, a head, two arms and two legs.
inline FaceModel figureModel() {
    return joined({ballModel(3, {0.45, 0.3, 0.7}), ballModel(3, {0.3, 0.28, 0.32}, {0, 0, 0.95}),
                   ballModel(3, {0.55, 0.14, 0.14}, {0.75, 0, 0.35}),
                   ballModel(3, {0.55, 0.14, 0.14}, {-0.75, 0, 0.35}),
                   ballModel(3, {0.16, 0.17, 0.6}, {0.3, 0, -1}),
                   ballModel(3, {0.16, 0.17, 0.6}, {-0.3, 0, -1})});
}

}  // namespace espalier::test

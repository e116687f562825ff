// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/vector3.h>
#include <espalier/far/complex_builder.h>
#include <espalier/far/standard_cells.h>
#include <espalier/shapes/lattice.h>

#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <map>
#include <vector>

#include "cages/point_groups.h"

namespace espalier::test {

/// A solid: its distance function is negative inside, and changes by at most the length of a step.
struct Solid {
    std::function<double(const Point3&)> distance;
    Point3 low, high;  ///< a box around it
    double volume;
};

inline double distanceToSegment(const Point3& p, const Point3& a, const Point3& b) {
    const Point3 way = difference(b, a);
    const double t = std::clamp(dot(difference(p, a), way) / dot(way, way), 0.0, 1.0);
    return length(difference(p, sum(a, scaled(way, t))));
}

inline Solid ball() {
    return {[](const Point3& p) { return length(p) - 1; }, {-1, -1, -1}, {1, 1, 1}, 4 * M_PI / 3};
}

inline Solid torus() {
    return {[](const Point3& p) { return std::hypot(std::hypot(p[0], p[1]) - 1, p[2]) - 0.35; },
            {-1.35, -1.35, -0.35},
            {1.35, 1.35, 0.35},
            2 * M_PI * M_PI * 0.35 * 0.35};
}

/// A box that is turned against the grid of cells around it: sharp edges and corners.
inline Solid brick() {
    const auto distance = [](const Point3& p) {
        // Turned by 3 : 4 : 5 and by 5 : 12 : 13.
        const double x = 0.6 * p[0] + 0.8 * p[1], across = 0.6 * p[1] - 0.8 * p[0];
        const double y = (12 * across + 5 * p[2]) / 13, z = (12 * p[2] - 5 * across) / 13;
        const Point3 over = {std::abs(x) - 1, std::abs(y) - 0.7, std::abs(z) - 0.4};
        const double outside =
            std::hypot(std::max(over[0], 0.0), std::max(over[1], 0.0), std::max(over[2], 0.0));
        return outside + std::min(std::max({over[0], over[1], over[2]}), 0.0);
    };
    return {distance, {-1.25, -1.25, -0.7}, {1.25, 1.25, 0.7}, 8 * 0.7 * 0.4};
}

/// A body with two arms that are thinner than a cell at 500 vertices.
inline Solid figure() {
    const auto distance = [](const Point3& p) {
        return std::min({length(p) - 0.5, distanceToSegment(p, {0, 0, 0}, {1.4, 0.5, 0.1}) - 0.16,
                         distanceToSegment(p, {0, 0, 0}, {-1.2, 0.8, -0.3}) - 0.16});
    };
    Solid solid{distance, {-1.36, -0.5, -0.5}, {1.56, 0.96, 0.5}, 0};
    // The volume by counting: at 50 samples along a side it is accurate to about 2 %.
    constexpr int kSamples = 50;
    const Point3 size = difference(solid.high, solid.low);
    int inside = 0;
    for (int z = 0; z < kSamples; ++z)
        for (int y = 0; y < kSamples; ++y)
            for (int x = 0; x < kSamples; ++x)
                inside += distance({solid.low[0] + size[0] * (x + 0.5) / kSamples,
                                    solid.low[1] + size[1] * (y + 0.5) / kSamples,
                                    solid.low[2] + size[2] * (z + 0.5) / kSamples}) < 0;
    solid.volume = size[0] * size[1] * size[2] * inside / std::pow(kSamples, 3);
    return solid;
}

/// Returns points of the surface of a solid, about `spacing` apart, and points inside.
inline std::vector<Point3> pointsOf(const Solid& solid, double spacing) {
    std::vector<Point3> points;
    const Point3 size = difference(solid.high, solid.low);
    std::array<int, 3> counts;
    for (int axis = 0; axis < 3; ++axis) counts[axis] = static_cast<int>(size[axis] / spacing) + 1;
    for (int z = 0; z <= counts[2]; ++z)
        for (int y = 0; y <= counts[1]; ++y)
            for (int x = 0; x <= counts[0]; ++x) {
                Point3 p = {solid.low[0] + size[0] * x / counts[0],
                            solid.low[1] + size[1] * y / counts[1],
                            solid.low[2] + size[2] * z / counts[2]};
                if (std::abs(solid.distance(p)) > spacing) continue;
                // Newton's method along the gradient.
                for (int step = 0; step < 6; ++step) {
                    const double value = solid.distance(p);
                    const double e = 1e-6;
                    const Point3 slope = {(solid.distance({p[0] + e, p[1], p[2]}) - value) / e,
                                          (solid.distance({p[0], p[1] + e, p[2]}) - value) / e,
                                          (solid.distance({p[0], p[1], p[2] + e}) - value) / e};
                    p = difference(p, scaled(slope, value / std::max(dot(slope, slope), 0.25)));
                }
                if (std::abs(solid.distance(p)) < 1e-3) points.push_back(p);
            }
    return points;
}

/// Makes a lattice of the cells of a grid that meet a solid. Cells that touch others in an edge or
/// a vertex only get neighbours.
inline Lattice gridCage(const Solid& solid, double edge) {
    std::array<int, 3> n;
    Point3 origin;
    for (int axis = 0; axis < 3; ++axis) {
        n[axis] = static_cast<int>(std::ceil((solid.high[axis] - solid.low[axis]) / edge)) + 2;
        origin[axis] = (solid.low[axis] + solid.high[axis] - n[axis] * edge) / 2;
    }
    std::vector<char> isIn(n[0] * n[1] * n[2], 0);
    const auto at = [&](int x, int y, int z) -> char* {
        if (x < 0 || y < 0 || z < 0 || x >= n[0] || y >= n[1] || z >= n[2]) return nullptr;
        return &isIn[(z * n[1] + y) * n[0] + x];
    };
    constexpr int kSamples = 5;
    for (int z = 0; z < n[2]; ++z)
        for (int y = 0; y < n[1]; ++y)
            for (int x = 0; x < n[0]; ++x)
                for (int s = 0; s < kSamples * kSamples * kSamples && !*at(x, y, z); ++s) {
                    const Point3 p = {
                        origin[0] + edge * (x + (s % kSamples + 0.5) / kSamples),
                        origin[1] + edge * (y + (s / kSamples % kSamples + 0.5) / kSamples),
                        origin[2] + edge * (z + (s / (kSamples * kSamples) + 0.5) / kSamples)};
                    *at(x, y, z) = solid.distance(p) < edge / kSamples;
                }
    const auto components = [](unsigned mask) {
        int count = 0;
        while (mask != 0) {
            unsigned part = mask & (~mask + 1);
            for (int i = 0; i < 8; ++i) {
                unsigned wider = part;
                for (int cell = 0; cell < 8; ++cell)
                    for (int axis = 0; axis < 3; ++axis)
                        if (part >> cell & 1) wider |= mask & (1u << (cell ^ (1 << axis)));
                part = wider;
            }
            mask &= ~part;
            ++count;
        }
        return count;
    };
    for (bool isChanged = true; isChanged;) {
        isChanged = false;
        for (int z = -1; z < n[2]; ++z)
            for (int y = -1; y < n[1]; ++y)
                for (int x = -1; x < n[0]; ++x) {
                    unsigned mask = 0;
                    for (int i = 0; i < 8; ++i)
                        if (const char* cell = at(x + (i & 1), y + (i >> 1 & 1), z + (i >> 2)))
                            mask |= *cell ? 1u << i : 0;
                    if (mask == 0 || (components(mask) <= 1 && components(255 & ~mask) <= 1))
                        continue;
                    for (int i = 0; i < 8; ++i)
                        if (char* cell = at(x + (i & 1), y + (i >> 1 & 1), z + (i >> 2));
                            cell && !*cell) {
                            *cell = 1;
                            isChanged = true;
                            break;
                        }
                }
    }
    Lattice lattice;
    std::map<std::array<int, 3>, Index> numbers;
    far::ComplexBuilder builder(3);
    constexpr int kCorners[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                    {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    for (int z = 0; z < n[2]; ++z)
        for (int y = 0; y < n[1]; ++y)
            for (int x = 0; x < n[0]; ++x) {
                if (!*at(x, y, z)) continue;
                std::vector<Index> vertices;
                for (const auto& corner : kCorners) {
                    const std::array<int, 3> place = {x + corner[0], y + corner[1], z + corner[2]};
                    const auto [found, isNew] = numbers.try_emplace(place, Index{0});
                    if (isNew) {
                        found->second = builder.addVertex();
                        lattice.positions.push_back({origin[0] + edge * place[0],
                                                     origin[1] + edge * place[1],
                                                     origin[2] + edge * place[2]});
                    }
                    vertices.push_back(found->second);
                }
                builder.addCell(far::StandardCell::Hexahedron, vertices);
            }
    lattice.complex = builder.build();
    return lattice;
}

/// Returns the cage with the most vertices, up to `vertices`, within a few per cent of the size of
/// the cells.
inline Lattice gridCageOf(const Solid& solid, Index vertices, double& edge) {
    edge = length(difference(solid.high, solid.low));
    Lattice best;
    for (double low = edge / 100, high = edge; high / low > 1.05;) {
        const double middle = std::sqrt(low * high);
        Lattice lattice = gridCage(solid, middle);
        if (lattice.complex.count(0) > vertices) {
            low = middle;
        } else {
            high = edge = middle;
            best = std::move(lattice);
        }
    }
    return best;
}

/// Returns points without a normal and without a cell.
inline std::vector<cages::FitPoint> fitPoints(std::span<const Point3> points) {
    std::vector<cages::FitPoint> result;
    for (const Point3& point : points) result.push_back({.position = point});
    return result;
}

}  // namespace espalier::test

// SPDX-License-Identifier: Apache-2.0
#include "surface_view.h"

#include <espalier/base/error.h>

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace espalier::compare {
namespace {

using Eigen::Vector3d;

bool isFinite(const Point3& p) {
    return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

/// The faces whose corners are all finite.
std::vector<SeenFace> drawableFaces(const SurfaceError& surface) {
    const auto count = static_cast<Index>(surface.positions.size());
    std::vector<SeenFace> faces;
    faces.reserve(surface.faces.size());
    for (std::size_t f = 0; f < surface.faces.size(); ++f) {
        bool isDrawable = true;
        for (const Index corner : surface.faces[f]) {
            if (corner < 0 || corner >= count)
                throw Error(
                    fmt::format("picture: face {} names position {} of {}", f, corner, count));
            isDrawable = isDrawable && isFinite(surface.positions[corner]);
        }
        if (isDrawable) faces.push_back({static_cast<Index>(f), 0, 0});
    }
    return faces;
}

/// The positions of a surface, in a box of which no side is longer than 1 or far from the origin.
struct Normalised {
    Vector3d centre;
    double scale = 1;  ///< divided by before `centre` is taken off: sizes near the limits of double
                       ///< have differences that are over them
    Vector3d extent;

    Normalised(const SurfaceError& surface, const std::vector<SeenFace>& faces) {
        scale = 0;
        for (const SeenFace& seen : faces)
            for (const Index corner : surface.faces[seen.face])
                for (const double x : surface.positions[corner])
                    scale = std::max(scale, std::abs(x));
        if (scale == 0) scale = 1;
        Vector3d min = Vector3d::Constant(1);
        Vector3d max = Vector3d::Constant(-1);
        for (const SeenFace& seen : faces)
            for (const Index corner : surface.faces[seen.face]) {
                const Vector3d p = divided(surface.positions[corner]);
                min = min.cwiseMin(p);
                max = max.cwiseMax(p);
            }
        centre = (min + max) / 2;
        extent = max - min;
    }

    Vector3d divided(const Point3& p) const { return Vector3d(p.data()) / scale; }
    Vector3d operator()(const Point3& p) const { return divided(p) - centre; }
};

/// The axes of the picture, in space.
struct Frame {
    Vector3d right;
    Vector3d up;
    Vector3d towards;  ///< the viewer
};

/// See viewOf().
Frame frameOf(const Vector3d& extent) {
    std::array<int, 3> byExtent = {2, 1, 0};  // of equals z counts as the shortest: it is up then
    std::stable_sort(byExtent.begin(), byExtent.end(),
                     [&](int a, int b) { return extent[a] < extent[b]; });
    const double flatness = 1 - (extent[byExtent[1]] > 0 ? extent[byExtent[0]] / extent[byExtent[1]]
                                                         : 1);  // 0: as thick as wide
    const bool isFlat = flatness > 0.4;
    const bool isTallInY = byExtent[2] == 1 && extent[1] > 1.2 * extent[byExtent[1]];
    const int upAxis = isFlat ? byExtent[0] : isTallInY ? 1 : 2;
    const int across = byExtent[2] != upAxis ? byExtent[2] : byExtent[1];

    // From 30 degrees right of the front; from 28 degrees above a cube, 58 above a sheet of paper.
    constexpr double kDegree = std::numbers::pi / 180;
    const double azimuth = 30 * kDegree;
    const double elevation = (28 + (isFlat ? 30 * flatness : 0)) * kDegree;
    const Vector3d vertical = Vector3d::Unit(upAxis);
    const Vector3d side = Vector3d::Unit(across);
    const Vector3d front = side.cross(vertical);
    const Vector3d ground = std::sin(azimuth) * side + std::cos(azimuth) * front;
    Frame frame;
    frame.towards = std::cos(elevation) * ground + std::sin(elevation) * vertical;
    frame.right = vertical.cross(frame.towards).normalized();
    frame.up = frame.towards.cross(frame.right);
    return frame;
}

/// How much a face looks to a light over the viewer's left shoulder.
double lightOn(const std::array<Vector3d, 4>& corners) {
    // In the axes of the picture: right, up, towards the viewer.
    const Vector3d light = Vector3d(-0.45, 0.7, 0.75).normalized();
    Vector3d normal = (corners[2] - corners[0]).cross(corners[3] - corners[1]);
    if (normal.z() < 0) normal = -normal;
    const double length = normal.norm();
    if (!(length > 0)) return 1;  // no area: nothing of it is seen but its outline
    return std::max(0.0, normal.dot(light) / length);
}

/// Whether the outline of a face goes round a point an odd number of times.
bool isInside(const std::array<std::array<double, 2>, 4>& loop, const std::array<double, 2>& p) {
    bool inside = false;
    for (std::size_t i = 0; i < 4; ++i) {
        const auto& a = loop[i];
        const auto& b = loop[(i + 1) % 4];
        if ((a[1] > p[1]) == (b[1] > p[1])) continue;
        if (p[0] < a[0] + (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1])) inside = !inside;
    }
    return inside;
}

}  // namespace

SurfaceView viewOf(const SurfaceError& surface) {
    SurfaceView view;
    view.faces = drawableFaces(surface);
    view.points.resize(surface.positions.size());
    view.depths.resize(surface.positions.size());
    if (view.faces.empty()) return view;

    const Normalised normalised(surface, view.faces);
    const Frame frame = frameOf(normalised.extent);
    std::vector<Vector3d> seen;  // right, up, towards the viewer
    seen.reserve(surface.positions.size());
    for (const Point3& position : surface.positions) {
        const Vector3d p = normalised(position);
        seen.emplace_back(p.dot(frame.right), p.dot(frame.up), p.dot(frame.towards));
        view.points[seen.size() - 1] = {seen.back().x(), -seen.back().y()};
        view.depths[seen.size() - 1] = seen.back().z();
    }

    view.min = view.max = view.points[surface.faces[view.faces[0].face][0]];
    for (SeenFace& face : view.faces) {
        std::array<Vector3d, 4> corners;
        for (std::size_t i = 0; i < 4; ++i) {
            const std::size_t corner = surface.faces[face.face][i];
            corners[i] = seen[corner];
            face.depth += view.depths[corner] / 4;
            for (std::size_t k = 0; k < 2; ++k) {
                view.min[k] = std::min(view.min[k], view.points[corner][k]);
                view.max[k] = std::max(view.max[k], view.points[corner][k]);
            }
        }
        face.light = lightOn(corners);
    }
    std::stable_sort(view.faces.begin(), view.faces.end(),
                     [](const SeenFace& a, const SeenFace& b) { return a.depth < b.depth; });
    return view;
}

Sight sightOf(const SurfaceError& surface, const SurfaceView& view, Index vertex) {
    Sight sight = Sight::Absent;
    bool isBehind = false;
    for (const SeenFace& seen : view.faces) {
        const std::array<Index, 4>& face = surface.faces[seen.face];
        if (std::find(face.begin(), face.end(), vertex) != face.end()) {
            sight = Sight::Visible;
            continue;
        }
        if (isBehind || seen.depth <= view.depths[vertex]) continue;
        std::array<std::array<double, 2>, 4> loop{};
        for (std::size_t i = 0; i < 4; ++i) loop[i] = view.points[face[i]];
        isBehind = isInside(loop, view.points[vertex]);
    }
    return sight == Sight::Visible && isBehind ? Sight::Hidden : sight;
}

}  // namespace espalier::compare

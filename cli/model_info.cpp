// SPDX-License-Identifier: Apache-2.0
#include "model_info.h"

#include <espalier/base/printable.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace espalier::cli {
namespace {

/// Counts of the surface that faces form.
struct Surface {
    std::size_t components = 0;
    std::size_t pointsInNoFace = 0;
    std::size_t boundaryEdges = 0;
    std::size_t nonmanifoldEdges = 0;
};

/// Sets of points that faces join.
class PointSets {
public:
    explicit PointSets(std::size_t count) : parents_(count) {
        std::iota(parents_.begin(), parents_.end(), Index{0});
    }

    Index rootOf(Index point) {
        while (parents_[point] != point) {
            parents_[point] = parents_[parents_[point]];
            point = parents_[point];
        }
        return point;
    }

    void join(Index a, Index b) { parents_[rootOf(a)] = rootOf(b); }

private:
    std::vector<Index> parents_;
};

Surface surfaceOf(const io::ModelFaces& faces, std::size_t pointCount) {
    PointSets sets(pointCount);
    std::vector<bool> isUsed(pointCount);
    std::vector<std::pair<Index, Index>> edges;
    edges.reserve(faces.corners.size());
    for (std::size_t face = 0; face < faces.count(); ++face) {
        const auto loop = faces[face];
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const auto [low, high] = std::minmax(loop[i], loop[(i + 1) % loop.size()]);
            isUsed[loop[i]] = true;
            sets.join(low, high);
            if (low != high) edges.emplace_back(low, high);
        }
    }
    Surface surface;
    for (std::size_t point = 0; point < pointCount; ++point) {
        const auto index = static_cast<Index>(point);
        if (isUsed[point] && sets.rootOf(index) == index) ++surface.components;
    }
    surface.pointsInNoFace = std::count(isUsed.begin(), isUsed.end(), false);
    std::sort(edges.begin(), edges.end());
    for (auto first = edges.begin(); first != edges.end();) {
        const auto last = std::upper_bound(first, edges.end(), *first);
        if (last - first == 1) ++surface.boundaryEdges;
        if (last - first > 2) ++surface.nonmanifoldEdges;
        first = last;
    }
    return surface;
}

const char* nameOf(io::CoordinateStorage storage) {
    switch (storage) {
        case io::CoordinateStorage::Text:
            return "text";
        case io::CoordinateStorage::Float:
            return "float";
        case io::CoordinateStorage::Integer:
            return "integer";
        case io::CoordinateStorage::Double:
            break;
    }
    return "double";
}

std::string counted(std::size_t count, const char* singular, const char* plural) {
    return fmt::format("{} {}", count, count == 1 ? singular : plural);
}

}  // namespace

Point3 Extent::size() const {
    return {most[0] - least[0], most[1] - least[1], most[2] - least[2]};
}

double Extent::diagonal() const {
    const Point3 sides = size();
    return std::hypot(sides[0], sides[1], sides[2]);
}

std::string Extent::text() const {
    return fmt::format("bounds      ({:.4g}) to ({:.4g})\nsize        {:.4g}, diagonal {:.4g}\n",
                       fmt::join(least, ", "), fmt::join(most, ", "), fmt::join(size(), " × "),
                       diagonal());
}

Extent extentOf(std::span<const Point3> points) {
    Extent extent{points.front(), points.front()};
    for (const Point3& point : points)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            extent.least[axis] = std::min(extent.least[axis], point[axis]);
            extent.most[axis] = std::max(extent.most[axis], point[axis]);
        }
    return extent;
}

nlohmann::json reportModel(const std::string& path, const io::Model& model) {
    const io::ModelFaces faces = model.readSurface().faces;
    const Surface surface = surfaceOf(faces, model.positions().size());
    const Extent extent = extentOf(model.positions());
    nlohmann::json report = {{"model", path},
                             {"points", model.positions().size()},
                             {"faces", faces.count()},
                             {"points_in_no_face", surface.pointsInNoFace},
                             {"components", surface.components},
                             {"closed", faces.count() > 0 && surface.boundaryEdges == 0 &&
                                            surface.nonmanifoldEdges == 0},
                             {"boundary_edges", surface.boundaryEdges},
                             {"nonmanifold_edges", surface.nonmanifoldEdges},
                             {"bounds", {extent.least, extent.most}},
                             {"size", extent.size()},
                             {"diagonal", extent.diagonal()},
                             {"precision", nameOf(model.storage())}};
    if (model.extension() == ".stl") {
        // Each facet has corners of its own; those at one place are one point of the surface.
        report["distinct_points"] = model.positions().size() - surface.pointsInNoFace;
        report["points_in_no_face"] = 0;
    }
    return report;
}

std::string modelText(const nlohmann::json& report) {
    const auto count = [&](const char* key) { return report[key].get<std::size_t>(); };
    const std::size_t faces = count("faces"), loose = count("points_in_no_face");
    std::string text = printable(report["model"].get<std::string>()) + "\n";
    text += fmt::format("points      {}", count("points"));
    if (faces > 0 && loose > 0) text += fmt::format(", of which {} in no face", loose);
    if (report.contains("distinct_points"))
        text += fmt::format(", at {} places", count("distinct_points"));
    text += fmt::format("\nfaces       {}\n", faces);
    if (faces > 0) {
        text += "surface     " + counted(count("components"), "component", "components");
        if (report["closed"].get<bool>())
            text += ", closed\n";
        else
            text += fmt::format(", not closed: {} in one face, {} in more than two\n",
                                counted(count("boundary_edges"), "edge", "edges"),
                                count("nonmanifold_edges"));
    }
    text += Extent{report["bounds"][0].get<Point3>(), report["bounds"][1].get<Point3>()}.text();
    return text + fmt::format("precision   {}\n", report["precision"].get<std::string>());
}

}  // namespace espalier::cli

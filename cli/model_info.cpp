// SPDX-License-Identifier: Apache-2.0
#include "model_info.h"

#include <espalier/base/disjoint_sets.h>
#include <espalier/base/printable.h>
#include <espalier/io/model_part.h>
#include <espalier/solve/mesh_quality.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "mesh_check.h"

namespace espalier::cli {
namespace {

/// Counts of the surface that faces form.
struct Surface {
    std::size_t components = 0;
    std::size_t pointsInNoFace = 0;
    std::size_t boundaryEdges = 0;
    std::size_t nonmanifoldEdges = 0;
};

Surface surfaceOf(const io::ModelFaces& faces, std::size_t pointCount) {
    DisjointSets sets(pointCount);
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
    for (std::size_t point = 0; point < pointCount; ++point)
        if (isUsed[point] && sets.rootOf(point) == point) ++surface.components;
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

/// Returns the number of digits that tell the two ends of a box apart, to a hundredth of its size.
int digitsOf(const BoundingBox& box) {
    int digits = 4;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double largest = std::max(std::abs(box.min[axis]), std::abs(box.max[axis]));
        const double ratio = largest / box.size()[axis];
        if (std::isfinite(ratio))
            digits = std::max(digits, 2 + static_cast<int>(std::ceil(std::log10(ratio))));
    }
    return std::min(digits, std::numeric_limits<double>::max_digits10);
}

/// Returns an end of a box as text.
std::string endText(const BoundingBox& box, const Point3& end) {
    const int digits = digitsOf(box);
    return fmt::format("{:.{}g}, {:.{}g}, {:.{}g}", end[0], digits, end[1], digits, end[2], digits);
}

/// Returns a line with names; nothing if there are none.
std::string namesText(const char* label, const std::vector<std::string>& names) {
    if (names.empty()) return {};
    constexpr std::size_t kMaxNames = 12;
    std::string text = fmt::format("{:<11}", label);
    for (std::size_t i = 0; i < std::min(names.size(), kMaxNames); ++i)
        text += (i == 0 ? " " : ", ") + printable(names[i]);
    if (names.size() > kMaxNames)
        text += fmt::format(" and {} more, which --json lists", names.size() - kMaxNames);
    return text + "\n";
}

/// Adds the cells of a mesh, its patches and its quality to a report:
///
///     cells          {tetrahedra, pyramids, wedges, hexahedra, polyhedra, triangles,
///                    quadrilaterals}: their numbers
///     second_order   how many of these are of second order
///     not_checked    {name: number} of the elements that are none of these
///     parts          [{name, first_cell}] of a decomposed mesh; left out for any other
///     patches        [{name, type, faces, points}]; their names are the groups of the model
///     quality        {scaled_jacobian, non_orthogonality, skewness, smallest_volume,
///                    non_positive_volumes}: null where nothing has the measure
void addMesh(nlohmann::json& report, const io::Model& model, const io::ModelCells& cells) {
    nlohmann::json patches = nlohmann::json::array();
    for (const far::MeshPatch& patch : cells.patches)
        patches.push_back({{"name", patch.name},
                           {"type", patch.type},
                           {"faces", patch.faceCount()},
                           {"points", patch.points.size()}});
    const auto points = model.positions();
    const solve::MeshQuality quality = solve::meshQuality(cells, points, points);
    const auto valueOf = [](const auto& value) {
        return value ? nlohmann::json(value->value) : nlohmann::json(nullptr);
    };
    report["cells"] = cli::toJson(io::cellCounts(cells));
    report["second_order"] = io::secondOrderCount(cells);
    report["not_checked"] = cli::toJson(io::uncheckedElements(cells));
    for (const far::MeshPart& part : cells.parts)
        report["parts"].push_back({{"name", part.name}, {"first_cell", part.firstCell}});
    report["patches"] = std::move(patches);
    report["quality"] = {{"scaled_jacobian", valueOf(quality.smallestScaledJacobian)},
                         {"non_orthogonality", valueOf(quality.largestNonOrthogonality)},
                         {"skewness", valueOf(quality.largestSkewness)},
                         {"smallest_volume", valueOf(quality.smallestVolume)},
                         {"non_positive_volumes", quality.nonPositiveVolumes.size()}};
}

std::string meshText(const nlohmann::json& report) {
    // The JSON has the names in alphabetical order.
    std::vector<io::ElementCount> counts = io::cellCounts({});
    for (auto& [count, name] : counts) count = report["cells"][name].get<Index>();
    std::string text =
        fmt::format("cells       {}\n", countsText(counts, report["second_order"].get<Index>()));
    for (const auto& [name, count] : report["not_checked"].items())
        text += fmt::format("not checked {} {}\n", count.get<Index>(), name);
    if (report.contains("parts"))
        text += fmt::format("parts       {} ({} …)\n", report["parts"].size(),
                            printable(report["parts"][0]["name"].get<std::string>()));
    for (const auto& patch : report["patches"]) {
        const auto type = patch["type"].get<std::string>();
        text += fmt::format("patch       {}{}: {} faces, {} points\n",
                            printable(patch["name"].get<std::string>()),
                            type.empty() ? "" : " (" + printable(type) + ")",
                            patch["faces"].get<std::size_t>(), patch["points"].get<std::size_t>());
    }
    const auto measure = [&](const char* key) {
        const auto& value = report["quality"][key];
        return value.is_null() ? std::string("none") : fmt::format("{:.4g}", value.get<double>());
    };
    const bool isSurface =
        report["cells"]["triangles"].get<Index>() + report["cells"]["quadrilaterals"].get<Index>() >
        0;
    return text + fmt::format(
                      "quality     scaled Jacobian at least {}, non-orthogonality at most {}, "
                      "skewness at most {}\n"
                      "            smallest {} {}, not above 0 in {} {}\n",
                      measure("scaled_jacobian"), measure("non_orthogonality"), measure("skewness"),
                      isSurface ? "area" : "volume", measure("smallest_volume"),
                      report["quality"]["non_positive_volumes"].get<std::size_t>(),
                      isSurface ? "faces" : "cells");
}

}  // namespace

std::string boundsText(const BoundingBox& box) {
    return fmt::format("bounds      ({}) to ({})\nsize        {:.4g}, diagonal {:.4g}\n",
                       endText(box, box.min), endText(box, box.max), fmt::join(box.size(), " × "),
                       box.diagonal());
}

nlohmann::json reportModel(const std::string& path, const io::Model& model) {
    const io::ModelFaces faces = model.readSurface().faces;
    const io::ModelCells cells = model.readCells();
    const Surface surface = surfaceOf(faces, model.positions().size());
    const BoundingBox box(model.positions());
    nlohmann::json report = {{"model", path},
                             {"points", model.positions().size()},
                             {"faces", faces.count()},
                             {"points_in_no_face", surface.pointsInNoFace},
                             {"components", surface.components},
                             {"closed", faces.count() > 0 && surface.boundaryEdges == 0 &&
                                            surface.nonmanifoldEdges == 0},
                             {"boundary_edges", surface.boundaryEdges},
                             {"nonmanifold_edges", surface.nonmanifoldEdges},
                             {"bounds", {box.min, box.max}},
                             {"size", box.size()},
                             {"diagonal", box.diagonal()},
                             {"attributes", io::namesOf(model.attributes())},
                             {"groups", cells.patches.empty() ? io::namesOf(model.groups())
                                                              : io::namesOf(cells.patches)},
                             {"notes", model.notes()},
                             {"precision", nameOf(model.storage())}};
    if (cells.cellCount() > 0) addMesh(report, model, cells);
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
    text += boundsText({report["bounds"][0].get<Point3>(), report["bounds"][1].get<Point3>()});
    text += fmt::format("precision   {}\n", report["precision"].get<std::string>());
    if (report.contains("cells")) text += meshText(report);
    text += namesText("attributes", report["attributes"].get<std::vector<std::string>>());
    // The patches of a mesh are its groups.
    if (!report.contains("cells") || report["patches"].empty())
        text += namesText("groups", report["groups"].get<std::vector<std::string>>());
    return text;
}

}  // namespace espalier::cli

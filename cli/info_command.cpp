// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/parallel.h>
#include <espalier/base/printable.h>
#include <espalier/stencils/composition.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "commands.h"
#include "lattice_report.h"
#include "pipeline.h"
#include "smoothness_report.h"

namespace espalier::cli {
namespace {

struct InfoOptions : LatticeOptions {
    bool json = false;
    bool smoothness = false;
};

constexpr const char* kStrata[] = {"corner", "sharp", "boundary", "interior"};

nlohmann::json toJson(const Histogram& histogram) {
    nlohmann::json object = nlohmann::json::object();
    for (const auto& [value, count] : histogram) object[std::to_string(value)] = count;
    return object;
}

nlohmann::json toJson(const LevelReport& level) {
    // Null is left broken if there is no memory to make it an object.
    nlohmann::json counts = nlohmann::json::object(), strata = nlohmann::json::object();
    for (std::size_t d = 0; d < 4; ++d) {
        counts[kNamesOfParts[d]] = level.counts[d];
        nlohmann::json& own = strata[kNamesOfParts[d]] = nlohmann::json::object();
        for (std::size_t s = 0; s < 4; ++s) own[kStrata[s]] = level.strata[d][s];
    }
    return {{"counts", counts},
            {"euler_characteristic", level.eulerCharacteristic},
            {"strata", strata},
            {"vertex_valences", toJson(level.vertexValences)},
            {"interior_edge_valences", toJson(level.edgeValences)},
            {"cell_types", toJson(level.cellTypes)},
            {"smallest_cell_volume", level.smallestVolume},
            {"largest_cell_volume", level.largestVolume},
            {"inverted_cells", level.invertedCells},
            {"smallest_scaled_jacobian", level.smallestScaledJacobian}};
}

nlohmann::json toJson(const LatticeReport& report, const std::string& name) {
    nlohmann::json levels = nlohmann::json::array();
    for (const LevelReport& level : report.levels) levels.push_back(toJson(level));
    return {{"lattice", name},
            {"bounds", {report.boundsMin, report.boundsMax}},
            {"marks", report.marks},
            {"attributes", report.attributes},
            {"interior_edges_of_two_faces", report.edgesOfTwoFaces},
            {"levels", levels}};
}

/// The line of a ring that is too large for its eigenvalues.
std::string noteOf(const Smoothness& entry) {
    return fmt::format(
        "ring of {} points: eigenvalues are not computed beyond {}, nor in cells of more vertices",
        entry.ringPoints, kMaxRingPoints);
}

nlohmann::json toJson(const std::vector<Smoothness>& entries) {
    nlohmann::json list = nlohmann::json::array();
    for (const Smoothness& entry : entries) {
        nlohmann::json values = nlohmann::json::array();
        for (const auto& value : entry.eigenvalues) values.push_back({value.real(), value.imag()});
        nlohmann::json object = {{dimensionName(entry.entity.dimension), entry.entity.index},
                                 {"stratum", kStrata[entry.stratum]},
                                 {"ring_points", entry.ringPoints},
                                 {"eigenvalues", values},
                                 {"limit_mask", entry.mask}};
        if (!entry.isKnown) {
            object["eigenvalues"] = nullptr;
            object["limit_mask"] = nullptr;
            object["note"] = noteOf(entry);
        }
        list.push_back(std::move(object));
    }
    return list;
}

/// "3: 8, 4: 12": values and how many there are of each.
std::string toText(const Histogram& histogram, const char* prefix = "") {
    std::string text;
    for (const auto& [value, count] : histogram)
        text += fmt::format("{}{}{}: {}", text.empty() ? "" : ", ", prefix, value, count);
    return text.empty() ? "none" : text;
}

void printLevel(std::size_t number, const LevelReport& level) {
    fmt::print("\nlevel {}\n", number);
    for (std::size_t d = 0; d < 4; ++d) {
        fmt::print("  {:<9} {:>9}   ", kNamesOfParts[d], level.counts[d]);
        for (std::size_t s = d; s < 4; ++s) fmt::print(" {} {:<8}", kStrata[s], level.strata[d][s]);
        fmt::print("\n");
    }
    fmt::print("  Euler characteristic      {}\n", level.eulerCharacteristic);
    fmt::print("  edges at a vertex         {}\n", toText(level.vertexValences));
    fmt::print("  faces at an interior edge {}\n", toText(level.edgeValences));
    fmt::print("  {} {}\n", number == 0 ? "valences within cells    " : "cell types               ",
               toText(level.cellTypes, number == 0 ? "" : "type-"));
    fmt::print("  cell volumes              {:.4g} to {:.4g}, {} not positive\n",
               level.smallestVolume, level.largestVolume, level.invertedCells);
    fmt::print("  least scaled Jacobian     {:.3f}\n", level.smallestScaledJacobian);
}

void printText(const LatticeReport& report, const InfoOptions& options) {
    fmt::print("{}\n", printable(options.lattice));
    fmt::print("bounds      ({:.4g}) to ({:.4g})\n", fmt::join(report.boundsMin, ", "),
               fmt::join(report.boundsMax, ", "));
    fmt::print("marks       {}\n", report.marks);
    std::string attributes;
    for (const std::string& name : report.attributes)
        attributes += (attributes.empty() ? "" : ", ") + printable(name);
    fmt::print("attributes  {}\n", attributes.empty() ? "none" : attributes);
    if (report.edgesOfTwoFaces > 0 && options.common.rules == stencils::Rules::Siggraph96)
        fmt::print(
            "note        {} interior edges have two faces: their midpoint has a negative "
            "weight, and the region may leave the convex hull there\n",
            report.edgesOfTwoFaces);
    for (std::size_t level = 0; level < report.levels.size(); ++level)
        printLevel(level, report.levels[level]);
}

std::string toText(const std::complex<double>& value) {
    // Below rounding: real values of matrices that are not symmetric may come out so.
    constexpr double kReal = 1e-9;
    if (std::abs(value.imag()) < kReal) return fmt::format("{:.4f}", value.real());
    return fmt::format("{:.4f}{:+.4f}i", value.real(), value.imag());
}

void printSmoothness(const std::vector<Smoothness>& entries) {
    fmt::print("\nsmoothness, where it is not that of the tricubic spline\n");
    if (entries.empty()) fmt::print("  everywhere\n");
    for (const Smoothness& entry : entries) {
        if (!entry.isKnown) {
            fmt::print("  {:<6} {:>6}  {:<8}  {}\n", dimensionName(entry.entity.dimension),
                       entry.entity.index, kStrata[entry.stratum], noteOf(entry));
            continue;
        }
        std::vector<std::string> values;
        for (const auto& value : entry.eigenvalues) values.push_back(toText(value));
        fmt::print("  {:<6} {:>6}  {:<8}  eigenvalues 1 {}\n",
                   dimensionName(entry.entity.dimension), entry.entity.index,
                   kStrata[entry.stratum], fmt::join(values, " "));
        fmt::print(
            "  {:25}limit {:.4f} of itself, {:.4f} of edges, {:.4f} of faces, {:.4f} of cells\n",
            "", entry.mask[0], entry.mask[1], entry.mask[2], entry.mask[3]);
    }
}

void runInfo(const InfoOptions& options) {
    const ThreadLimit limit(options.common.threads);
    Stages stages(options.common.quiet);
    const auto [lattice, refiner] = readAndRefine(options, FileKind::Lattice, stages);
    const LatticeReport report =
        stages.run("measuring", [&, &lattice = lattice, &refiner = refiner] {
            std::vector<std::vector<Point3>> positions;
            for (int level = 0; level <= options.level; ++level)
                positions.push_back(stencils::refinePositions(refiner, level, options.common.rules,
                                                              lattice.positions));
            return reportLattice(lattice, refiner, positions);
        });
    std::vector<Smoothness> smoothness;
    if (options.smoothness)
        smoothness = stages.run("finding eigenvalues", [&, &refiner = refiner] {
            return reportSmoothness(refiner, options.common.rules);
        });
    if (options.json) {
        nlohmann::json object = toJson(report, options.lattice);
        if (options.smoothness) object["smoothness"] = toJson(smoothness);
        // Only ASCII, since the names in it come from outside; a byte that is not UTF-8 is U+FFFD.
        using Handler = nlohmann::json::error_handler_t;
        fmt::print("{}\n", object.dump(2, ' ', true, Handler::replace));
    } else if (!options.common.quiet) {
        printText(report, options);
        if (options.smoothness) printSmoothness(smoothness);
    }
}

}  // namespace

void addInfoCommand(CLI::App& program) {
    auto options = std::make_shared<InfoOptions>();
    CLI::App& command = addLatticeCommand(
        program, "info",
        "Counts per level, valences, types of cells, strata and quality of a lattice",
        FileKind::Lattice, *options);
    command.add_flag("--json", options->json, "Print JSON");
    command.add_flag("--smoothness", options->smoothness,
                     "Of each irregular vertex and edge the leading eigenvalues of refinement, and "
                     "the limit mask");
    command.callback([options] { runInfo(*options); });
}

}  // namespace espalier::cli

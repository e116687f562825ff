// SPDX-License-Identifier: Apache-2.0
#include "run_report.h"

#include <espalier/base/memory.h>
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

namespace espalier::cli {
namespace {

using embed::PointStatus;

/// Returns billions of bytes per second; nothing if the bytes are not known.
std::optional<double> gigabytesPerSecond(const Stages::FinishedStage& stage) {
    if (!stage.bytes || !(stage.seconds > 0)) return std::nullopt;
    return static_cast<double>(*stage.bytes) / stage.seconds / 1e9;
}

template <class Number>
OrderedJson numberOrNull(const std::optional<Number>& number) {
    return number ? OrderedJson(*number) : OrderedJson(nullptr);
}

OrderedJson toJson(const Stages& stages) {
    OrderedJson array = OrderedJson::array();
    for (const Stages::FinishedStage& stage : stages.finished())
        array.push_back({{"name", stage.name},
                         {"seconds", stage.seconds},
                         {"bytes", numberOrNull(stage.bytes)},
                         {"gigabytes_per_second", numberOrNull(gigabytesPerSecond(stage))}});
    return array;
}

/// Returns the width of the column of labels, which includes the names of the stages.
std::size_t labelWidth(const Stages& stages) {
    std::size_t width = 17;
    for (const Stages::FinishedStage& stage : stages.finished())
        width = std::max(width, stage.name.size());
    return width;
}

void printStage(const Stages::FinishedStage& stage, std::size_t labelWidth) {
    fmt::print("{:<{}} {:>9.3f} s", stage.name, labelWidth, stage.seconds);
    if (stage.bytes) fmt::print("  {:>9}", formatBytes(*stage.bytes));
    if (const auto rate = gigabytesPerSecond(stage)) fmt::print("  {:>7.3f} GB/s", *rate);
    fmt::print("\n");
}

}  // namespace

void addReportOption(CLI::App& command, ReportFormat& format) {
    addChoice<ReportFormat>(command, "--report", format, kReportFormatWords,
                            "Format of the report on standard output");
}

RunReport reportOf(const bind::Binding& binding, const Stages& stages) {
    return {bind::statisticsOf(binding), bytesOf(binding.table), stages, peakMemory()};
}

OrderedJson toJson(const RunReport& report) {
    OrderedJson json =
        OrderedJson::object();  // If memory runs out later, null would be left broken.
    json["points"] = {{"inside", report.binding.count(PointStatus::Inside)},
                      {"outside", report.binding.count(PointStatus::Outside)},
                      {"not_converged", report.binding.count(PointStatus::NotConverged)},
                      {"not_bound", report.binding.count(PointStatus::NotBound)}};
    json["largest_residual"] = report.binding.largestResidual;
    json["kept"] = report.binding.emptyRowCount;
    json["directions"] =
        report.directions.empty() ? OrderedJson(nullptr) : OrderedJson(report.directions);
    json["matrix"] = {{"rows", report.binding.rowCount},
                      {"columns", report.binding.columnCount},
                      {"entries", report.binding.entryCount},
                      {"bytes", numberOrNull(report.matrixBytes)}};
    json["stages"] = toJson(report.stages);
    json["peak_memory"] = report.peakMemory;
    return json;
}

void printText(const RunReport& report) {
    const bind::BindingStatistics& binding = report.binding;
    const Index kept = binding.emptyRowCount;
    const double bound = binding.rowCount - kept;
    const std::size_t width = labelWidth(report.stages);
    const auto printLine = [&](const char* label, const std::string& text) {
        fmt::print("{:<{}} {}\n", label, width, text);
    };
    std::string points = fmt::format("{} inside the lattice, {} outside, {} could not be placed",
                                     report.binding.count(PointStatus::Inside),
                                     report.binding.count(PointStatus::Outside),
                                     report.binding.count(PointStatus::NotConverged));
    if (const Index count = report.binding.count(PointStatus::NotBound); count > 0)
        points += fmt::format(", {} with the weight 0 or beyond the falloff", count);
    printLine("points", points);
    if (kept > 0)
        printLine("left in place",
                  fmt::format("{} {}, whatever the pose", kept, kept == 1 ? "point" : "points"));
    if (!report.directions.empty()) printLine("directions", report.directions);
    printLine("placement error",
              fmt::format("{:.2g}: the largest distance of a point from its place in the lattice",
                          report.binding.largestResidual));
    printLine("matrix",
              fmt::format("{} points × {} lattice vertices, {:.1f} weights for each point that "
                          "moves, {}",
                          binding.rowCount, binding.columnCount,
                          bound > 0 ? static_cast<double>(binding.entryCount) / bound : 0,
                          report.matrixBytes ? formatBytes(*report.matrixBytes) : "not stored"));
    for (const Stages::FinishedStage& stage : report.stages.finished()) printStage(stage, width);
    printLine("peak memory", formatBytes(report.peakMemory));
}

void print(const RunReport& report, ReportFormat format, const CommonOptions& options) {
    if (options.quiet) return;
    if (format == ReportFormat::Json)
        fmt::print("{}\n", toJson(report).dump(2));
    else
        printText(report);
    warnOfPointsOutside(report.binding, options);
}

}  // namespace espalier::cli

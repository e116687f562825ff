// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/bind/bind.h>

#include <CLI/CLI.hpp>
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "bind_model.h"
#include "run.h"

namespace espalier::cli {

/// JSON whose keys stay in their order.
using OrderedJson = nlohmann::ordered_json;

/// The format of a report.
enum class ReportFormat {
    Text,
    Json  ///< one object
};
inline constexpr Word<ReportFormat> kReportFormatWords[] = {{"text", ReportFormat::Text},
                                                            {"json", ReportFormat::Json}};

/// Adds --report to a command.
void addReportOption(CLI::App& command, ReportFormat& format);

/// The report of commands that bind a model or apply a binding. In JSON:
///
///     points            {inside, outside, not_converged, not_bound}: numbers of points;
///                       not_bound are those with the weight 0 or
///                       beyond the falloff
///     largest_residual  largest distance of a point from its place at rest
///     kept              number of points with empty rows, which no pose moves
///     directions        a sentence on normals, tangents and splats; null if the model has none
///     matrix            {rows, columns, entries, bytes}; bytes is null if no matrix was made,
///                       because the poses were applied while its rows were computed
///     stages            [{name, seconds, bytes, gigabytes_per_second}], in order
///     peak_memory       largest memory of the process, in bytes
///
/// The bytes of a stage depend on its kind. They are null, like gigabytes_per_second, if unknown:
///
///     reading, writing   bytes of the files; unknown for devices and pipes
///     binding            bytes of the matrix
///     deforming          bytes of the deformed points; binds and applies without a matrix
///     binding in factors bytes of both factors
///     rounding to float, compiling float, compiling double
///                        bytes of the new table
///     compiling factors, float; compiling factors, double
///                        bytes of both new tables; the former stage also rounds them to float
///     applying           for each pose, bytes of the matrix, the posed lattice vertices and the
///                        deformed points
struct RunReport {
    bind::BindingStatistics binding;
    std::optional<std::size_t> matrixBytes;  ///< nothing if no matrix was made
    const Stages& stages;
    std::size_t peakMemory;
    std::string directions = {};  ///< what happens to normals, tangents and splats; may be empty
};

/// Returns the report of a binding.
RunReport reportOf(const bind::Binding& binding, const Stages& stages);

OrderedJson toJson(const RunReport& report);

void printText(const RunReport& report);

/// Prints a report to standard output in the chosen format, and warns of points outside the
/// lattice; nothing if the run is quiet.
void print(const RunReport& report, ReportFormat format, const CommonOptions& options);

}  // namespace espalier::cli

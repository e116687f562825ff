// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/local_binding.h>

#include <CLI/CLI.hpp>
#include <cstddef>
#include <nlohmann/json_fwd.hpp>

#include "bind_model.h"
#include "run.h"

namespace espalier::cli {

/// Keys stay in their order.
using OrderedJson = nlohmann::ordered_json;

/// How a command says what it did.
enum class ReportFormat {
    Text,
    Json  ///< one object
};
inline constexpr Word<ReportFormat> kReportFormatWords[] = {{"text", ReportFormat::Text},
                                                            {"json", ReportFormat::Json}};

/// Adds --report to a command.
void addReportOption(CLI::App& command, ReportFormat& format);

/// What the commands have to tell that bind a model or apply a binding. In JSON:
///
///     points            {inside, outside, not_converged}; of a run that bound
///     largest_residual  the same
///     kept              points with empty rows
///     matrix            {rows, columns, entries, bytes}
///     stages            [{name, seconds, bytes, gigabytes_per_second}], in order
///     peak_memory       bytes that the process has had at most
///
/// What the bytes of a stage are; null, as bytes a second, where they are not known:
///
///     reading, writing   of the files; not known of devices and pipes
///     binding            of the matrix
///     binding in factors of both factors
///     rounding to float, compiling float, compiling double
///                        of the table that is made
///     compiling factors, float; compiling factors, double
///                        of both; those in float are rounded first, in the same stage
///     applying           that must move: the matrix, the vertices of the pose and the deformed
///                        points, for each pose
struct RunReport {
    const embed::BindingResult* points;  ///< null where the binding was read from a file
    const embed::Binding& binding;
    const Stages& stages;
    std::size_t peakMemory;
};

OrderedJson toJson(const RunReport& report);

void printText(const RunReport& report);

/// Prints it to standard output in the format that was asked for, unless the run is quiet.
void print(const RunReport& report, ReportFormat format, const CommonOptions& options);

}  // namespace espalier::cli

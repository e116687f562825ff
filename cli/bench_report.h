// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/osd/kernels/simd.h>

#include <map>
#include <vector>

#include "apply_timing.h"
#include "run_report.h"

namespace espalier::cli {

/// What was measured of applying.
struct BenchReport {
    osd::Simd simd;
    const BenchTables& tables;
    std::vector<ApplyTiming> timings;
    std::map<int, double> triad;  ///< bytes a second, by number of threads: triad.h
};

/// Prints what the other commands report of binding, with the peak memory of before the triad, and
/// what was measured. In JSON, besides what run_report.h says:
///
///     kernels  baseline, avx2 or avx512: what compiled tables are evaluated with
///     factors  {vertices, entries} of the matrix left in its factors: rows of the table that moves
///              the vertices of the level, and entries of both; with --basis subdivision only
///     apply    [{evaluator, precision, poses, threads, milliseconds, million_points_per_second,
///              bytes, gigabytes_per_second, speedup, share_of_triad}], all a pose (ApplyTiming)
///     triad    [{threads, gigabytes_per_second}]
///
/// The share of the triad is the bytes that a row moves over those that the triad moves in the same
/// time, with as many threads. It is no share of the memory where a cache holds the table.
void print(const RunReport& run, const BenchReport& bench, ReportFormat format);

}  // namespace espalier::cli

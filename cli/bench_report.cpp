// SPDX-License-Identifier: Apache-2.0
#include "bench_report.h"

#include <espalier/base/memory.h>
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>

namespace espalier::cli {
namespace {

using Json = nlohmann::ordered_json;

std::string nameOf(osd::Simd simd) {
    switch (simd) {
        case osd::Simd::Avx2:
            return "avx2";
        case osd::Simd::Avx512:
            return "avx512";
        default:
            return "baseline";
    }
}

double shareOfTriad(const BenchReport& bench, const ApplyTiming& timing) {
    return timing.bytesPerSecond() / bench.triad.at(timing.threads);
}

double millionPointsPerSecond(const RunReport& run, const ApplyTiming& timing) {
    return run.binding.table.rowCount() / timing.seconds / 1e6;
}

Json toJson(const RunReport& run, const BenchReport& bench) {
    Json json = toJson(run);
    json["kernels"] = nameOf(bench.simd);
    if (bench.tables.factors) {
        const auto& factors = bench.tables.factors->inDouble;
        json["factors"] = {{"vertices", factors.vertices.rowCount()},
                           {"entries", factors.entryCount()}};
    }
    Json& rows = json["apply"] = Json::array();
    for (const ApplyTiming& timing : bench.timings)
        rows.push_back({{"evaluator", nameOf(timing.evaluator)},
                        {"precision", nameOf(timing.precision)},
                        {"poses", timing.poses},
                        {"threads", timing.threads},
                        {"milliseconds", timing.seconds * 1e3},
                        {"million_points_per_second", millionPointsPerSecond(run, timing)},
                        {"bytes", timing.bytes},
                        {"gigabytes_per_second", timing.bytesPerSecond() / 1e9},
                        {"speedup", timing.speedup},
                        {"share_of_triad", shareOfTriad(bench, timing)}});
    Json& triads = json["triad"] = Json::array();
    for (const auto& [threads, bytesPerSecond] : bench.triad)
        triads.push_back({{"threads", threads}, {"gigabytes_per_second", bytesPerSecond / 1e9}});
    return json;
}

void printText(const RunReport& run, const BenchReport& bench) {
    printText(run);
    fmt::print("\n{:<9} {:<9} {:>5} {:>7} {:>10} {:>10} {:>9} {:>8} {:>8} {:>8}\n", "evaluator",
               "precision", "poses", "threads", "ms a pose", "Mpoints/s", "bytes", "GB/s",
               "speed-up", "of triad");
    for (const ApplyTiming& timing : bench.timings)
        fmt::print("{:<9} {:<9} {:>5} {:>7} {:>10.4f} {:>10.2f} {:>9} {:>8.3f} {:>8.2f} {:>8.2f}\n",
                   nameOf(timing.evaluator), nameOf(timing.precision), timing.poses, timing.threads,
                   timing.seconds * 1e3, millionPointsPerSecond(run, timing),
                   formatBytes(static_cast<std::size_t>(timing.bytes)),
                   timing.bytesPerSecond() / 1e9, timing.speedup, shareOfTriad(bench, timing));
    for (const auto& [threads, bytesPerSecond] : bench.triad)
        fmt::print("{:<25} {:>7} {:>40.3f}\n", "triad", threads, bytesPerSecond / 1e9);
    fmt::print("kernels: {}\n", nameOf(bench.simd));
}

}  // namespace

void print(const RunReport& run, const BenchReport& bench, ReportFormat format) {
    if (format == ReportFormat::Json)
        fmt::print("{}\n", toJson(run, bench).dump(2));
    else
        printText(run, bench);
}

}  // namespace espalier::cli

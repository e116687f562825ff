// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/memory.h>
#include <espalier/io/files/file.h>
#include <espalier/io/model.h>
#include <espalier/osd/kernels/simd.h>
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apply_timing.h"
#include "bind_model.h"
#include "commands.h"
#include "files.h"
#include "job.h"
#include "run_report.h"

namespace espalier::cli {
namespace {

struct BenchOptions : BindOptions {
    double seconds = 0.2;
    ReportFormat report = ReportFormat::Text;
};

/// Runs a stage that makes a compiled table or chain, and counts its bytes.
template <class Make>
auto compile(const char* stage, Stages& stages, Make make) {
    return stages.run(stage, [&] {
        auto compiled = make();
        stages.addBytes(compiled.byteCount());
        return compiled;
    });
}

BenchTables::Factors prepareFactors(stencils::FactoredTable<double> factors, Stages& stages) {
    auto compiledFloat = compile("compiling factors, float", stages, [&] {
        const stencils::FactoredTable<float> rounded = {
            stencils::convertTable<float>(factors.vertices),
            stencils::convertTable<float>(factors.points)};
        return osd::CompiledChain<float>(rounded);
    });
    auto compiledDouble = compile("compiling factors, double", stages,
                                  [&] { return osd::CompiledChain<double>(factors); });
    return {std::move(factors), std::move(compiledFloat), std::move(compiledDouble)};
}

BenchTables prepare(const stencils::StencilTable<double>& table,
                    std::optional<stencils::FactoredTable<double>> factors, Stages& stages) {
    auto inFloat = stages.run("rounding to float", [&] {
        auto rounded = stencils::convertTable<float>(table);
        stages.addBytes(bytesOf(rounded));
        return rounded;
    });
    auto compiledFloat =
        compile("compiling float", stages, [&] { return osd::CompiledTable<float>(inFloat); });
    auto compiledDouble =
        compile("compiling double", stages, [&] { return osd::CompiledTable<double>(table); });
    BenchTables tables{table, std::move(inFloat), std::move(compiledFloat),
                       std::move(compiledDouble), std::nullopt};
    if (factors) tables.factors = prepareFactors(*std::move(factors), stages);
    return tables;
}

/// Refuses a lattice whose poses overflow in float: their coordinates are up to 1.35 times as large
/// as the largest coordinate at rest (bentPoses).
void checkRange(const BenchOptions& options, const Lattice& lattice) {
    constexpr double kLargest = std::numeric_limits<float>::max() / 2;
    for (std::size_t vertex = 0; vertex < lattice.positions.size(); ++vertex)
        for (const double coordinate : lattice.positions[vertex])
            if (std::abs(coordinate) > kLargest)
                throw io::FileError(
                    options.rest,
                    fmt::format("vertex {} has the coordinate {:.3g}, which is too large "
                                "for a measurement in single precision",
                                vertex, coordinate));
}

/// The times that were measured.
struct BenchReport {
    osd::Simd simd;
    const BenchTables& tables;
    std::vector<ApplyTiming> timings;
    std::map<int, double> triad;  ///< triadBytesPerSecond() by number of threads
};

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
    return run.binding.rowCount / timing.seconds / 1e6;
}

OrderedJson toJson(const RunReport& run, const BenchReport& bench) {
    OrderedJson json = toJson(run);
    json["kernels"] = nameOf(bench.simd);
    if (bench.tables.factors) {
        const auto& factors = bench.tables.factors->inDouble;
        json["factors"] = {{"vertices", factors.vertices.rowCount()},
                           {"entries", factors.entryCount()}};
    }
    OrderedJson& rows = json["apply"] = OrderedJson::array();
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
    OrderedJson& triads = json["triad"] = OrderedJson::array();
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
    fmt::print(
        "csr: plain sparse product; compiled: osd::CompiledTable, by its {} kernels; factors: the "
        "same for the two factors of the matrix\n"
        "speed-up: over csr with one thread; triad: bandwidth of the memory; of triad: GB/s as a "
        "fraction of it\n",
        nameOf(bench.simd));
}

/// Prints the report on binding, as the other commands do, and the measured times. The peak memory
/// is taken before the triad runs. In addition to the keys of run_report.h, the JSON has these
/// keys:
///
///     kernels  baseline, avx2 or avx512: the instruction set of the compiled tables
///     factors  {vertices, entries}: rows of the first factor, which moves the vertices of the
///     level,
///              and entries of both factors; only with --basis subdivision
///     apply    [{evaluator, precision, poses, threads, milliseconds, million_points_per_second,
///              bytes, gigabytes_per_second, speedup, share_of_triad}], for each pose (ApplyTiming)
///     triad    [{threads, gigabytes_per_second}]
///
/// The share of the triad is the bandwidth of a measurement divided by the bandwidth of the triad
/// with the same number of threads. If a cache holds the table, the share says nothing about
/// memory.
void print(const RunReport& run, const BenchReport& bench, ReportFormat format) {
    if (format == ReportFormat::Json)
        fmt::print("{}\n", toJson(run, bench).dump(2));
    else
        printText(run, bench);
}

void runBench(const BenchOptions& options) {
    checkBasis(options);
    Job job(options.common, {{"MODEL", options.model}, {"--rest", options.rest}});
    Stages& stages = job.stages();
    const auto model = readModel(options.model, options.common, stages);
    const Lattice lattice = readLattice(options.rest, stages);
    checkRange(options, lattice);
    const bind::Binding bound = bindModel(options, *model, lattice, stages);
    auto factors = bindInFactors(options, model->positions(), lattice, stages);
    const BenchTables tables = prepare(bound.table, std::move(factors), stages);
    std::vector<int> threadCounts = {1};
    if (const int all = threadCount(options.common.threads); all > 1) threadCounts.push_back(all);

    // These stages show progress only: they are not part of the report.
    Stages progress(options.common.quiet);
    BenchReport bench{
        osd::bestSimd(),
        tables,
        timeApplying(tables, lattice.positions, threadCounts, options.seconds, progress),
        {}};
    const RunReport report = reportOf(bound, stages);
    for (const int threads : threadCounts)
        bench.triad[threads] =
            progress.run("triad", [&] { return triadBytesPerSecond(threads, options.seconds); });
    if (!options.common.quiet) print(report, bench, options.report);
}

}  // namespace

void addBenchCommand(CLI::App& program) {
    const auto [command, options] = addCommand(
        program, "bench",
        "Measure how long it takes to bind a model to a lattice and to apply poses; writes no file",
        runBench);
    addModelAndRest(command, options);
    addBindingOptions(command, options);
    command
        .add_option("--seconds", options.seconds,
                    "How long to repeat each measurement; the quickest run counts")
        ->check(aboveZero(3600))
        ->capture_default_str();
    addStrictOption(command, options.common);
    addRunOptions(command, options.common);
    addReportOption(command, options.report);
}

}  // namespace espalier::cli

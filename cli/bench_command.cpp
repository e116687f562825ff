// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/parallel.h>
#include <espalier/io/files/file.h>
#include <espalier/osd/kernels/simd.h>
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "apply_timing.h"
#include "bench_report.h"
#include "bind_model.h"
#include "byte_counts.h"
#include "commands.h"
#include "pipeline.h"
#include "run_report.h"
#include "triad.h"

namespace espalier::cli {
namespace {

struct BenchOptions : BindOptions {
    double seconds = 0.2;
    ReportFormat report = ReportFormat::Text;
};

/// A stage that makes a compiled table, or a chain.
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

/// Refuses a lattice of which floats cannot hold a pose: coordinates of those are up to 1.35 times
/// as large as the largest at rest (bentPoses).
void checkRange(const BenchOptions& options, const Lattice& lattice) {
    constexpr double kLargest = std::numeric_limits<float>::max() / 2;
    for (std::size_t vertex = 0; vertex < lattice.positions.size(); ++vertex)
        for (const double coordinate : lattice.positions[vertex])
            if (std::abs(coordinate) > kLargest)
                throw io::FileError(
                    options.rest, fmt::format("vertex {} is at {:.3g}: too far out to be measured "
                                              "in single precision",
                                              vertex, coordinate));
}

void runBench(const BenchOptions& options) {
    checkBasis(options);
    const ThreadLimit limit(options.common.threads);
    checkInputs({{"MODEL", options.model}, {"--rest", options.rest}});
    Stages stages(options.common.quiet);
    const auto model = readModel(options.model, stages);
    const Lattice lattice = readLattice(options.rest, stages);
    checkRange(options, lattice);
    const BoundPoints bound = bindPoints(options, model->positions(), lattice, stages);
    auto factors = bindInFactors(options, model->positions(), lattice, stages);
    const BenchTables tables = prepare(bound.binding.table, std::move(factors), stages);
    std::vector<int> threadCounts = {1};
    if (const int all = threadCount(options.common.threads); all > 1) threadCounts.push_back(all);

    // Of their own: what is measured from here on is no stage of the report.
    Stages progress(options.common.quiet);
    BenchReport bench{
        osd::bestSimd(),
        tables,
        timeApplying(tables, lattice.positions, threadCounts, options.seconds, progress),
        {}};
    const RunReport report{bound.report, bound.binding, stages, peakMemory()};
    for (const int threads : threadCounts)
        bench.triad[threads] =
            progress.run("triad", [&] { return triadBytesPerSecond(threads, options.seconds); });
    if (!options.common.quiet) print(report, bench, options.report);
}

}  // namespace

void addBenchCommand(CLI::App& program) {
    auto options = std::make_shared<BenchOptions>();
    CLI::App& command = *program.add_subcommand(
        "bench",
        "Bind a model to a lattice, and measure that and applying poses: nothing is written");
    addModelAndRest(command, *options);
    addBindingOptions(command, *options);
    // Not CLI::PositiveNumber, which lets infinity pass.
    const CLI::Validator isDuration(
        [](std::string& text) {
            double number = 0;
            const bool isOne =
                CLI::detail::lexical_cast(text, number) && number > 0 && number <= 3600;
            return isOne ? std::string() : "expected more than 0, to 3600, got " + text;
        },
        "");
    command
        .add_option("--seconds", options->seconds,
                    "For the repeated runs of each measurement, of which the quickest counts")
        ->check(isDuration)
        ->capture_default_str();
    addRunOptions(command, options->common);
    addReportOption(command, options->report);
    command.callback([options] { runBench(*options); });
}

}  // namespace espalier::cli

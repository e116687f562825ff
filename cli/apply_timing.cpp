// SPDX-License-Identifier: Apache-2.0
#include "apply_timing.h"

#include <espalier/far/parallel.h>
#include <espalier/osd/cpu_evaluator.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "byte_counts.h"
#include "quickest.h"
#include "result_check.h"

namespace espalier::cli {
namespace {

using osd::BufferDescriptor;
using Evaluator = ApplyTiming::Evaluator;
using Precision = ApplyTiming::Precision;

template <class Real>
constexpr Precision kPrecision = sizeof(Real) == sizeof(float) ? Precision::Float
                                                               : Precision::Double;

/// Poses of `count` at once.
struct Poses {
    int count;
    std::vector<double> values;
};

/// One form of the matrix, in one precision.
template <class Real>
struct Form {
    Evaluator evaluator;
    const stencils::StencilTable<Real>& plain;
    const osd::CompiledTable<Real>& compiled;

    std::size_t tableBytes() const {
        return evaluator == Evaluator::Csr ? bytesOf(plain) : compiled.byteCount();
    }

    void evaluate(std::span<const Real> source, std::span<Real> result,
                  const BufferDescriptor& layout) const {
        const osd::RowRange all{0, plain.rowCount()};
        if (evaluator == Evaluator::Csr)
            osd::CpuEvaluator::evaluate(plain, source, layout, result, layout, all);
        else
            compiled.evaluate(source, layout, result, layout, all);
    }
};

template <class Real>
std::string describe(const Form<Real>& form, const Poses& poses, int threads) {
    return fmt::format("{}, {}, poses at once: {}, threads: {}", nameOf(form.evaluator),
                       nameOf(kPrecision<Real>), poses.count, threads);
}

/// Times one form with so many threads; the speed-up is not known yet.
template <class Real>
ApplyTiming timeForm(const Form<Real>& form, const BenchTables& tables, const Poses& poses,
                     int threads, double seconds) {
    const int components = 3 * poses.count;
    const auto layout = BufferDescriptor::packed(components);
    const std::vector<Real> source(poses.values.begin(), poses.values.end());
    std::vector<Real> result(static_cast<std::size_t>(form.plain.rowCount() * layout.length));
    {
        const far::ThreadLimit limit(threads);
        form.evaluate(source, result, layout);
    }
    const UlpBound bound = form.evaluator == Evaluator::Csr ? plainUlpBound : compiledUlpBound;
    for (int pose = 0; pose < poses.count; ++pose)
        checkResults<Real>(tables.inDouble, poses.values, result, {3 * pose, 3, components}, bound,
                           describe(form, poses, threads));
    const far::ThreadLimit limit(threads);
    const double least = quickest(seconds, [&] { form.evaluate(source, result, layout); });
    const std::size_t bytes = form.tableBytes() + std::span(result).size_bytes();
    return {.evaluator = form.evaluator,
            .precision = kPrecision<Real>,
            .poses = poses.count,
            .threads = threads,
            .seconds = least / poses.count,
            .bytes = static_cast<double>(bytes) / poses.count,
            .speedup = 1};
}

}  // namespace

std::string nameOf(Evaluator evaluator) {
    return evaluator == Evaluator::Csr ? "csr" : "compiled";
}

std::string nameOf(Precision precision) {
    return precision == Precision::Float ? "float" : "double";
}

std::vector<double> bentPoses(std::span<const Point3> rest, int count) {
    Point3 size;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto [low, high] = std::minmax_element(
            rest.begin(), rest.end(),
            [&](const Point3& p, const Point3& q) { return p[axis] < q[axis]; });
        size[axis] = (*high)[axis] - (*low)[axis];
    }
    const double length = std::hypot(size[0], size[1], size[2]);
    const double diagonal = length > 0 ? length : 1;
    std::vector<double> values;
    values.reserve(rest.size() * 3 * static_cast<std::size_t>(count));
    for (const Point3& position : rest)
        for (int pose = 0; pose < count; ++pose)
            for (std::size_t axis = 0; axis < 3; ++axis)
                values.push_back(
                    position[axis] +
                    diagonal / 10 *
                        std::sin(2 * std::numbers::pi * position[(axis + 1) % 3] / diagonal + 1 +
                                 pose / 2.0));
    return values;
}

std::vector<ApplyTiming> timeApplying(const BenchTables& tables, std::span<const Point3> rest,
                                      std::span<const int> threadCounts, double seconds,
                                      Stages& progress) {
    constexpr int kPosesAtOnce = 12;
    const Poses one{1, bentPoses(rest, 1)}, several{kPosesAtOnce, bentPoses(rest, kPosesAtOnce)};
    std::vector<ApplyTiming> timings;
    const auto addTimings = [&](const auto& form, const Poses& poses) {
        for (const int threads : threadCounts)
            timings.push_back(progress.run(describe(form, poses, threads), [&] {
                return timeForm(form, tables, poses, threads, seconds);
            }));
    };
    for (const Evaluator evaluator : {Evaluator::Csr, Evaluator::Compiled})
        addTimings(Form<float>{evaluator, tables.inFloat, tables.compiledFloat}, one);
    addTimings(Form<float>{Evaluator::Compiled, tables.inFloat, tables.compiledFloat}, several);
    for (const Evaluator evaluator : {Evaluator::Csr, Evaluator::Compiled})
        addTimings(Form<double>{evaluator, tables.inDouble, tables.compiledDouble}, one);
    // The first timing of a precision is that of the plain evaluator with one thread.
    for (ApplyTiming& timing : timings) {
        const auto plain = std::find_if(
            timings.begin(), timings.end(),
            [&](const ApplyTiming& other) { return other.precision == timing.precision; });
        timing.speedup = plain->seconds / timing.seconds;
    }
    return timings;
}

}  // namespace espalier::cli

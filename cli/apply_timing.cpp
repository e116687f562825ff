// SPDX-License-Identifier: Apache-2.0
#include "apply_timing.h"

#include <espalier/base/array.h>
#include <espalier/base/parallel.h>
#include <espalier/osd/cpu_evaluator.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "result_check.h"

namespace espalier::cli {
namespace {

using osd::BufferDescriptor;
using Evaluator = ApplyTiming::Evaluator;
using Precision = ApplyTiming::Precision;

template <class Real>
constexpr Precision kPrecision = sizeof(Real) == sizeof(float) ? Precision::Float
                                                               : Precision::Double;

/// Runs `work` at least once, and again until `seconds` have passed. Returns the seconds of the
/// quickest run: other programs on the machine can only make a run slower.
template <class Work>
double quickest(double seconds, Work work) {
    using Clock = std::chrono::steady_clock;
    using Seconds = std::chrono::duration<double>;
    double least = std::numeric_limits<double>::infinity();
    const auto begin = Clock::now();
    auto end = begin;
    do {
        const auto start = Clock::now();
        work();
        end = Clock::now();
        least = std::min(least, Seconds(end - start).count());
    } while (Seconds(end - begin).count() < seconds);
    return least;
}

/// `count` poses that are applied at once.
struct Poses {
    int count;
    std::vector<double> values;
};

/// A way to apply the matrix: its form and its precision. Refers to the tables that it is made
/// from.
template <class Real>
struct Form {
    using Evaluate = void(std::span<const Real> source, std::span<Real> result,
                          const BufferDescriptor& layout);

    Evaluator evaluator;
    Index rowCount;
    std::size_t tableBytes;
    Index betweenCount = 0;  ///< intermediate values, written once and read once
    ExpectedSums sums;
    std::function<Evaluate> evaluate;
};

/// \param compiled a table, or a chain
template <class Real, class Compiled>
Form<Real> compiledForm(Evaluator evaluator, const Compiled& compiled, ExpectedSums sums,
                        Index betweenCount = 0) {
    return {.evaluator = evaluator,
            .rowCount = compiled.rowCount(),
            .tableBytes = compiled.byteCount(),
            .betweenCount = betweenCount,
            .sums = std::move(sums),
            .evaluate = [&compiled](auto source, auto result, const BufferDescriptor& layout) {
                compiled.evaluate(source, layout, result, layout, {0, compiled.rowCount()});
            }};
}

/// Returns the forms that are timed in one precision. The plain form comes first.
/// \param chain the compiled tables.factors; null if there are none
template <class Real>
std::vector<Form<Real>> formsOf(const BenchTables& tables,
                                const stencils::StencilTable<Real>& table,
                                const osd::CompiledTable<Real>& compiled,
                                const osd::CompiledChain<Real>* chain) {
    std::vector<Form<Real>> forms;
    forms.push_back(
        {.evaluator = Evaluator::Csr,
         .rowCount = table.rowCount(),
         .tableBytes = bytesOf(table),
         .sums = {tables.inDouble, plainUlpBound},
         .evaluate = [&table](auto source, auto result, const BufferDescriptor& layout) {
             osd::CpuEvaluator::evaluate(table, source, layout, result, layout,
                                         {0, table.rowCount()});
         }});
    forms.push_back(
        compiledForm<Real>(Evaluator::Compiled, compiled, {tables.inDouble, compiledUlpBound}));
    if (chain == nullptr) return forms;
    const stencils::FactoredTable<double>& factors = tables.factors->inDouble;
    forms.push_back(compiledForm<Real>(Evaluator::Factors, *chain,
                                       {tables.inDouble, factors, compiledUlpBound},
                                       factors.vertices.rowCount()));
    return forms;
}

template <class Real>
std::string describe(const Form<Real>& form, const Poses& poses, int threads) {
    return fmt::format("{}, {}, poses at once: {}, threads: {}", nameOf(form.evaluator),
                       nameOf(kPrecision<Real>), poses.count, threads);
}

/// Times one form with `threads` threads. The speed-up is filled in later.
template <class Real>
ApplyTiming timeForm(const Form<Real>& form, const Poses& poses, int threads, double seconds) {
    const int components = 3 * poses.count;
    const auto layout = BufferDescriptor::packed(components);
    const std::vector<Real> source(poses.values.begin(), poses.values.end());
    std::vector<Real> result(form.rowCount * layout.length);
    {
        const ThreadLimit limit(threads);
        form.evaluate(source, result, layout);
    }
    for (int pose = 0; pose < poses.count; ++pose)
        checkResults<Real>(form.sums, poses.values, result, {3 * pose, 3, components},
                           describe(form, poses, threads));
    const ThreadLimit limit(threads);
    const double least = quickest(seconds, [&] { form.evaluate(source, result, layout); });
    const std::size_t between = form.betweenCount * layout.length * sizeof(Real);
    const std::size_t bytes = form.tableBytes + 2 * between + std::span(result).size_bytes();
    return {.evaluator = form.evaluator,
            .precision = kPrecision<Real>,
            .poses = poses.count,
            .threads = threads,
            .seconds = least / poses.count,
            .bytes = static_cast<double>(bytes) / poses.count,
            .speedup = 1};
}

constexpr Offset kTriadLength = 32'000'000;
constexpr Offset kTriadGrain = 1 << 18;

/// Returns an array that is first written by the threads that will read it, so that its pages lie
/// in memory near them.
Array<float> filled(float value) {
    Array<float> array(std::size_t{kTriadLength});
    parallelFor(kTriadLength, kTriadGrain, [&](Offset first, Offset last) {
        std::fill(array.data() + first, array.data() + last, value);
    });
    return array;
}

}  // namespace

std::string nameOf(Evaluator evaluator) {
    switch (evaluator) {
        case Evaluator::Compiled:
            return "compiled";
        case Evaluator::Factors:
            return "factors";
        default:
            return "csr";
    }
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
    values.reserve(rest.size() * 3 * count);
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
                return timeForm(form, poses, threads, seconds);
            }));
    };
    const auto& factors = tables.factors;
    const auto inFloat = formsOf(tables, tables.inFloat, tables.compiledFloat,
                                 factors ? &factors->compiledFloat : nullptr);
    const auto inDouble = formsOf(tables, tables.inDouble, tables.compiledDouble,
                                  factors ? &factors->compiledDouble : nullptr);
    for (const auto& form : inFloat) addTimings(form, one);
    for (const auto& form : inFloat)
        if (form.evaluator != Evaluator::Csr) addTimings(form, several);
    for (const auto& form : inDouble) addTimings(form, one);
    // In each precision, the plain evaluator with one thread was timed first.
    for (ApplyTiming& timing : timings) {
        const auto plain = std::find_if(
            timings.begin(), timings.end(),
            [&](const ApplyTiming& other) { return other.precision == timing.precision; });
        timing.speedup = plain->seconds / timing.seconds;
    }
    return timings;
}

double triadBytesPerSecond(int threads, double seconds) {
    const ThreadLimit limit(threads);
    auto a = filled(0);
    const auto b = filled(1), c = filled(2);
    const double least = quickest(seconds, [&] {
        parallelFor(kTriadLength, kTriadGrain, [&](Offset first, Offset last) {
            float* to = a.data();
            const float *from = b.data(), *other = c.data();
            for (Offset i = first; i < last; ++i) to[i] = from[i] + 3.0F * other[i];
        });
    });
    return 3.0 * sizeof(float) * kTriadLength / least;
}

}  // namespace espalier::cli

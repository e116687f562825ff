// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/osd/compiled_chain.h>
#include <espalier/osd/compiled_table.h>

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "run.h"

namespace espalier::cli {

/// A matrix in every form that it is applied in.
struct BenchTables {
    const stencils::StencilTable<double>& inDouble;
    stencils::StencilTable<float> inFloat;
    osd::CompiledTable<float> compiledFloat;
    osd::CompiledTable<double> compiledDouble;

    /// The matrix left in its factors.
    struct Factors {
        stencils::FactoredTable<double> inDouble;
        osd::CompiledChain<float> compiledFloat;
        osd::CompiledChain<double> compiledDouble;
    };
    std::optional<Factors> factors;  ///< nothing if it has none
};

/// How a matrix was applied, and how long it took.
struct ApplyTiming {
    enum class Evaluator {
        Csr,
        Compiled,
        Factors  ///< both compiled, one after the other
    };
    enum class Precision { Float, Double };

    Evaluator evaluator;
    Precision precision;
    int poses;       ///< at once: three components each
    int threads;     ///< at most
    double seconds;  ///< a pose, of the quickest run

    /// A pose, that must move: the table, once for all poses, and the results. Of factors both
    /// tables, and the values between them, which are written and read once: those may be as many
    /// as the results. The vertices of the pose are left out, which a cache holds.
    double bytes;

    /// How many times as fast as the plain evaluator, with one thread and of the same precision.
    double speedup;

    double bytesPerSecond() const { return bytes / seconds; }
};

/// "compiled", "float" and so on.
std::string nameOf(ApplyTiming::Evaluator evaluator);
std::string nameOf(ApplyTiming::Precision precision);

/// Poses of a lattice of which rest positions are given, smooth and bent in every direction:
/// coordinate a of a vertex moves by d/10 · sin(2π x_b/d + 1 + k/2), where b is the axis after a, d
/// the diagonal of the bounding box and k the number of the pose, from 0.
///
/// \return 3 · count numbers a vertex, vertex by vertex, pose by pose
std::vector<double> bentPoses(std::span<const Point3> rest, int count);

/// Applies a matrix to such poses with osd's evaluators, with each number of threads: one pose, in
/// both precisions, plain, compiled and, where it has factors, by these; and in float twelve poses
/// at once, by all but the plain one.
///
/// Before it is timed, what each makes is compared with what the reference evaluator does.
///
/// \param threadCounts the first of them 1
/// \param seconds for repeated runs of each
/// \param progress shows what is at work
/// \throws Error if a result is off
std::vector<ApplyTiming> timeApplying(const BenchTables& tables, std::span<const Point3> rest,
                                      std::span<const int> threadCounts, double seconds,
                                      Stages& progress);

/// Measures the memory's bandwidth, in bytes a second: a = b + s · c over three arrays of floats,
/// 768 MB in all, so that no cache holds them. Counts two reads and one write a number.
///
/// \param threads at most
/// \param seconds for repeated runs, of which the quickest counts
double triadBytesPerSecond(int threads, double seconds);

}  // namespace espalier::cli

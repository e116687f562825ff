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

/// A matrix in all the forms that are timed.
struct BenchTables {
    const stencils::StencilTable<double>& inDouble;
    stencils::StencilTable<float> inFloat;
    osd::CompiledTable<float> compiledFloat;
    osd::CompiledTable<double> compiledDouble;

    /// The matrix as a product of two tables, which are applied one after the other.
    struct Factors {
        stencils::FactoredTable<double> inDouble;
        osd::CompiledChain<float> compiledFloat;
        osd::CompiledChain<double> compiledDouble;
    };
    std::optional<Factors> factors;  ///< nothing if the matrix is not a product
};

/// How a matrix was applied, and how long it took.
struct ApplyTiming {
    enum class Evaluator {
        Csr,
        Compiled,
        Factors  ///< both factors compiled, applied one after the other
    };
    enum class Precision { Float, Double };

    Evaluator evaluator;
    Precision precision;
    int poses;       ///< applied at once, with three components each
    int threads;     ///< maximum number of threads
    double seconds;  ///< time for each pose, in the quickest run

    /// Bytes that move between memory and processor for each pose: the table, read once for all
    /// poses, and the results. For factors, both tables, and the values between them, written once
    /// and read once. The vertices of the pose are not counted, since a cache holds them.
    double bytes;

    /// Speed divided by the speed of the plain evaluator in the same precision with one thread.
    double speedup;

    double bytesPerSecond() const { return bytes / seconds; }
};

/// "compiled", "float" and so on.
std::string nameOf(ApplyTiming::Evaluator evaluator);
std::string nameOf(ApplyTiming::Precision precision);

/// Returns `count` smooth poses of a lattice, bent in every direction: coordinate a of a vertex
/// moves by d/10 · sin(2π x_b/d + 1 + k/2), where b is the axis after a, d the diagonal of the
/// bounding box and k the number of the pose, from 0.
///
/// \return 3 · count numbers for each vertex, in the order of vertices, then of poses
std::vector<double> bentPoses(std::span<const Point3> rest, int count);

/// Times osd's evaluators on bentPoses(), with each number of threads. One pose is applied in both
/// precisions by the plain evaluator, the compiled table and, if there are factors, the compiled
/// chain. Twelve poses at once are applied in float, by all but the plain evaluator.
///
/// Before an evaluator is timed, its results are compared with the results of the reference
/// evaluator.
///
/// \param threadCounts the first one is 1
/// \param seconds how long each measurement is repeated
/// \param progress shows the running measurement
/// \throws Error if a result is wrong
std::vector<ApplyTiming> timeApplying(const BenchTables& tables, std::span<const Point3> rest,
                                      std::span<const int> threadCounts, double seconds,
                                      Stages& progress);

/// Measures the bandwidth of the memory, in bytes per second, by a = b + s · c over three arrays of
/// floats. They take 384 MB together, so that no cache holds them. Each element counts as two reads
/// and one write.
///
/// \param threads at most
/// \param seconds how long the measurement is repeated; the quickest run counts
double triadBytesPerSecond(int threads, double seconds);

}  // namespace espalier::cli

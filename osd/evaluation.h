// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/stencils/stencil_table.h>

#include <cstddef>
#include <memory>
#include <new>
#include <span>
#include <type_traits>

// osd/ evaluates tables: it multiplies a sparse table by source values. It knows tables and no
// topology.
//
// Input: a binding and poses; or a table, source values and their layout. The results are written
// to memory of the caller.
//
// Types:
// - Deformer moves the points of a bind::Binding, for many poses; evaluateBinding() for one pose;
// - BufferDescriptor describes the layout of a buffer;
// - CpuEvaluator is the plain product on all threads, ReferenceEvaluator the oracle of the tests;
// - CompiledTable holds the same weights in a form that is evaluated several times as fast
//   (compile/ builds it, kernels/ evaluate it);
// - CompiledChain evaluates the two factors of a table;
// - CompiledAdjoint evaluates the transpose;
// - ChangeEvaluator evaluates the rows that depend on some changed columns;
// - CudaEvaluator (cuda/) evaluates on a GPU.
//
// Read deformer.h; then this header, cpu_evaluator.h, compiled_table.h and
// compile/table_compiler.h.

namespace espalier::osd {

/// Describes how entries are laid out in a buffer of numbers, as OpenSubdiv's
/// Osd::BufferDescriptor: component c of entry i is at offset + i·stride + c.
struct BufferDescriptor {
    Offset offset = 0;  ///< offset of the first component of entry 0; 0 to the size of the buffer
    Offset length = 0;  ///< number of components of an entry; 1 to 2³¹ − 1
    Offset stride = 0;  ///< distance from one entry to the next; at least `length`

    /// Returns the layout of entries of `length` components that follow each other without gaps.
    static BufferDescriptor packed(Offset length) { return {0, length, length}; }
};

/// A range of rows of a table: first to last − 1.
struct RowRange {
    Index first = 0;
    Index last = 0;
};

/// Buffers of a source and of a destination. The compiler deduces Real from the table.
template <class Real>
using Values = std::span<const std::type_identity_t<Real>>;
template <class Real>
using MutableValues = std::span<std::type_identity_t<Real>>;

/// Values that an evaluation adds to its results, such as the points of a model at rest: with the
/// displacements of the lattice as the source, the results are x + D · (p' − p). Where nothing
/// moves they are exactly x. Elsewhere the sums round relative to the displacement, and only the
/// last addition relative to x. In float, 1000 units from the origin, the largest error was 3.1e-5
/// (half the distance of two floats) with an addend, and 2.0e-4 without.
///
/// \cost The addend is read once. With an addend, tables of bound models took 1.03 to 1.3 times as
///       long as without; the ratio falls with the number of poses in one call. Tables in factors
///       took 1.4 to 1.55 times as long. A pass over the results after the evaluation costs more:
///       up to 1.8 times as long (bench/apply_benchmark.cpp)
template <class Real>
struct Addend {
    std::span<const Real> values = {};

    /// Row i adds entry i. The length divides the length of the destination, and the components of
    /// an entry repeat: with several poses as further components, all of them add the same points.
    /// A length of 0 adds nothing.
    BufferDescriptor layout = {};

    /// Returns `values` as packed entries of `length` components.
    static Addend packed(std::span<const Real> values, Offset length) {
        return {values, BufferDescriptor::packed(length)};
    }
};

/// Throws Error unless an entry can have `length` components: 1 to 2³¹ − 1.
ESPALIER_API void checkLength(Offset length);

/// Does the checks of checkEvaluation() below for any form of a table, given its numbers of rows
/// and columns and the sizes of the buffers.
ESPALIER_API void checkEvaluation(Index rowCount, Index columnCount, std::size_t sourceSize,
                                  const BufferDescriptor& sourceLayout, std::size_t destinationSize,
                                  const BufferDescriptor& destinationLayout, RowRange rows);

/// Checks the arguments of an evaluation. Every evaluator calls this first, and then computes
///
///     destination[row][c] = Σ_k weights(row)[k] · source[columns(row)[k]][c]
///
/// for each row of `rows`. This is the contract of all evaluators:
///
/// - Row i goes to entry i of the destination, whatever the range. Entries of rows outside the
///   range and numbers between entries are not written.
/// - A row without entries gives 0.
/// - An Addend is added to each sum in one addition, last.
/// - The destination must not overlap the source or the addend. All three must hold all entries
///   that the table and the range address.
/// - One pass over the table serves any number of components. So several poses can be evaluated at
///   once, as further components.
/// - Real is float or double, the same for weights and values.
///
/// \throws Error if a descriptor is invalid, the two descriptors differ in length, a buffer is too
///         short, or the range exceeds the table. The evaluator has written nothing then.
template <class Real>
void checkEvaluation(const stencils::StencilTable<Real>& table, Values<Real> source,
                     const BufferDescriptor& sourceLayout, MutableValues<Real> destination,
                     const BufferDescriptor& destinationLayout, RowRange rows) {
    checkEvaluation(table.rowCount(), table.columnCount(), source.size(), sourceLayout,
                    destination.size(), destinationLayout, rows);
}

/// Checks the addend of an evaluation whose other arguments have been checked.
/// \throws Error if its layout is invalid, its length does not divide the destination's, or it is
///         too short for the rows
ESPALIER_API void checkAddend(std::size_t size, const BufferDescriptor& layout,
                              const BufferDescriptor& destinationLayout, RowRange rows);

/// Keeps the temporary memory of an evaluation for the next one.
///
/// An evaluation with a workspace allocates only if it needs more memory than any earlier one. It
/// takes no lock if it runs on the calling thread (SerialExecutor). So it suits real time:
///
///     const osd::CompiledTable<float> table(binding.table);
///     osd::Workspace workspace = table.workspace(3);
///     SerialExecutor serial;
///     …
///     const ExecutorScope scope(serial);  // for each pose
///     table.evaluate(pose, xyz, points, xyz, {0, table.rowCount()}, workspace);
///
/// A workspace serves one evaluation at a time: give each thread its own.
class Workspace {
public:
    Workspace() = default;
    explicit Workspace(std::size_t bytes) { reserve(bytes); }

    /// Returns at least `bytes` bytes, aligned to 64. If the memory has to grow, its contents are
    /// lost.
    std::byte* reserve(std::size_t bytes) {
        if (bytes > byteCount_) {
            byteCount_ = 0;
            memory_.reset();
            memory_.reset(static_cast<std::byte*>(::operator new(bytes, kAlignment)));
            byteCount_ = bytes;
        }
        return memory_.get();
    }

    std::size_t byteCount() const { return byteCount_; }

private:
    static constexpr std::align_val_t kAlignment{64};
    struct AlignedDelete {
        void operator()(std::byte* memory) const { ::operator delete(memory, kAlignment); }
    };

    std::unique_ptr<std::byte, AlignedDelete> memory_;
    std::size_t byteCount_ = 0;
};

}  // namespace espalier::osd

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

// osd/: a table times values. Tables are known here, and topology is not.
//
// In: a table, source values and their layout. Out: values, in the memory of the caller.
//
// Types: BufferDescriptor, a layout; CpuEvaluator, the product as it stands, and
// ReferenceEvaluator, its oracle; CompiledTable, the same weights in a form that is several times
// as fast (compile/ makes it, kernels/ run it); CompiledAdjoint, its transpose; ChangeEvaluator,
// the rows that some columns change; CudaEvaluator (cuda/).
//
// Read this header, cpu_evaluator.h, compiled_table.h, then compile/table_compiler.h.

namespace espalier::osd {

/// How the values of an entry lie in a buffer of numbers, as OpenSubdiv's Osd::BufferDescriptor:
/// component c of entry i is at offset + i·stride + c.
struct BufferDescriptor {
    Offset offset = 0;  ///< of the first component of entry 0; 0 to the size
    Offset length = 0;  ///< components an entry; 1 to 2³¹ − 1
    Offset stride = 0;  ///< from one entry to the next; at least `length`

    /// Entries of `length` components, one behind the other.
    static BufferDescriptor packed(Offset length) { return {0, length, length}; }
};

/// Part of the rows of a table: first to last − 1.
struct RowRange {
    Index first = 0;
    Index last = 0;
};

/// The numbers of a source, or of a destination; Real follows from the table.
template <class Real>
using Values = std::span<const std::type_identity_t<Real>>;
template <class Real>
using MutableValues = std::span<std::type_identity_t<Real>>;

/// Throws Error unless `length` is a number of components that an entry can have: 1 to 2³¹ − 1.
ESPALIER_API void checkLength(Offset length);

/// The checks of checkEvaluation() below, for any form of a table of so many rows and columns, and
/// buffers of so many numbers.
ESPALIER_API void checkEvaluation(Index rowCount, Index columnCount, std::size_t sourceSize,
                                  const BufferDescriptor& sourceLayout, std::size_t destinationSize,
                                  const BufferDescriptor& destinationLayout, RowRange rows);

/// What every evaluator is called with, and does:
///
///     destination[row][c] = Σ_k weights(row)[k] · source[columns(row)[k]][c]
///
/// for each row of `rows`. Entry i of the destination is row i, whatever the range: rows outside
/// the range and numbers between entries are not touched. A row without entries gives 0. Source and
/// destination must not overlap; they must hold all that the table and the range address. Any
/// number of components goes through in one pass over the table: several poses are several
/// components.
///
/// This function is the part that evaluators share: it checks the arguments.
///
/// Real is float or double, for weights and values alike.
///
/// \throws Error if a descriptor does not make sense, the two differ in length, a buffer is too
///         short, or the range is not in the table. An evaluator has written nothing then.
template <class Real>
void checkEvaluation(const stencils::StencilTable<Real>& table, Values<Real> source,
                     const BufferDescriptor& sourceLayout, MutableValues<Real> destination,
                     const BufferDescriptor& destinationLayout, RowRange rows) {
    checkEvaluation(table.rowCount(), table.columnCount(), source.size(), sourceLayout,
                    destination.size(), destinationLayout, rows);
}

/// Memory that an evaluation takes besides what it is given, kept for the next one.
///
/// An evaluation with a workspace allocates only if no earlier one has needed as much; and takes no
/// lock, if it runs on the calling thread (SerialExecutor). So in real time:
///
///     const osd::CompiledTable<float> table(binding.table);
///     osd::Workspace workspace = table.workspace(3);
///     SerialExecutor serial;
///     …
///     const ExecutorScope scope(serial);  // for each pose
///     table.evaluate(pose, xyz, points, xyz, {0, table.rowCount()}, workspace);
///
/// For one evaluation at a time: threads that evaluate at once have one each.
class Workspace {
public:
    Workspace() = default;
    explicit Workspace(std::size_t bytes) { reserve(bytes); }

    /// What it held is lost if it has to grow.
    /// \return at least so many bytes, aligned to 64
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
    struct Free {
        void operator()(std::byte* memory) const { ::operator delete(memory, kAlignment); }
    };

    std::unique_ptr<std::byte, Free> memory_;
    std::size_t byteCount_ = 0;
};

}  // namespace espalier::osd

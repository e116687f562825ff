// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "device_adjoint_kernels.h"
#include "device_kernels.h"

// Selects the kernels that evaluate a table on a device, and their order. A Launch is called with a
// kernel of device_kernels.h and starts it after the previous ones: on the device in
// cuda_launch.cu, on the host in tests.
namespace espalier::osd::device {

/// Size in bytes of the shared memory that any block may have on any device.
inline constexpr unsigned kMaxShared = 48 * 1024;

struct Blocks {
    unsigned count;
    unsigned warps;  ///< number of warps of each block
};

/// Distributes warps over blocks. Each warp needs `sharedBytes` bytes of shared memory, at most
/// kMaxShared.
constexpr Blocks blocksOf(Index warpCount, unsigned sharedBytes) {
    const unsigned fit = sharedBytes == 0 ? kWarpsPerBlock : kMaxShared / sharedBytes;
    const unsigned warps = fit < kWarpsPerBlock ? fit : kWarpsPerBlock;
    return {(static_cast<unsigned>(warpCount) + warps - 1) / warps, warps};
}

// The largest outer products, in double, fit in shared memory.
static_assert(ProductKernel<0, false, 4, double>::sharedBytesOf(kernels::kMaxProductColumns) <=
              kMaxShared);

/// Splits `length` components into chunks and calls f.operator()<width>(components) for each width
/// that occurs: 1 to 4, or `widest`. Prefers few kernels with many chunks.
template <int widest, class F>
void forComponents(Offset length, F f) {
    Offset from = 0;
    const auto take = [&]<int width>(Offset count) {
        if (count > 0) f.template operator()<width>(Components{from, count});
        from += count * width;
    };
    if constexpr (widest > 4) take.template operator()<widest>(length / widest);
    if ((length - from) % 3 == 0) return take.template operator()<3>((length - from) / 3);
    take.template operator()<4>((length - from) / 4);
    const Offset left = length - from;
    take.template operator()<3>(left == 3);
    take.template operator()<2>(left == 2);
    take.template operator()<1>(left == 1);
}

/// Maximum number of components in one pass over the rows. More components need another pass.
inline constexpr int kMaxComponents = 12;

template <class Real, class Launch>
void launchSparse(const SparseRows<Real>& rows, Index first, Index last,
                  const Evaluation<Real>& evaluation, Launch& launch) {
    forComponents<kMaxComponents>(evaluation.length, [&]<int width>(const Components& components) {
        launch(SparseKernel<width, Real>{rows, first, last, evaluation, components});
    });
}

template <int n, bool isSpline, class Real, class Launch>
void launchProducts(const TableView<Real>& table, const TaskList& tasks,
                    const Evaluation<Real>& evaluation, Launch& launch) {
    forComponents<4>(evaluation.length, [&]<int width>(const Components& components) {
        using Kernel = ProductKernel<n, isSpline, width, Real>;
        for (Offset i = 0; i < components.count; i += Kernel::kMaxChunks)
            launch(Kernel{
                table.groups,
                tasks,
                table.maxProductColumns,
                evaluation,
                {components.from + i * width, std::min(components.count - i, Kernel::kMaxChunks)}});
    });
}

/// Computes destination = table · source for the rows of the evaluation.
template <class Real, class Launch>
void launchTable(const TableView<Real>& table, const Evaluation<Real>& evaluation,
                 Launch&& launch) {
    launchProducts<kSizes[0], false>(table, table.products[0], evaluation, launch);
    launchProducts<kSizes[1], false>(table, table.products[1], evaluation, launch);
    launchProducts<kSizes[2], false>(table, table.products[2], evaluation, launch);
    launchProducts<kSizes[3], false>(table, table.products[3], evaluation, launch);
    launchProducts<4, true>(table, table.products[kSplines], evaluation, launch);
    forComponents<kMaxComponents>(evaluation.length, [&]<int width>(const Components& components) {
        launch(PanelKernel<width, Real>{table.groups, table.panels, evaluation, components});
    });
    const SparseRows<Real>& ungrouped = table.ungrouped;
    if (ungrouped.rows == nullptr)
        launchSparse(ungrouped, evaluation.first,
                     evaluation.last < ungrouped.count ? evaluation.last : ungrouped.count,
                     evaluation, launch);
    else
        launchSparse(ungrouped, 0, ungrouped.count, evaluation, launch);
}

/// Computes destination = tableᵀ · source. The rows of the evaluation are columns of the table.
/// \param slots temporary memory for slotCount · length numbers
template <class Real, class Launch>
void launchAdjoint(const TableView<Real>& table, const AdjointView<Real>& adjoint,
                   const Evaluation<Real>& evaluation, Real* slots, Launch&& launch) {
    // Writes results to the slots from `first` on, as if these were rows.
    const Offset length = evaluation.length;
    const auto toSlots = [&](const Evaluation<Real>& from, Offset first, Index count) {
        return Evaluation<Real>{
            from.source, from.sourceStride, slots + first * length, length, 0, length, 0, count};
    };
    const auto all = toSlots(evaluation, 0, 0);
    forComponents<4>(length, [&]<int width>(const Components& components) {
        launch(AdjointProductKernel<false, width, Real>{table.groups, adjoint.products, all,
                                                        components});
        launch(AdjointProductKernel<true, width, Real>{table.groups, adjoint.splines, all,
                                                       components});
    });
    forComponents<4>(length, [&]<int width>(const Components& components) {
        launch(AdjointPanelKernel<width, Real>{table.groups, adjoint.panels, all, components});
    });
    const Index segments = adjoint.segments.count;
    launchSparse(adjoint.segments, 0, segments, toSlots(evaluation, adjoint.firstSegment, segments),
                 launch);

    // Adds up the results of earlier steps.
    Evaluation<Real> last = evaluation;
    last.source = slots;
    last.sourceStride = length;
    for (int i = 0; i + 1 < adjoint.stepCount; ++i) {
        const SumStep<Real>& step = adjoint.steps[i];
        launchSparse(step.rows, 0, step.rows.count, toSlots(last, step.firstSlot, step.rows.count),
                     launch);
    }
    launchSparse(adjoint.steps[adjoint.stepCount - 1].rows, last.first, last.last, last, launch);
}

}  // namespace espalier::osd::device

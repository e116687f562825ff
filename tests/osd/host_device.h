// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/osd/evaluation.h>

#include <limits>
#include <utility>
#include <vector>

#include "host_warp.h"
#include "osd/device/device_evaluation.h"
#include "osd/device/device_table.h"

namespace espalier::osd {

/// A table in the form for GPUs, evaluated on the host by the kernels of GPUs.
template <class Real>
class HostDevice {
public:
    HostDevice(stencils::StencilTable<Real> table, bool isGrouped, bool hasParameters = false)
        : table_(std::move(table)),
          arrays_(table_, isGrouped, hasParameters),
          adjointArrays_(table_, arrays_),
          view_(viewOf(arrays_, kInSlot)),
          adjoint_(viewOf(adjointArrays_, steps_, kInSlot)) {}

    const device::TableArrays<Real>& arrays() const { return arrays_; }
    const device::AdjointArrays<Real>& adjointArrays() const { return adjointArrays_; }

    void evaluate(Values<Real> source, const BufferDescriptor& sourceLayout,
                  MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                  RowRange rows) const {
        checkEvaluation(view_.rowCount, view_.columnCount, source.size(), sourceLayout,
                        destination.size(), destinationLayout, rows);
        device::launchTable(
            view_, evaluationOf(source, sourceLayout, destination, destinationLayout, rows),
            device::HostLaunch{});
    }

    void evaluateAdjoint(Values<Real> source, const BufferDescriptor& sourceLayout,
                         MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                         RowRange columns) const {
        checkEvaluation(view_.columnCount, view_.rowCount, source.size(), sourceLayout,
                        destination.size(), destinationLayout, columns);
        std::vector<Real> slots(adjoint_.slotCount * sourceLayout.length,
                                std::numeric_limits<Real>::quiet_NaN());
        device::launchAdjoint(
            view_, adjoint_,
            evaluationOf(source, sourceLayout, destination, destinationLayout, columns),
            slots.data(), device::HostLaunch{});
    }

private:
    static constexpr auto kInSlot = [](const auto& values) { return values.data(); };

    static device::Evaluation<Real> evaluationOf(Values<Real> source,
                                                 const BufferDescriptor& sourceLayout,
                                                 MutableValues<Real> destination,
                                                 const BufferDescriptor& destinationLayout,
                                                 RowRange rows) {
        return {source.data() + sourceLayout.offset,
                sourceLayout.stride,
                destination.data() + destinationLayout.offset,
                destinationLayout.stride,
                0,
                sourceLayout.length,
                rows.first,
                rows.last};
    }

    stencils::StencilTable<Real> table_;
    device::TableArrays<Real> arrays_;
    device::AdjointArrays<Real> adjointArrays_;
    std::vector<device::SumStep<Real>> steps_;
    device::TableView<Real> view_;
    device::AdjointView<Real> adjoint_;
};

}  // namespace espalier::osd

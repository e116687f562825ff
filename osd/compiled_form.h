// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/osd/compiled_table.h>

#include "kernels/scratch.h"

// Implements CompiledForm. Include this only in sources that instantiate it.
namespace espalier::osd {

template <class Form, class Real>
void CompiledForm<Form, Real>::evaluate(Values<Real> source, const BufferDescriptor& sourceLayout,
                                        MutableValues<Real> destination,
                                        const BufferDescriptor& destinationLayout, RowRange rows,
                                        Workspace& workspace, const Addend<Real>& addend) const {
    const Index columnCount = form().columnCount();
    checkEvaluation(form().rowCount(), columnCount, source.size(), sourceLayout, destination.size(),
                    destinationLayout, rows);
    checkAddend(addend.values.size(), addend.layout, destinationLayout, rows);
    const bool hasPaddedSource = isPadded<Real>(columnCount, source, sourceLayout);
    form().evaluateIn(
        workspace.reserve(form().workspaceBytes(sourceLayout.length, hasPaddedSource)), source,
        sourceLayout, destination, destinationLayout, rows, addend);
}

template <class Form, class Real>
Workspace CompiledForm<Form, Real>::workspace(Offset length) const {
    checkLength(length);
    return Workspace(form().workspaceBytes(length, false));
}

}  // namespace espalier::osd

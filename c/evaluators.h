// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/osd/compiled_adjoint.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/osd/workspace.h>

#include <variant>

#include "espalier.h"

// What evaluators are, for those who make others of them.

struct espalier_workspace {
    espalier::osd::Workspace workspace;
};

namespace espalier::c {

template <class Real>
using Compiled = std::variant<osd::CompiledTable<Real>, osd::CompiledAdjoint<Real>>;

inline osd::BufferDescriptor layoutOf(const espalier_buffer_layout& layout) {
    return {layout.offset, layout.length, layout.stride};
}

/// The memory that a caller keeps, or some for this call.
class WorkspaceOr {
public:
    explicit WorkspaceOr(espalier_workspace* kept)
        : memory_(kept != nullptr ? kept->workspace : own_) {}
    WorkspaceOr(const WorkspaceOr&) = delete;
    WorkspaceOr& operator=(const WorkspaceOr&) = delete;
    osd::Workspace& get() { return memory_; }

private:
    osd::Workspace own_;
    osd::Workspace& memory_;
};

}  // namespace espalier::c

struct espalier_evaluator_f64 {
    using Real = double;
    espalier::c::Compiled<Real> compiled;
};

struct espalier_evaluator_f32 {
    using Real = float;
    espalier::c::Compiled<Real> compiled;
};

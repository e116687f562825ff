// SPDX-License-Identifier: Apache-2.0
#include <espalier/osd/compiled_adjoint.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/osd/deformer.h>
#include <espalier/osd/evaluation.h>

#include <variant>

#include "handles.h"

using namespace espalier;

struct espalier_workspace {
    osd::Workspace workspace;
};

namespace espalier::c {

template <class Real>
struct EvaluatorHandle {
    std::variant<osd::CompiledTable<Real>, osd::CompiledAdjoint<Real>> compiled;
};

namespace {

/// Holds a reference to the caller's workspace. If the caller passed none, owns a temporary
/// workspace for this call.
class WorkspaceOrTemporary {
public:
    explicit WorkspaceOrTemporary(espalier_workspace* kept)
        : memory_(kept != nullptr ? kept->workspace : own_) {}
    WorkspaceOrTemporary(const WorkspaceOrTemporary&) = delete;
    WorkspaceOrTemporary& operator=(const WorkspaceOrTemporary&) = delete;
    osd::Workspace& get() { return memory_; }

private:
    osd::Workspace own_;
    osd::Workspace& memory_;
};

/// A buffer from C, and its layout.
template <class Real>
struct Buffer {
    Real* values;
    std::int64_t size;
    const espalier_buffer_layout& layout;

    std::span<Real> array(const char* name) const { return c::array(values, size, name); }
    osd::BufferDescriptor descriptor() const {
        return {layout.offset, layout.length, layout.stride};
    }
};

/// Compiles a table.
/// \tparam Form osd::CompiledTable or osd::CompiledAdjoint
template <template <class> class Form, class Real>
Form<Real> compiled(const espalier_table* table) {
    return osd::compile<Form, Real>(*deref(table, "table").table);
}

template <class Real>
espalier_status evaluate(const EvaluatorHandle<Real>* evaluator, const Buffer<const Real>& source,
                         const Buffer<Real>& destination, osd::RowRange rows,
                         espalier_workspace* workspace) {
    return guarded([&] {
        const auto& own = deref(evaluator, "evaluator");
        const auto from = source.array("source");
        const auto to = destination.array("destination");
        WorkspaceOrTemporary memory(workspace);
        std::visit(
            [&](const auto& compiled) {
                compiled.evaluate(from, source.descriptor(), to, destination.descriptor(), rows,
                                  memory.get());
            },
            own.compiled);
    });
}

}  // namespace
}  // namespace espalier::c

espalier_status espalier_workspace_create(espalier_workspace** workspace) {
    return c::result(workspace, "workspace", [] { return new espalier_workspace; });
}

void espalier_workspace_destroy(espalier_workspace* workspace) {
    delete workspace;
}

// Defines the types and functions of one precision, whose names contain `f32` or `f64`.
#define ESPALIER_EVALUATORS(Real, precision)                                                      \
    struct espalier_evaluator_##precision : c::EvaluatorHandle<Real> {};                          \
    struct espalier_deformer_##precision {                                                        \
        osd::Deformer<Real> deformer;                                                             \
    };                                                                                            \
                                                                                                  \
    espalier_status espalier_evaluator_##precision##_create(                                      \
        const espalier_table* table, espalier_evaluator_##precision** evaluator) {                \
        return c::result(evaluator, "evaluator", [&] {                                            \
            return new espalier_evaluator_##precision{                                            \
                {c::compiled<osd::CompiledTable, Real>(table)}};                                  \
        });                                                                                       \
    }                                                                                             \
                                                                                                  \
    espalier_status espalier_evaluator_##precision##_create_adjoint(                              \
        const espalier_table* table, espalier_evaluator_##precision** evaluator) {                \
        return c::result(evaluator, "evaluator", [&] {                                            \
            return new espalier_evaluator_##precision{                                            \
                {c::compiled<osd::CompiledAdjoint, Real>(table)}};                                \
        });                                                                                       \
    }                                                                                             \
                                                                                                  \
    void espalier_evaluator_##precision##_destroy(espalier_evaluator_##precision* evaluator) {    \
        delete evaluator;                                                                         \
    }                                                                                             \
                                                                                                  \
    espalier_status espalier_evaluator_##precision##_evaluate(                                    \
        const espalier_evaluator_##precision* evaluator, const Real* source, int64_t source_size, \
        espalier_buffer_layout source_layout, Real* destination, int64_t destination_size,        \
        espalier_buffer_layout destination_layout, int32_t first_row, int32_t last_row,           \
        espalier_workspace* workspace) {                                                          \
        return c::evaluate<Real>(evaluator, {source, source_size, source_layout},                 \
                                 {destination, destination_size, destination_layout},             \
                                 {first_row, last_row}, workspace);                               \
    }                                                                                             \
                                                                                                  \
    espalier_status espalier_deformer_##precision##_create(                                       \
        const espalier_binding* binding, espalier_deformer_##precision** deformer) {              \
        return c::result(deformer, "deformer", [&] {                                              \
            const bind::Binding& own = c::deref(binding, "binding").model->binding;               \
            return new espalier_deformer_##precision{osd::Deformer<Real>(own)};                   \
        });                                                                                       \
    }                                                                                             \
                                                                                                  \
    void espalier_deformer_##precision##_destroy(espalier_deformer_##precision* deformer) {       \
        delete deformer;                                                                          \
    }                                                                                             \
                                                                                                  \
    espalier_status espalier_deformer_##precision##_deform(                                       \
        const espalier_deformer_##precision* deformer, const Real* poses, int64_t poses_size,     \
        Real* points, int64_t points_size) {                                                      \
        return c::guarded([&] {                                                                   \
            const auto& own = c::deref(deformer, "deformer").deformer;                            \
            own.deform(c::array(poses, poses_size, "poses"),                                      \
                       c::array(points, points_size, "points"));                                  \
        });                                                                                       \
    }                                                                                             \
                                                                                                  \
    espalier_status espalier_deformer_##precision##_deform_changed(                               \
        const espalier_deformer_##precision* deformer, const Real* pose, int64_t pose_size,       \
        int32_t changed_count, const int32_t* changed, Real* points, int64_t points_size) {       \
        return c::guarded([&] {                                                                   \
            const auto& own = c::deref(deformer, "deformer").deformer;                            \
            own.deformChanged(c::array(pose, pose_size, "pose"),                                  \
                              c::array(changed, changed_count, "changed"),                        \
                              c::array(points, points_size, "points"));                           \
        });                                                                                       \
    }

ESPALIER_EVALUATORS(double, f64)
ESPALIER_EVALUATORS(float, f32)

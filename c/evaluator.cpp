// SPDX-License-Identifier: Apache-2.0
#include <variant>

#include "arguments.h"
#include "evaluators.h"
#include "guard.h"
#include "handles.h"

using namespace espalier;

namespace espalier::c {
namespace {

/// \tparam Form osd::CompiledTable or osd::CompiledAdjoint
template <template <class> class Form, class Evaluator>
espalier_status create(const espalier_table* table, Evaluator** evaluator) {
    return guarded([&] {
        using Real = typename Evaluator::Real;
        auto& out = deref(evaluator, "evaluator");
        const auto& own = *deref(table, "table").table;
        if constexpr (std::is_same_v<Real, double>)
            out = new Evaluator{Form<Real>(own)};
        else
            out = new Evaluator{Form<Real>(stencils::convertTable<Real>(own))};
    });
}

template <class Evaluator, class Real>
espalier_status evaluate(const Evaluator* evaluator, const Real* source, int64_t sourceSize,
                         const espalier_buffer_layout& sourceLayout, Real* destination,
                         int64_t destinationSize, const espalier_buffer_layout& destinationLayout,
                         osd::RowRange rows, espalier_workspace* workspace) {
    return guarded([&] {
        const auto& own = deref(evaluator, "evaluator");
        const auto from = array(source, sourceSize, "source");
        const auto to = array(destination, destinationSize, "destination");
        WorkspaceOr memory(workspace);
        std::visit(
            [&](const auto& compiled) {
                compiled.evaluate(from, layoutOf(sourceLayout), to, layoutOf(destinationLayout),
                                  rows, memory.get());
            },
            own.compiled);
    });
}

}  // namespace
}  // namespace espalier::c

espalier_status espalier_evaluator_f64_create(const espalier_table* table,
                                              espalier_evaluator_f64** evaluator) {
    return c::create<osd::CompiledTable>(table, evaluator);
}

espalier_status espalier_evaluator_f32_create(const espalier_table* table,
                                              espalier_evaluator_f32** evaluator) {
    return c::create<osd::CompiledTable>(table, evaluator);
}

espalier_status espalier_evaluator_f64_create_adjoint(const espalier_table* table,
                                                      espalier_evaluator_f64** evaluator) {
    return c::create<osd::CompiledAdjoint>(table, evaluator);
}

espalier_status espalier_evaluator_f32_create_adjoint(const espalier_table* table,
                                                      espalier_evaluator_f32** evaluator) {
    return c::create<osd::CompiledAdjoint>(table, evaluator);
}

void espalier_evaluator_f64_destroy(espalier_evaluator_f64* evaluator) {
    delete evaluator;
}

void espalier_evaluator_f32_destroy(espalier_evaluator_f32* evaluator) {
    delete evaluator;
}

espalier_status espalier_workspace_create(espalier_workspace** workspace) {
    return c::guarded([&] {
        auto& out = c::deref(workspace, "workspace");
        out = new espalier_workspace;
    });
}

void espalier_workspace_destroy(espalier_workspace* workspace) {
    delete workspace;
}

espalier_status espalier_evaluator_f64_evaluate(const espalier_evaluator_f64* evaluator,
                                                const double* source, int64_t source_size,
                                                espalier_buffer_layout source_layout,
                                                double* destination, int64_t destination_size,
                                                espalier_buffer_layout destination_layout,
                                                int32_t first_row, int32_t last_row,
                                                espalier_workspace* workspace) {
    return c::evaluate(evaluator, source, source_size, source_layout, destination, destination_size,
                       destination_layout, {first_row, last_row}, workspace);
}

espalier_status espalier_evaluator_f32_evaluate(const espalier_evaluator_f32* evaluator,
                                                const float* source, int64_t source_size,
                                                espalier_buffer_layout source_layout,
                                                float* destination, int64_t destination_size,
                                                espalier_buffer_layout destination_layout,
                                                int32_t first_row, int32_t last_row,
                                                espalier_workspace* workspace) {
    return c::evaluate(evaluator, source, source_size, source_layout, destination, destination_size,
                       destination_layout, {first_row, last_row}, workspace);
}

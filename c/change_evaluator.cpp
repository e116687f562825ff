// SPDX-License-Identifier: Apache-2.0
#include <espalier/osd/change_evaluator.h>

#include "arguments.h"
#include "evaluators.h"
#include "guard.h"

using namespace espalier;

struct espalier_change_evaluator_f64 {
    osd::ChangeEvaluator<double> changes;
};

struct espalier_change_evaluator_f32 {
    osd::ChangeEvaluator<float> changes;
};

namespace espalier::c {
namespace {

template <class Evaluator, class ChangeEvaluator>
espalier_status create(const Evaluator* evaluator, ChangeEvaluator** changes) {
    return guarded([&] {
        using Real = typename Evaluator::Real;
        auto& out = deref(changes, "changes");
        const auto& own = deref(evaluator, "evaluator").compiled;
        const auto* table = std::get_if<osd::CompiledTable<Real>>(&own);
        if (table == nullptr)
            throw Error("evaluator is an adjoint; expected one that applies a table");
        out = new ChangeEvaluator{osd::ChangeEvaluator<Real>(*table)};
    });
}

template <class ChangeEvaluator, class Real>
espalier_status evaluate(const ChangeEvaluator* changes, const Real* source, int64_t sourceSize,
                         const espalier_buffer_layout& sourceLayout, Real* destination,
                         int64_t destinationSize, const espalier_buffer_layout& destinationLayout,
                         const int32_t* columns, int32_t count, espalier_workspace* workspace) {
    return guarded([&] {
        const auto& own = deref(changes, "changes").changes;
        const auto from = array(source, sourceSize, "source");
        const auto to = array(destination, destinationSize, "destination");
        const auto changed = array(columns, count, "changed");
        WorkspaceOr memory(workspace);
        own.evaluateChanged(from, layoutOf(sourceLayout), to, layoutOf(destinationLayout), changed,
                            memory.get());
    });
}

}  // namespace
}  // namespace espalier::c

espalier_status espalier_change_evaluator_f64_create(const espalier_evaluator_f64* evaluator,
                                                     espalier_change_evaluator_f64** changes) {
    return c::create(evaluator, changes);
}

espalier_status espalier_change_evaluator_f32_create(const espalier_evaluator_f32* evaluator,
                                                     espalier_change_evaluator_f32** changes) {
    return c::create(evaluator, changes);
}

void espalier_change_evaluator_f64_destroy(espalier_change_evaluator_f64* changes) {
    delete changes;
}

void espalier_change_evaluator_f32_destroy(espalier_change_evaluator_f32* changes) {
    delete changes;
}

espalier_status espalier_change_evaluator_f64_evaluate(
    const espalier_change_evaluator_f64* changes, const double* source, int64_t source_size,
    espalier_buffer_layout source_layout, double* destination, int64_t destination_size,
    espalier_buffer_layout destination_layout, int32_t changed_count, const int32_t* changed,
    espalier_workspace* workspace) {
    return c::evaluate(changes, source, source_size, source_layout, destination, destination_size,
                       destination_layout, changed, changed_count, workspace);
}

espalier_status espalier_change_evaluator_f32_evaluate(
    const espalier_change_evaluator_f32* changes, const float* source, int64_t source_size,
    espalier_buffer_layout source_layout, float* destination, int64_t destination_size,
    espalier_buffer_layout destination_layout, int32_t changed_count, const int32_t* changed,
    espalier_workspace* workspace) {
    return c::evaluate(changes, source, source_size, source_layout, destination, destination_size,
                       destination_layout, changed, changed_count, workspace);
}

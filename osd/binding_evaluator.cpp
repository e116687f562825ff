// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/osd/cpu_evaluator.h>

namespace espalier::osd {

namespace {

/// Returns p' − p.
/// \throws Error unless the pose has the vertices of the lattice
std::vector<Point3> displacements(const bind::Binding& binding, std::span<const Point3> pose) {
    binding.checkParts();
    if (std::ssize(pose) != binding.table.columnCount())
        throw Error(concat("the pose has ", pose.size(),
                           " vertices; the model is bound to a lattice of ",
                           binding.table.columnCount()));
    std::vector<Point3> result(pose.size());
    for (std::size_t v = 0; v < pose.size(); ++v)
        for (std::size_t c = 0; c < 3; ++c) result[v][c] = pose[v][c] - binding.rest[v][c];
    return result;
}

/// Returns the table times one vector per column.
std::vector<Point3> product(const stencils::StencilTable<double>& table,
                            std::span<const Point3> vectors) {
    constexpr BufferDescriptor kXyz = {0, 3, 3};
    std::vector<Point3> result(table.rowCount());
    const auto numbersOf = [](auto& points) {
        return std::span(points.empty() ? nullptr : points.front().data(), 3 * points.size());
    };
    CpuEvaluator::evaluate(table, numbersOf(vectors), kXyz, numbersOf(result), kXyz,
                           {0, table.rowCount()});
    return result;
}

}  // namespace

std::vector<Point3> evaluateBinding(const bind::Binding& binding, std::span<const Point3> pose) {
    std::vector<Point3> points = product(binding.table, displacements(binding, pose));
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) points[i][c] += binding.points[i][c];
    return points;
}

std::vector<DeformationGradient> evaluateGradients(const bind::Binding& binding,
                                                   std::span<const Point3> pose) {
    if (!binding.gradients)
        throw Error("the binding has no gradients: bind the points with BindOptions::gradients");
    const std::vector<Point3> moved = displacements(binding, pose);
    std::vector<DeformationGradient> result(binding.points.size(), {1, 0, 0, 0, 1, 0, 0, 0, 1});
    embed::addGradients(*binding.gradients, binding.rest, moved, result);
    if (binding.weights.empty()) return result;
    const std::vector<Point3> displaced = product(binding.table, moved);
    for (std::size_t point = 0; point < result.size(); ++point) {
        // F = 1 + w (F₁ − 1) + d ∇wᵀ, where D gives w d.
        const auto& [weight, slope] = binding.weights[point];
        if (!(weight > 0)) continue;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j) {
                double& f = result[point][3 * i + j];
                const double one = i == j;
                f = one + weight * (f - one) + displaced[point][i] / weight * slope[j];
            }
    }
    return result;
}

}  // namespace espalier::osd

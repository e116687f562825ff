// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/osd/cpu_evaluator.h>

namespace espalier::osd {

namespace {

/// Returns p' − p, three numbers for each vertex.
/// \throws Error unless the pose has the vertices of the lattice
std::vector<double> displacements(const bind::Binding& binding, std::span<const Point3> pose) {
    binding.checkParts();
    if (std::ssize(pose) != binding.table.columnCount())
        throw Error(concat("the pose has ", pose.size(),
                           " vertices; the model is bound to a lattice of ",
                           binding.table.columnCount()));
    std::vector<double> result;
    result.reserve(3 * pose.size());
    for (std::size_t v = 0; v < pose.size(); ++v)
        for (std::size_t c = 0; c < 3; ++c) result.push_back(pose[v][c] - binding.rest[v][c]);
    return result;
}

/// Returns the table times one vector per column.
std::vector<Point3> product(const stencils::StencilTable<double>& table,
                            std::span<const double> vectors) {
    constexpr BufferDescriptor kXyz = {0, 3, 3};
    std::vector<Point3> result(table.rowCount());
    const std::span numbers(result.empty() ? nullptr : result.data()->data(), 3 * result.size());
    CpuEvaluator::evaluate(table, vectors, kXyz, numbers, kXyz, {0, table.rowCount()});
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
        throw Error("the binding has no gradients: bind to the limit, and ask for them");
    const std::vector<double> moved = displacements(binding, pose);
    std::vector<DeformationGradient> result(binding.points.size(), {1, 0, 0, 0, 1, 0, 0, 0, 1});
    for (std::size_t j = 0; j < 3; ++j) {
        const std::vector<Point3> column = product((*binding.gradients)[j], moved);
        for (std::size_t point = 0; point < result.size(); ++point)
            for (std::size_t i = 0; i < 3; ++i) result[point][3 * i + j] += column[point][i];
    }
    return result;
}

}  // namespace espalier::osd

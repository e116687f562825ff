// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/osd/cpu_evaluator.h>

namespace espalier::osd {

namespace {

/// Returns p' − p.
/// \throws Error unless the pose has the vertices of the lattice
std::vector<Point3> displacements(std::span<const Point3> rest, std::span<const Point3> pose) {
    if (pose.size() != rest.size())
        throw Error(concat("the pose has ", pose.size(),
                           " vertices; the model is bound to a lattice of ", rest.size()));
    std::vector<Point3> result(pose.size());
    for (std::size_t v = 0; v < pose.size(); ++v)
        for (std::size_t c = 0; c < 3; ++c) result[v][c] = pose[v][c] - rest[v][c];
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

/// Returns F of the points of some rows.
/// \param rest, moved the lattice at rest, and p' − p
/// \throws Error without gradients
std::vector<DeformationGradient> gradientsOf(const bind::WeightedRows& rows,
                                             std::span<const Point3> rest,
                                             std::span<const Point3> moved) {
    if (!rows.gradients)
        throw Error("the binding has no gradients: bind the points with BindOptions::gradients");
    std::vector<DeformationGradient> result(rows.table.rowCount(), {1, 0, 0, 0, 1, 0, 0, 0, 1});
    embed::addGradients(*rows.gradients, rest, moved, result);
    if (rows.weights.empty()) return result;
    const std::vector<Point3> displaced = product(rows.table, moved);
    for (std::size_t point = 0; point < result.size(); ++point) {
        // F = 1 + w (F₁ − 1) + d ∇wᵀ, where D gives w d.
        const auto& [weight, slope] = rows.weights[point];
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

}  // namespace

std::vector<Point3> evaluateBinding(const bind::Binding& binding, std::span<const Point3> pose) {
    binding.checkParts();
    std::vector<Point3> points = product(binding.table, displacements(binding.rest, pose));
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) points[i][c] += binding.points[i][c];
    return points;
}

std::vector<DeformationGradient> evaluateGradients(const bind::Binding& binding,
                                                   std::span<const Point3> pose) {
    binding.checkParts();
    return gradientsOf(binding, binding.rest, displacements(binding.rest, pose));
}

DeformedPoints deformPoints(const embed::RestLattice& lattice, std::span<const Point3> points,
                            const bind::Target& target, const bind::BindOptions& options,
                            std::span<const std::vector<Point3>> poses) {
    std::vector<std::vector<Point3>> moved;
    for (const std::vector<Point3>& pose : poses)
        moved.push_back(displacements(lattice.positions, pose));
    DeformedPoints result;
    result.poses.resize(poses.size());
    for (DeformedPoints::Pose& pose : result.poses) {
        pose.points.assign(points.begin(), points.end());
        if (options.gradients) pose.gradients.assign(points.size(), {1, 0, 0, 0, 1, 0, 0, 0, 1});
    }
    const auto apply = [&](std::span<const Index> numbers, bind::WeightedRows rows) {
        for (std::size_t i = 0; i < poses.size(); ++i) {
            auto& [ofPoints, gradients] = result.poses[i];
            const std::vector<Point3> displaced = product(rows.table, moved[i]);
            for (std::size_t row = 0; row < numbers.size(); ++row)
                for (std::size_t c = 0; c < 3; ++c) ofPoints[numbers[row]][c] += displaced[row][c];
            if (!options.gradients) continue;
            const auto ofRows = gradientsOf(rows, lattice.positions, moved[i]);
            for (std::size_t row = 0; row < numbers.size(); ++row)
                gradients[numbers[row]] = ofRows[row];
        }
    };
    result.statistics = bind::bindInGroups(lattice, points, target, options, apply);
    return result;
}

}  // namespace espalier::osd

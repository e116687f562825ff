// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/osd/cpu_evaluator.h>

#include <string>

namespace espalier::osd {

namespace {

constexpr BufferDescriptor kXyz = {0, 3, 3};

template <class Real>
std::vector<Real> times(const stencils::StencilTable<Real>& table, std::span<const Real> source) {
    std::vector<Real> result(3 * static_cast<std::size_t>(table.rowCount()));
    CpuEvaluator::evaluate(table, source, kXyz, result, kXyz, {0, table.rowCount()});
    return result;
}

template <class Real>
std::vector<Real> times(const stencils::FactoredTable<Real>& table, std::span<const Real> source) {
    return times<Real>(table.points, times<Real>(table.vertices, source));
}

/// Returns D times one vector per vertex.
template <class Table>
std::vector<Point3> product(const Table& table, std::span<const Point3> vectors) {
    using Real = typename Table::Weight;
    std::vector<Real> source;
    source.reserve(3 * vectors.size());
    for (const Point3& vector : vectors)
        for (const double coordinate : vector) source.push_back(static_cast<Real>(coordinate));
    const std::vector<Real> values = times<Real>(table, source);
    std::vector<Point3> result(values.size() / 3);
    for (std::size_t i = 0; i < result.size(); ++i)
        result[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
    return result;
}

template <class Table>
void requireVertices(const Table& table, std::size_t count) {
    if (count != static_cast<std::size_t>(table.columnCount()))
        throw Error(concat("the pose has ", count, " vertices; the model is bound to a lattice of ",
                           table.columnCount()));
}

template <class Table>
void requireRestVertices(const Table& table, std::size_t count) {
    if (count != static_cast<std::size_t>(table.columnCount()))
        throw Error(concat("there are ", count,
                           " vertices at rest; the model is bound to a lattice of ",
                           table.columnCount()));
}

std::vector<Point3> displacements(std::span<const Point3> rest, std::span<const Point3> pose) {
    std::vector<Point3> result(pose.begin(), pose.end());
    for (std::size_t v = 0; v < result.size(); ++v)
        for (std::size_t c = 0; c < 3; ++c) result[v][c] -= rest[v][c];
    return result;
}

}  // namespace

std::vector<DeformationGradient> evaluateGradients(
    const std::array<stencils::StencilTable<double>, 3>& gradients, std::span<const Point3> rest,
    std::span<const Point3> pose) {
    for (const auto& table : gradients) {
        requireVertices(table, pose.size());
        if (table.rowCount() != gradients[0].rowCount())
            throw Error("the three tables of gradients have different numbers of rows");
    }
    requireRestVertices(gradients[0], rest.size());
    const std::vector<Point3> moved = displacements(rest, pose);
    std::vector<DeformationGradient> result(static_cast<std::size_t>(gradients[0].rowCount()),
                                            {1, 0, 0, 0, 1, 0, 0, 0, 1});
    for (std::size_t j = 0; j < 3; ++j) {
        const std::vector<Point3> column = product(gradients[j], moved);
        for (std::size_t point = 0; point < result.size(); ++point)
            for (std::size_t i = 0; i < 3; ++i) result[point][3 * i + j] += column[point][i];
    }
    return result;
}

template <class Table>
std::vector<Point3> evaluateBinding(const embed::BindingOf<Table>& binding,
                                    std::span<const Point3> pose) {
    requireVertices(binding.table, pose.size());
    std::vector<Point3> points = product(binding.table, pose);
    for (std::size_t i = 0; i < binding.kept.size(); ++i)
        points[binding.kept[i]] = binding.keptAt[i];
    return points;
}

template <class Table>
std::vector<Point3> evaluateBinding(const embed::BindingOf<Table>& binding,
                                    const RestPositions& rest, std::span<const Point3> pose) {
    requireVertices(binding.table, pose.size());
    requireRestVertices(binding.table, rest.vertices.size());
    if (std::ssize(rest.points) != binding.table.rowCount())
        throw Error(concat("there are ", rest.points.size(),
                           " points at rest; the bound model has ", binding.table.rowCount()));
    std::vector<Point3> points = product(binding.table, displacements(rest.vertices, pose));
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) points[i][c] += rest.points[i][c];
    return points;
}

std::vector<Point3> evaluateBinding(const bind::Binding& binding, std::span<const Point3> pose) {
    const embed::TableBinding& rows = binding;
    if (!binding.knowsRest()) return evaluateBinding(rows, pose);
    return evaluateBinding(rows, RestPositions{binding.points, binding.rest}, pose);
}

std::vector<DeformationGradient> evaluateGradients(const bind::Binding& binding,
                                                   std::span<const Point3> pose) {
    if (!binding.gradients)
        throw Error("the binding has no gradients: bind to the limit, and ask for them");
    return evaluateGradients(*binding.gradients, binding.rest, pose);
}

template <class Real>
using Rows = stencils::StencilTable<Real>;
template <class Real>
using Factors = stencils::FactoredTable<Real>;

template std::vector<Point3> evaluateBinding(const embed::BindingOf<Rows<float>>&,
                                             std::span<const Point3>);
template std::vector<Point3> evaluateBinding(const embed::BindingOf<Rows<float>>&,
                                             const RestPositions&, std::span<const Point3>);
template std::vector<Point3> evaluateBinding(const embed::BindingOf<Rows<double>>&,
                                             std::span<const Point3>);
template std::vector<Point3> evaluateBinding(const embed::BindingOf<Rows<double>>&,
                                             const RestPositions&, std::span<const Point3>);
template std::vector<Point3> evaluateBinding(const embed::BindingOf<Factors<float>>&,
                                             std::span<const Point3>);
template std::vector<Point3> evaluateBinding(const embed::BindingOf<Factors<float>>&,
                                             const RestPositions&, std::span<const Point3>);
template std::vector<Point3> evaluateBinding(const embed::BindingOf<Factors<double>>&,
                                             std::span<const Point3>);
template std::vector<Point3> evaluateBinding(const embed::BindingOf<Factors<double>>&,
                                             const RestPositions&, std::span<const Point3>);

}  // namespace espalier::osd

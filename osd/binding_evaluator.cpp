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

}  // namespace

template <class Table>
std::vector<Point3> evaluateBinding(const embed::BindingOf<Table>& binding,
                                    std::span<const Point3> pose) {
    using Real = typename Table::Weight;
    if (pose.size() != static_cast<std::size_t>(binding.table.columnCount()))
        throw Error(concat("the pose has ", pose.size(),
                           " vertices; the model is bound to a lattice of ",
                           binding.table.columnCount()));
    std::vector<Real> source;
    source.reserve(3 * pose.size());
    for (const Point3& position : pose)
        for (const double coordinate : position) source.push_back(static_cast<Real>(coordinate));
    const std::vector<Real> values = times<Real>(binding.table, source);

    std::vector<Point3> points(values.size() / 3);
    for (std::size_t i = 0; i < points.size(); ++i)
        points[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
    for (std::size_t i = 0; i < binding.kept.size(); ++i)
        points[binding.kept[i]] = binding.keptAt[i];
    return points;
}

template <class Real>
using Rows = stencils::StencilTable<Real>;
template <class Real>
using Factors = stencils::FactoredTable<Real>;

template std::vector<Point3> evaluateBinding(const embed::BindingOf<Rows<float>>&,
                                             std::span<const Point3>);
template std::vector<Point3> evaluateBinding(const embed::BindingOf<Rows<double>>&,
                                             std::span<const Point3>);
template std::vector<Point3> evaluateBinding(const embed::BindingOf<Factors<float>>&,
                                             std::span<const Point3>);
template std::vector<Point3> evaluateBinding(const embed::BindingOf<Factors<double>>&,
                                             std::span<const Point3>);

}  // namespace espalier::osd

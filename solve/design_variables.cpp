// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/argument_error.h>
#include <espalier/shapes/mirror_images.h>
#include <espalier/solve/design_variables.h>
#include <espalier/stencils/table_builder.h>

#include <cmath>
#include <string>
#include <utility>

namespace espalier::solve {
namespace {

[[noreturn]] void refuseNumber(const char* argument, double got, const char* expected) {
    throw ArgumentError("", argument, textOf(got), expected);
}

void requireScale(const char* argument, double factor) {
    if (!std::isfinite(factor) || factor == 0)
        refuseNumber(argument, factor, "a finite number other than 0");
}

void checkAxis(int axis) {
    if (axis < 0 || axis > 2) throw ArgumentError("", "axis", std::to_string(axis), "0 to 2");
}

}  // namespace

DesignVariables::DesignVariables(Index vertexCount) {
    if (vertexCount < 0 || vertexCount > kMaxIndex / 3)
        throw Error(concat("cannot number the coordinates of ", vertexCount, " vertices"));
    for (Index i = 0; i < 3 * vertexCount; ++i) links_.push_back({i, 1});
    isFrozen_.assign(links_.size(), 0);
    units_.assign(links_.size(), 1);
}

Index DesignVariables::coordinate(Index vertex, int axis) const {
    checkAxis(axis);
    if (vertex < 0 || vertex >= static_cast<Index>(links_.size() / 3))
        throw Error(concat("there is no vertex ", vertex, "; the lattice has ", links_.size() / 3));
    return 3 * vertex + axis;
}

/// Returns the root of a coordinate, and compresses the path: the coordinates on the way then link
/// to the root directly.
DesignVariables::Link DesignVariables::rootOf(Index coordinate) {
    std::vector<Index> path = {coordinate};
    while (links_[path.back()].to != path.back()) path.push_back(links_[path.back()].to);
    Link root = {path.back(), 1};
    for (auto each = path.rbegin() + 1; each < path.rend(); ++each) {
        root.factor *= links_[*each].factor;
        links_[*each] = root;
    }
    return root;
}

void DesignVariables::freeze(Index vertex, int axis) {
    isFrozen_[rootOf(coordinate(vertex, axis)).to] = 1;
}

void DesignVariables::freeze(Index vertex) {
    for (int axis = 0; axis < 3; ++axis) freeze(vertex, axis);
}

void DesignVariables::scale(Index vertex, int axis, double unit) {
    requireScale("unit", unit);
    const Link root = rootOf(coordinate(vertex, axis));
    const double ofRoot = unit / root.factor;
    if (!std::isnormal(ofRoot))
        throw Error(concat("vertex ", vertex, " cannot be scaled by ", unit));
    units_[root.to] = ofRoot;
}

void DesignVariables::scale(Index vertex, double unit) {
    for (int axis = 0; axis < 3; ++axis) scale(vertex, axis, unit);
}

/// Returns the factor between the roots of two coordinates if the first is to be `factor` times the
/// other.
double DesignVariables::joinedFactor(Index coordinate, Index to, double factor) {
    const double joined = factor * rootOf(to).factor / rootOf(coordinate).factor;
    if (!std::isnormal(joined) || !std::isnormal(1 / joined))
        throw Error(
            concat("vertices ", coordinate / 3, " and ", to / 3,
                   " cannot be linked: with their other links, the factor between them would be ",
                   joined));
    return joined;
}

void DesignVariables::join(Index coordinate, Index to, double factor) {
    const Link own = rootOf(coordinate), other = rootOf(to);
    if (own.to == other.to) {
        // x = own · root and x = factor · other · root. Unless the two factors are equal up to the
        // rounding of a few products, only 0 satisfies both.
        constexpr double kRounding = 1e-12;
        if (!(std::abs(own.factor - factor * other.factor) <= kRounding * std::abs(own.factor)))
            isFrozen_[own.to] = 1;
        return;
    }
    // The lower number stays the root, so that variables are in the order of coordinates.
    Link link = {other.to, joinedFactor(coordinate, to, factor)};
    Index from = own.to;
    if (from < link.to) {
        std::swap(from, link.to);
        link.factor = 1 / link.factor;
    }
    links_[from] = link;
    isFrozen_[link.to] = isFrozen_[link.to] || isFrozen_[from];
}

void DesignVariables::link(Index vertex, Index to, const std::array<double, 3>& factors) {
    for (const double factor : factors) requireScale("factors", factor);
    for (int axis = 0; axis < 3; ++axis)
        joinedFactor(coordinate(vertex, axis), coordinate(to, axis), factors[axis]);
    for (int axis = 0; axis < 3; ++axis)
        join(coordinate(vertex, axis), coordinate(to, axis), factors[axis]);
}

void DesignVariables::mirror(std::span<const Point3> positions, int axis, double at,
                             double tolerance) {
    if (3 * positions.size() != links_.size())
        throw Error(
            concat("got ", positions.size(), " positions for ", links_.size() / 3, " vertices"));
    const std::vector<Index> images = shapes::mirrorImages(positions, axis, at, tolerance);
    for (std::size_t vertex = 0; vertex < images.size(); ++vertex)
        if (images[vertex] < 0)
            throw Error(concat(
                "vertex ", vertex, " has ",
                images[vertex] == shapes::kNoImage ? "no mirror image" : "several mirror images",
                " within ", tolerance));
    std::array<double, 3> factors = {1, 1, 1};
    factors[axis] = -1;
    for (std::size_t vertex = 0; vertex < images.size(); ++vertex)
        link(static_cast<Index>(vertex), images[vertex], factors);
}

stencils::StencilTable<double> DesignVariables::matrix() const {
    // Links lead to lower numbers, which are resolved already.
    std::vector<Link> roots(links_.size());
    std::vector<Index> variables(links_.size(), 0);
    Index count = 0;
    Array<Offset> offsets = {0};
    Array<Index> columns;
    Array<double> weights;
    for (std::size_t i = 0; i < links_.size(); ++i) {
        const Link& link = links_[i];
        const bool isRoot = link.to == static_cast<Index>(i);
        const Link& next = roots[link.to];
        roots[i] = isRoot ? link : Link{next.to, link.factor * next.factor};
        if (isRoot && !isFrozen_[i]) variables[i] = count++;
        if (!isFrozen_[roots[i].to]) {
            columns.push_back(variables[roots[i].to]);
            weights.push_back(roots[i].factor * units_[roots[i].to]);
        }
        offsets.push_back(static_cast<Offset>(columns.size()));
    }
    return {count, std::move(offsets), std::move(columns), std::move(weights)};
}

stencils::StencilTable<double> buildJacobian(const stencils::StencilTable<double>& deformation,
                                             const stencils::StencilTable<double>& design) {
    if (Offset{design.rowCount()} != 3 * Offset{deformation.columnCount()})
        throw Error(concat("the design is of ", design.rowCount(),
                           " coordinates; expected three for each of ", deformation.columnCount(),
                           " vertices"));
    if (deformation.rowCount() > kMaxIndex / 3)
        throw Error(concat("cannot number the coordinates of ", deformation.rowCount(), " points"));
    return stencils::buildTable(3 * deformation.rowCount(), design.columnCount(),
                                [&](Index row, stencils::RowAccumulator& sums) {
                                    const auto vertices = deformation.columns(row / 3);
                                    for (std::size_t k = 0; k < vertices.size(); ++k) {
                                        const double weight = deformation.weights(row / 3)[k];
                                        const Index coordinate = 3 * vertices[k] + row % 3;
                                        const auto variables = design.columns(coordinate);
                                        for (std::size_t j = 0; j < variables.size(); ++j)
                                            sums.add(variables[j],
                                                     weight * design.weights(coordinate)[j]);
                                    }
                                });
}

}  // namespace espalier::solve

// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/bind/bind.h>
#include <espalier/embed/row_bound.h>
#include <espalier/embed/tensor_product.h>
#include <espalier/far/topology_match.h>

#include <algorithm>
#include <string>
#include <utility>

namespace espalier::bind {
namespace {

/// Binds points to each kind of target. The points and the lattice at rest are added later.
struct Binder {
    const embed::RestLattice& lattice;
    std::span<const Point3> points;
    const BindOptions& options;

    Binding operator()(const Level& target) const {
        const embed::BindingOptions chosen = embedding(target.level);
        Binding binding = made(embed::bindPoints(lattice, points, chosen));
        if (!target.factors) return binding;
        auto factors = embed::bindFactored(lattice, points,
                                           {.level = target.level, .embedding = options.embedding})
                           .table;
        // The two searches may disagree at the tolerance. A point that stays in place by D does so
        // by the factors.
        factors.points = embed::emptyRows(std::move(factors.points), binding.table.emptyRows());
        binding.factors = std::move(factors);
        return binding;
    }

    Binding operator()(const Limit& target) const {
        return made(limit::bindLimit(lattice, points,
                                     {.embedding = options.embedding,
                                      .tolerance = target.tolerance,
                                      .gradients = options.gradients,
                                      .progress = options.progress}));
    }

    Binding operator()(embed::Basis basis) const {
        // Without the marks the deformation would be another one than the lattice asks for.
        if (!lattice.base.options().marks.empty())
            throw Error(
                "the lattice has marks (sharpness of edges or vertices), which only subdivision "
                "applies; bind with subdivision, or remove the marks");
        const embed::TensorLattice tensor(lattice.base.level(0).complex, lattice.positions, basis);
        return made(embed::bindPoints(tensor, points, embedding()));
    }

private:
    embed::BindingOptions embedding(int level = 1) const {
        return {level, options.embedding, options.gradients, options.progress};
    }

    static Binding made(embed::BoundRows<> bound) {
        Binding binding{std::move(bound.table)};
        binding.statuses = std::move(bound.statuses);
        binding.largestResidual = bound.largestResidual;
        binding.gradients = std::move(bound.gradients);
        return binding;
    }
};

}  // namespace

Index Binding::count(embed::PointStatus status) const {
    return static_cast<Index>(std::ranges::count(statuses, status));
}

void Binding::checkParts() const {
    const Index rows = table.rowCount(), columns = table.columnCount();
    const auto refuse = [&](const std::string& what) {
        throw Error(
            concat("a binding of ", rows, " points and ", columns, " lattice vertices has ", what));
    };
    const auto checkShape = [&](const char* what, Index ownRows, Index ownColumns) {
        if (ownRows != rows || ownColumns != columns)
            refuse(concat(what, " of ", ownRows, " points and ", ownColumns, " vertices"));
    };
    if (gradients) {
        checkShape("gradients", gradients->rowCount(), gradients->columnCount());
        gradients->check();
    }
    if (factors) checkShape("factors", factors->points.rowCount(), factors->vertices.columnCount());
    if (std::ssize(points) != rows) refuse(concat(points.size(), " points at rest"));
    if (std::ssize(rest) != columns) refuse(concat(rest.size(), " vertices at rest"));
    if (std::ssize(statuses) != rows) refuse(concat(statuses.size(), " statuses"));
}

Binding bindPoints(const embed::RestLattice& lattice, std::span<const Point3> points,
                   const Target& target, const BindOptions& options) {
    Binding binding = std::visit(Binder{lattice, points, options}, target);
    binding.topologyHash = far::topologyHash(lattice.base.level(0).complex);
    binding.points.assign(points.begin(), points.end());
    binding.rest.assign(lattice.positions.begin(), lattice.positions.end());
    return binding;
}

}  // namespace espalier::bind

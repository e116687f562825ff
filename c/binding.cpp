// SPDX-License-Identifier: Apache-2.0
#include <espalier/bind/bind.h>
#include <espalier/io/files/file.h>
#include <espalier/io/pose_file.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/shapes/refiner_options.h>

#include <cstring>
#include <utility>
#include <vector>

#include "handles.h"

using namespace espalier;

static_assert(static_cast<int>(embed::OutsidePolicy::Nearest) == ESPALIER_OUTSIDE_NEAREST);
static_assert(static_cast<int>(embed::OutsidePolicy::Error) == ESPALIER_OUTSIDE_REFUSE);
static_assert(static_cast<int>(embed::PointStatus::Inside) == ESPALIER_POINT_INSIDE);
static_assert(static_cast<int>(embed::PointStatus::Outside) == ESPALIER_POINT_OUTSIDE);
static_assert(static_cast<int>(embed::PointStatus::NotConverged) == ESPALIER_POINT_NOT_CONVERGED);
static_assert(static_cast<int>(embed::PointStatus::NotBound) == ESPALIER_POINT_NOT_BOUND);
static_assert(static_cast<int>(embed::Basis::BSpline) == ESPALIER_BASIS_BSPLINE);
static_assert(sizeof(embed::PointStatus) == sizeof(std::uint8_t));

namespace espalier::c {
namespace {

/// Returns what to bind to: the limit if it has a tolerance, else a level.
bind::Target targetOf(const espalier_bind_options& chosen) {
    if (chosen.limit_tolerance != 0) return bind::Limit{chosen.limit_tolerance};
    return bind::Level{chosen.level};
}

espalier_binding* newBinding(io::BoundModel model) {
    return new espalier_binding{std::make_shared<const io::BoundModel>(std::move(model))};
}

/// \param pointCount number of points
bind::PointWeights weightsOf(const espalier_bind_options& chosen, std::size_t pointCount) {
    bind::PointWeights weights;
    const auto count = static_cast<std::int64_t>(pointCount);
    if (chosen.weights != nullptr) {
        const auto values = array(chosen.weights, count, "weights");
        weights.values.assign(values.begin(), values.end());
    }
    if (chosen.weight_slopes != nullptr)
        weights.slopes = positions(chosen.weight_slopes, count, "weight_slopes");
    return weights;
}

espalier_binding* bindTo(const embed::RestLattice& lattice, std::span<const Point3> points,
                         const bind::Target& target, const espalier_bind_options& chosen) {
    io::BoundModel model{
        bind::bindPoints(lattice, points, target,
                         {.embedding = embeddingOptions(chosen),
                          .gradients = choice(chosen.gradients, 1, "gradients") != 0,
                          .weights = weightsOf(chosen, points.size()),
                          .falloff = chosen.falloff}),
        {},
        {},
        io::facesOf(lattice.base.level(0).complex)};
    return newBinding(std::move(model));
}

const bind::Binding& bindingOf(const espalier_binding* binding) {
    return deref(binding, "binding").model->binding;
}

}  // namespace
}  // namespace espalier::c

espalier_status espalier_binding_create(const espalier_refiner* refiner, int32_t vertex_count,
                                        const double* positions, int32_t point_count,
                                        const double* points, const espalier_bind_options* options,
                                        espalier_binding** binding) {
    return c::result(binding, "binding", [&] {
        const auto& own = c::deref(refiner, "refiner");
        c::checkCount(vertex_count, own.refiner.level(0).complex.count(0), "positions of vertices");
        const auto rest = c::positions(positions, vertex_count, "positions");
        const auto model = c::positions(points, point_count, "points");
        const auto chosen = c::bindOptions(options);
        const bind::Target target = c::targetOf(chosen);
        const far::TopologyRefiner base = c::baseOf(own.refiner);
        return c::bindTo({base, rest}, model, target, chosen);
    });
}

espalier_status espalier_binding_create_tensor(const espalier_lattice* lattice, int32_t basis,
                                               int32_t point_count, const double* points,
                                               const espalier_bind_options* options,
                                               espalier_binding** binding) {
    return c::result(binding, "binding", [&] {
        const auto& own = c::deref(lattice, "lattice").lattice;
        const auto chosenBasis = c::choice(basis, embed::Basis::BSpline, "basis");
        const auto model = c::positions(points, point_count, "points");
        const auto chosen = c::bindOptions(options);
        c::checkNoLimit(chosen, "this basis has no levels and no limit");
        const far::TopologyRefiner base(own.complex, refinerOptions(own));
        return c::bindTo({base, own.positions}, model, chosenBasis, chosen);
    });
}

void espalier_binding_destroy(espalier_binding* binding) {
    delete binding;
}

espalier_status espalier_binding_save(const espalier_binding* binding, const char* path) {
    return c::guarded([&] {
        const io::BoundModel& own = *c::deref(binding, "binding").model;
        io::writeBoundModel(&c::deref(path, "path"), own);
    });
}

espalier_status espalier_binding_load(const char* path, espalier_binding** binding) {
    return c::result(binding, "binding",
                     [&] { return c::newBinding(io::readBoundModel(&c::deref(path, "path"))); });
}

espalier_status espalier_binding_table(const espalier_binding* binding, espalier_table** table) {
    return c::result(table, "table", [&] {
        const auto& own = c::deref(binding, "binding").model;
        return new espalier_table{{own, &own->binding.table}};
    });
}

espalier_status espalier_binding_topology_hash(const espalier_binding* binding, uint64_t* hash) {
    return c::result(hash, "hash", [&] { return c::bindingOf(binding).topologyHash; });
}

espalier_status espalier_binding_statuses(const espalier_binding* binding, int32_t* point_count,
                                          const uint8_t** statuses) {
    return c::guarded([&] {
        const auto& own = c::bindingOf(binding).statuses;
        auto& count = c::deref(point_count, "point_count");
        // PointStatus has the underlying type std::uint8_t, so its array can be read as bytes.
        c::deref(statuses, "statuses") = reinterpret_cast<const std::uint8_t*>(own.data());
        count = static_cast<std::int32_t>(own.size());
    });
}

espalier_status espalier_binding_largest_residual(const espalier_binding* binding,
                                                  double* residual) {
    return c::result(residual, "residual", [&] { return c::bindingOf(binding).largestResidual; });
}

espalier_status espalier_binding_rest(const espalier_binding* binding, int32_t* vertex_count,
                                      const double** vertices, int32_t* point_count,
                                      const double** points) {
    return c::guarded([&] {
        const bind::Binding& own = c::bindingOf(binding);
        auto& vertexCount = c::deref(vertex_count, "vertex_count");
        auto& outVertices = c::deref(vertices, "vertices");
        auto& pointCount = c::deref(point_count, "point_count");
        auto& outPoints = c::deref(points, "points");
        outVertices = c::numbers(own.rest);
        outPoints = c::numbers(own.points);
        vertexCount = static_cast<std::int32_t>(own.rest.size());
        pointCount = static_cast<std::int32_t>(own.points.size());
    });
}

espalier_status espalier_binding_apply(const espalier_binding* binding, int32_t vertex_count,
                                       const double* pose, int32_t point_count, double* points) {
    return c::guarded([&] {
        const bind::Binding& own = c::bindingOf(binding);
        const auto& table = own.table;
        c::checkCount(vertex_count, table.columnCount(), "positions of vertices");
        const auto from = c::finitePositions(pose, vertex_count, "pose");
        c::checkCount(point_count, table.rowCount(), "points in the array for the result");
        c::array(points, point_count, "points", 3);
        const auto moved = osd::evaluateBinding(own, from);
        if (!moved.empty()) std::memcpy(points, moved.data(), moved.size() * sizeof(Point3));
    });
}

espalier_status espalier_binding_gradients(const espalier_binding* binding, int32_t vertex_count,
                                           const double* pose, int32_t point_count,
                                           double* gradients) {
    return c::guarded([&] {
        const bind::Binding& own = c::bindingOf(binding);
        if (!own.gradients)
            throw Error(
                "the binding has no gradients; make it with gradients of espalier_bind_options");
        c::checkCount(vertex_count, own.table.columnCount(), "positions of vertices");
        const auto from = c::finitePositions(pose, vertex_count, "pose");
        c::checkCount(point_count, own.table.rowCount(), "points in the array");
        c::array(gradients, point_count, "gradients", 9);
        const auto found = osd::evaluateGradients(own, from);
        if (!found.empty())
            std::memcpy(gradients, found.data(), found.size() * sizeof(DeformationGradient));
    });
}

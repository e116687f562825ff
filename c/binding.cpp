// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/local_binding.h>
#include <espalier/embed/tensor_product.h>
#include <espalier/io/files/file.h>
#include <espalier/io/pose_file.h>
#include <espalier/limit/limit_binding.h>
#include <espalier/osd/binding_evaluator.h>

#include <cstring>
#include <optional>
#include <utility>

#include "handles.h"

using namespace espalier;

static_assert(static_cast<int>(embed::OutsidePolicy::Nearest) == ESPALIER_OUTSIDE_NEAREST);
static_assert(static_cast<int>(embed::OutsidePolicy::Error) == ESPALIER_OUTSIDE_REFUSE);
static_assert(static_cast<int>(embed::PointStatus::Inside) == ESPALIER_POINT_INSIDE);
static_assert(static_cast<int>(embed::PointStatus::Outside) == ESPALIER_POINT_OUTSIDE);
static_assert(static_cast<int>(embed::PointStatus::NotConverged) == ESPALIER_POINT_NOT_CONVERGED);
static_assert(static_cast<int>(embed::Basis::BSpline) == ESPALIER_BASIS_BSPLINE);
static_assert(sizeof(embed::PointStatus) == sizeof(std::uint8_t));

namespace espalier::c {
namespace {

struct Bound {
    embed::BindingResult points;
    std::optional<io::BoundGradients> gradients = {};
};

Bound bind(const espalier_refiner& refiner, std::span<const Point3> positions,
           std::span<const Point3> points, const espalier_bind_options& chosen) {
    const bool withGradients = choice(chosen.gradients, 1, "gradients") != 0;
    const auto options = embeddingOptions(chosen);
    const far::TopologyRefiner base = baseOf(refiner.refiner);
    if (chosen.limit_tolerance == 0) {
        if (withGradients)
            throw Error("only a binding to the limit has gradients; set limit_tolerance");
        return {embed::bindPoints({base, positions}, points,
                                  {.level = chosen.level, .embedding = options})};
    }
    auto bound = limit::bindLimit(
        {base, positions}, points,
        {.embedding = options, .tolerance = chosen.limit_tolerance, .gradients = withGradients});
    Bound result;
    if (withGradients) result.gradients = {std::move(bound.binding.table.gradients)};
    result.points = limit::withoutGradients(std::move(bound));
    return result;
}

espalier_binding* newBinding(espalier_binding::Data data) {
    return new espalier_binding{std::make_shared<const espalier_binding::Data>(std::move(data))};
}

espalier_binding* newBinding(embed::BindingResult result, const far::CellComplex& lattice,
                             std::vector<Point3> rest, std::vector<Point3> points,
                             std::optional<io::BoundGradients> gradients = {}) {
    espalier_binding::Data data{{std::move(result.binding), {}, {}}};
    data.model.rest = std::move(rest);
    data.model.faces = io::facesOf(lattice);
    data.model.gradients = std::move(gradients);
    data.points = std::move(points);
    data.statuses = std::move(result.statuses);
    data.largestResidual = result.largestResidual;
    return newBinding(std::move(data));
}

const espalier_binding::Data& dataOf(const espalier_binding* binding) {
    return *deref(binding, "binding").data;
}

const espalier_binding::Data& placedDataOf(const espalier_binding* binding) {
    const auto& own = dataOf(binding);
    if (!own.largestResidual)
        throw Error("the binding was loaded from a file, which does not say how points were found");
    return own;
}

/// Returns true if the points and the lattice at rest are known.
bool knowsRest(const espalier_binding::Data& own) {
    return own.points && std::ssize(own.model.rest) == own.model.binding.table.columnCount();
}

template <class Real>
espalier_status putKept(const espalier_binding* binding, Real* destination, int64_t size,
                        const espalier_buffer_layout& layout) {
    return guarded([&] {
        const auto& own = dataOf(binding).model.binding;
        const auto to = array(destination, size, "destination");
        osd::writeKept<Real>(own, to, {layout.offset, layout.length, layout.stride});
    });
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
        auto rest = c::positions(positions, vertex_count, "positions");
        auto model = c::positions(points, point_count, "points");
        auto bound = c::bind(own, rest, model, c::bindOptions(options));
        return c::newBinding(std::move(bound.points), own.refiner.level(0).complex, std::move(rest),
                             std::move(model), std::move(bound.gradients));
    });
}

espalier_status espalier_binding_create_tensor(const espalier_lattice* lattice, int32_t basis,
                                               int32_t point_count, const double* points,
                                               const espalier_bind_options* options,
                                               espalier_binding** binding) {
    return c::result(binding, "binding", [&] {
        const auto& own = c::deref(lattice, "lattice").lattice;
        const auto chosenBasis = c::choice(basis, embed::Basis::BSpline, "basis");
        auto model = c::positions(points, point_count, "points");
        const auto chosen = c::levelBindOptions(options, "this basis has no levels and no limit");
        if (!own.marks.empty())
            throw Error(
                "the lattice has marks (sharpness of edges or vertices), which only subdivision "
                "applies; clear them");
        const embed::TensorLattice tensor(own.complex, own.positions, chosenBasis);
        auto bound = embed::bindPoints(tensor, model, c::embeddingOptions(chosen));
        return c::newBinding(std::move(bound), own.complex, own.positions, std::move(model));
    });
}

void espalier_binding_destroy(espalier_binding* binding) {
    delete binding;
}

espalier_status espalier_binding_save(const espalier_binding* binding, const char* path) {
    return c::guarded([&] {
        const auto& own = c::dataOf(binding);
        io::writeBoundModel(
            &c::deref(path, "path"), own.model,
            own.points ? std::span<const Point3>(*own.points) : std::span<const Point3>());
    });
}

espalier_status espalier_binding_load(const char* path, espalier_binding** binding) {
    return c::result(binding, "binding", [&] {
        espalier_binding::Data data{io::readBoundModel(&c::deref(path, "path"))};
        data.points = io::pointsAtRest(data.model, path);
        return c::newBinding(std::move(data));
    });
}

espalier_status espalier_binding_table(const espalier_binding* binding, espalier_table** table) {
    return c::result(table, "table", [&] {
        const auto& own = c::deref(binding, "binding").data;
        return new espalier_table{{own, &own->model.binding.table}};
    });
}

espalier_status espalier_binding_topology_hash(const espalier_binding* binding, uint64_t* hash) {
    return c::result(hash, "hash", [&] { return c::dataOf(binding).model.binding.topologyHash; });
}

espalier_status espalier_binding_statuses(const espalier_binding* binding, int32_t* point_count,
                                          const uint8_t** statuses) {
    return c::guarded([&] {
        const auto& own = c::placedDataOf(binding).statuses;
        auto& count = c::deref(point_count, "point_count");
        // PointStatus has the underlying type std::uint8_t, so its array can be read as bytes.
        c::deref(statuses, "statuses") = reinterpret_cast<const std::uint8_t*>(own.data());
        count = static_cast<std::int32_t>(own.size());
    });
}

espalier_status espalier_binding_largest_residual(const espalier_binding* binding,
                                                  double* residual) {
    return c::result(residual, "residual",
                     [&] { return *c::placedDataOf(binding).largestResidual; });
}

espalier_status espalier_binding_kept(const espalier_binding* binding, int32_t* count,
                                      const int32_t** points, const double** positions) {
    return c::guarded([&] {
        const auto& own = c::dataOf(binding).model.binding;
        auto& outCount = c::deref(count, "count");
        auto& outPoints = c::deref(points, "points");
        auto& outPositions = c::deref(positions, "positions");
        outCount = static_cast<std::int32_t>(own.kept.size());
        outPoints = own.kept.data();
        outPositions = c::numbers(own.keptAt);
    });
}

espalier_status espalier_binding_rest(const espalier_binding* binding, int32_t* vertex_count,
                                      const double** vertices, int32_t* point_count,
                                      const double** points) {
    return c::guarded([&] {
        const auto& own = c::dataOf(binding);
        auto& vertexCount = c::deref(vertex_count, "vertex_count");
        auto& outVertices = c::deref(vertices, "vertices");
        auto& pointCount = c::deref(point_count, "point_count");
        auto& outPoints = c::deref(points, "points");
        if (!c::knowsRest(own))
            throw Error(
                "the binding was loaded from a file that does not have the points and the lattice "
                "at rest");
        outVertices = c::numbers(own.model.rest);
        outPoints = c::numbers(*own.points);
        vertexCount = static_cast<std::int32_t>(own.model.rest.size());
        pointCount = static_cast<std::int32_t>(own.points->size());
    });
}

espalier_status espalier_binding_apply(const espalier_binding* binding, int32_t vertex_count,
                                       const double* pose, int32_t point_count, double* points) {
    return c::guarded([&] {
        const auto& own = c::dataOf(binding);
        const auto& table = own.model.binding.table;
        c::checkCount(vertex_count, table.columnCount(), "positions of vertices");
        const auto from = c::finitePositions(pose, vertex_count, "pose");
        c::checkCount(point_count, table.rowCount(), "points in the array for the result");
        c::array(points, point_count, "points", 3);
        const auto moved =
            c::knowsRest(own)
                ? osd::evaluateBinding(own.model.binding, {*own.points, own.model.rest}, from)
                : osd::evaluateBinding(own.model.binding, std::span<const Point3>(from));
        if (!moved.empty()) std::memcpy(points, moved.data(), moved.size() * sizeof(Point3));
    });
}

espalier_status espalier_binding_gradients(const espalier_binding* binding, int32_t vertex_count,
                                           const double* pose, int32_t point_count,
                                           double* gradients) {
    return c::guarded([&] {
        const auto& own = c::dataOf(binding).model;
        if (!own.gradients)
            throw Error(
                "the binding has no gradients; make it with limit_tolerance and gradients of "
                "espalier_bind_options");
        c::checkCount(vertex_count, own.binding.table.columnCount(), "positions of vertices");
        const auto from = c::finitePositions(pose, vertex_count, "pose");
        c::checkCount(point_count, own.binding.table.rowCount(), "points in the array");
        c::array(gradients, point_count, "gradients", 9);
        const auto found = osd::evaluateGradients(own.gradients->tables, own.rest, from);
        if (!found.empty())
            std::memcpy(gradients, found.data(), found.size() * sizeof(DeformationGradient));
    });
}

espalier_status espalier_binding_put_kept_f64(const espalier_binding* binding, double* destination,
                                              int64_t destination_size,
                                              espalier_buffer_layout layout) {
    return c::putKept(binding, destination, destination_size, layout);
}

espalier_status espalier_binding_put_kept_f32(const espalier_binding* binding, float* destination,
                                              int64_t destination_size,
                                              espalier_buffer_layout layout) {
    return c::putKept(binding, destination, destination_size, layout);
}

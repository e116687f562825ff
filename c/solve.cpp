// SPDX-License-Identifier: Apache-2.0
// Implements espalier_solve.h: fitting, holding and validity.
#include <espalier/embed/continuity.h>
#include <espalier/shapes/held.h>
#include <espalier/solve/lattice_fit.h>
#include <espalier/solve/rigid_pull.h>
#include <espalier/solve/validity.h>
#include <espalier/stencils/composition.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "espalier_solve.h"
#include "handles.h"

using namespace espalier;

static_assert(static_cast<int>(solve::Smoothing::Laplacian) == ESPALIER_SMOOTHING_LAPLACIAN);
static_assert(static_cast<int>(solve::Undetermined::Refuse) == ESPALIER_UNDETERMINED_REFUSE);
static_assert(static_cast<int>(embed::Continuity::C2) == ESPALIER_CONTINUITY_C2);

struct espalier_validity {
    far::TopologyRefiner levels;  ///< the levels of the base lattice, up to `level`
    int level = 0;                ///< the level whose cells are checked; 0 for the limit
    solve::ValidityCheck check;
};

struct espalier_pull {
    solve::RigidPull pull;
    std::int32_t vertexCount = 0;
};

namespace espalier::c {
namespace {

/// Returns the vertices that a fit or a pull keeps.
std::vector<Index> frozenOf(const Lattice& lattice, std::span<const std::int32_t> frozen,
                            std::int64_t moveHeld) {
    if (moveHeld == 0) return shapes::frozenWithHeld(lattice, frozen);
    return {frozen.begin(), frozen.end()};
}

solve::RigidPullOptions pullOptions(const espalier_pull_options& chosen, const Lattice& lattice) {
    solve::RigidPullOptions options;
    const auto frozen = array(chosen.frozen, chosen.frozen_count, "frozen");
    options.frozen = frozenOf(lattice, frozen, chosen.move_held);
    const auto pins = array(chosen.pins, chosen.pin_count, "pins");
    options.pins.assign(pins.begin(), pins.end());
    options.reach = chosen.reach;
    options.tolerance = chosen.tolerance;
    options.maxIterations = chosen.max_iterations;
    return options;
}

solve::FitOptions fitOptions(const espalier_fit_options& chosen, const Lattice& lattice) {
    solve::FitOptions options;
    options.smoothing = choice(chosen.smoothing, solve::Smoothing::Laplacian, "smoothing");
    options.undetermined = choice(chosen.undetermined, solve::Undetermined::Refuse, "undetermined");
    options.strength = chosen.strength;
    const auto frozen = array(chosen.frozen, chosen.frozen_count, "frozen");
    options.frozen = frozenOf(lattice, frozen, chosen.move_held);
    return options;
}

embed::Continuity continuityOf(std::int32_t value) {
    return choice(value, embed::Continuity::C2, "continuity");
}

/// Writes the vertices that `find` returns to `held`. Throws first unless `held` has room for all
/// vertices of the lattice.
template <class Find>
void putHeld(std::int32_t capacity, std::int32_t all, std::int32_t* held, std::int32_t* count,
             const Find& find) {
    auto& outCount = deref(count, "held_count");
    checkCount(capacity, all, "vertices in the array for the result");
    const auto out = array(held, capacity, "held");
    const std::vector<Index> vertices = find();
    std::copy(vertices.begin(), vertices.end(), out.begin());
    outCount = static_cast<std::int32_t>(vertices.size());
}

std::vector<Point3> refined(const far::TopologyRefiner& levels, int level, const double* positions,
                            std::int32_t count, const char* name) {
    checkCount(count, levels.level(0).complex.count(0), "positions of vertices");
    return stencils::refinePositions(levels, level, c::positions(positions, count, name));
}

std::vector<Point3> posed(const espalier_validity& validity, const double* pose,
                          std::int32_t count) {
    return refined(validity.levels, validity.level, pose, count, "pose");
}

Index cellCount(const espalier_validity& validity) {
    return validity.levels.level(validity.level).complex.count(3);
}

espalier_validity* newValidity(const espalier_refiner& refiner, const double* positions,
                               std::int32_t count, const espalier_validity_options& chosen) {
    const bool isLimit = choice(chosen.of_limit, 1, "of_limit") != 0;
    if (!isLimit && chosen.level < 1)
        throw ArgumentError("", "level", std::to_string(chosen.level), "1 or more");
    far::TopologyRefiner levels = baseOf(refiner.refiner);
    const int level = isLimit ? 0 : chosen.level;
    // Checks the number of positions before anything is refined.
    const auto base = refined(levels, 0, positions, count, "positions");
    levels.refineUniform(level);
    auto check = isLimit ? solve::ValidityCheck(limit::LimitParts(levels, chosen.level), base)
                         : solve::ValidityCheck(levels.level(level).complex,
                                                stencils::refinePositions(levels, level, base));
    return new espalier_validity{std::move(levels), level, std::move(check)};
}

}  // namespace
}  // namespace espalier::c

espalier_status espalier_lattice_fit(const espalier_table* deformation,
                                     const espalier_lattice* lattice, int32_t target_count,
                                     const int32_t* rows, const double* misses,
                                     const espalier_fit_options* options, int32_t vertex_count,
                                     double* displacements, espalier_fit_quality* quality) {
    return c::guarded([&] {
        const auto& table = *c::deref(deformation, "deformation").table;
        const auto& complex = c::deref(lattice, "lattice").lattice.complex;
        c::checkCount(vertex_count, complex.count(0), "vertices in the array for the result");
        c::array(displacements, vertex_count, "displacements", 3);
        const auto chosen =
            c::fitOptions(c::optionsOrDefaults(options, espalier_default_fit_options(),
                                               "espalier_default_fit_options",
                                               offsetof(espalier_fit_options, move_held)),
                          lattice->lattice);
        const auto fit = c::withRows(table, target_count, rows, "targets", [&](const auto& some) {
            // withRows() has checked the number of misses, so they can be read here.
            const auto wanted = c::positions(misses, some.rowCount(), "misses");
            return solve::fitLattice(some, wanted, complex, chosen);
        });
        std::memcpy(displacements, fit.displacements.data(),
                    fit.displacements.size() * sizeof(Point3));
        if (quality != nullptr) *quality = {fit.largestMiss, fit.rmsMiss, fit.condition};
    });
}

espalier_status espalier_pull_create(const espalier_lattice* lattice, int32_t vertex_count,
                                     const double* positions, const espalier_table* deformation,
                                     int32_t point_count, const int32_t* rows,
                                     const espalier_pull_options* options, espalier_pull** pull) {
    return c::result(pull, "pull", [&] {
        const auto& complex = c::deref(lattice, "lattice").lattice.complex;
        const auto& table = *c::deref(deformation, "deformation").table;
        c::checkCount(vertex_count, complex.count(0), "positions of vertices");
        const auto rest = c::positions(positions, vertex_count, "positions");
        const auto chosen =
            c::pullOptions(c::optionsOrDefaults(options, espalier_default_pull_options(),
                                                "espalier_default_pull_options",
                                                offsetof(espalier_pull_options, move_held)),
                           lattice->lattice);
        return c::withRows(table, point_count, rows, "points", [&](const auto& some) {
            return new espalier_pull{solve::RigidPull(complex, rest, some, chosen), vertex_count};
        });
    });
}

void espalier_pull_destroy(espalier_pull* pull) {
    delete pull;
}

espalier_status espalier_pull_fixed(const espalier_pull* pull, int32_t* vertex_count,
                                    const int32_t** vertices) {
    return c::guarded([&] {
        const auto& fixed = c::deref(pull, "pull").pull.fixedVertices();
        auto& outCount = c::deref(vertex_count, "vertex_count");
        c::deref(vertices, "vertices") = fixed.data();
        outCount = static_cast<std::int32_t>(fixed.size());
    });
}

espalier_status espalier_pull_solve(const espalier_pull* pull, int32_t point_count,
                                    const double* misses, int32_t vertex_count, const double* start,
                                    double* displacements, espalier_pull_quality* quality) {
    return c::guarded([&] {
        const auto& own = c::deref(pull, "pull");
        c::checkCount(vertex_count, own.vertexCount, "vertices in the array for the result");
        c::array(displacements, vertex_count, "displacements", 3);
        const auto from =
            start == nullptr ? std::vector<Point3>() : c::positions(start, vertex_count, "start");
        const auto pose = own.pull.solve(c::positions(misses, point_count, "misses"), from);
        std::memcpy(displacements, pose.displacements.data(),
                    pose.displacements.size() * sizeof(Point3));
        if (quality != nullptr)
            *quality = {pose.largestMiss, pose.rmsMiss, pose.energy, pose.iterations,
                        pose.meetsBarrier ? 1 : 0};
    });
}

espalier_status espalier_hold_faces(const espalier_refiner* refiner, int32_t face_count,
                                    const int32_t* faces, int32_t continuity, int32_t vertex_count,
                                    int32_t* held, int32_t* held_count) {
    return c::guarded([&] {
        const auto& own = c::deref(refiner, "refiner");
        const auto some = c::array(faces, face_count, "faces");
        const auto wanted = c::continuityOf(continuity);
        const auto base = c::baseOf(own.refiner);
        c::putHeld(vertex_count, base.level(0).complex.count(0), held, held_count,
                   [&] { return embed::verticesHoldingFaces(base, some, wanted); });
    });
}

espalier_status espalier_hold_points(const espalier_refiner* refiner, int32_t vertex_count,
                                     const double* positions, int32_t point_count,
                                     const double* points, int32_t continuity,
                                     const espalier_bind_options* options, int32_t* held,
                                     int32_t* held_count) {
    return c::guarded([&] {
        const auto& own = c::deref(refiner, "refiner");
        const auto base = c::baseOf(own.refiner);
        const auto wanted = c::continuityOf(continuity);
        const auto chosen =
            c::levelBindOptions(options, "points are held in a level, not in the limit");
        c::checkCount(vertex_count, base.level(0).complex.count(0), "positions of vertices");
        const auto rest = c::positions(positions, vertex_count, "positions");
        const auto model = c::positions(points, point_count, "points");
        c::putHeld(vertex_count, vertex_count, held, held_count, [&] {
            return embed::verticesHoldingPoints(
                {base, rest}, model, wanted,
                {.level = chosen.level, .embedding = c::embeddingOptions(chosen)});
        });
    });
}

espalier_status espalier_hold_rows(const espalier_table* deformation, int32_t row_count,
                                   const int32_t* rows, int32_t vertex_count, int32_t* held,
                                   int32_t* held_count) {
    return c::guarded([&] {
        const auto& table = *c::deref(deformation, "deformation").table;
        c::putHeld(vertex_count, table.columnCount(), held, held_count, [&] {
            return c::withRows(table, row_count, rows, "rows",
                               [](const auto& some) { return embed::verticesHoldingRows(some); });
        });
    });
}

espalier_status espalier_validity_create(const espalier_refiner* refiner, int32_t vertex_count,
                                         const double* positions,
                                         const espalier_validity_options* options,
                                         espalier_validity** validity) {
    return c::result(validity, "validity", [&] {
        const auto& own = c::deref(refiner, "refiner");
        const auto chosen = c::optionsOrDefaults(options, espalier_default_validity_options(),
                                                 "espalier_default_validity_options");
        return c::newValidity(own, positions, vertex_count, chosen);
    });
}

void espalier_validity_destroy(espalier_validity* validity) {
    delete validity;
}

espalier_status espalier_validity_bad_at_rest(const espalier_validity* validity,
                                              int32_t* cell_count, const int32_t** cells) {
    return c::guarded([&] {
        const auto& own = c::deref(validity, "validity").check.badAtRest();
        auto& outCount = c::deref(cell_count, "cell_count");
        c::deref(cells, "cells") = own.data();
        outCount = static_cast<std::int32_t>(own.size());
    });
}

espalier_status espalier_validity_cell_count(const espalier_validity* validity,
                                             int32_t* cell_count) {
    return c::guarded([&] {
        const auto& own = c::deref(validity, "validity");
        c::deref(cell_count, "cell_count") = c::cellCount(own);
    });
}

espalier_status espalier_validity_base_cell(const espalier_validity* validity, int32_t cell,
                                            int32_t* base_cell) {
    return c::guarded([&] {
        const auto& own = c::deref(validity, "validity");
        auto& out = c::deref(base_cell, "base_cell");
        const Index count = c::cellCount(own);
        if (cell < 0 || cell >= count)
            throw Error(
                concat("there is no cell ", cell, "; there are ", count, ", numbered from 0"));
        out = solve::baseCellOf(own.levels, own.level, cell);
    });
}

espalier_status espalier_validity_check(const espalier_validity* validity, int32_t vertex_count,
                                        const double* pose, int32_t cell_count, double* ratios,
                                        espalier_pose_validity* result) {
    return c::guarded([&] {
        const auto& own = c::deref(validity, "validity");
        auto& out = c::deref(result, "result");
        if (ratios != nullptr)
            c::checkCount(cell_count, c::cellCount(own), "cells in the array for the ratios");
        const auto found = own.check.check(c::posed(own, pose, vertex_count));
        const double none = std::numeric_limits<double>::quiet_NaN();
        if (ratios != nullptr)
            for (const auto& ratio : found.ratios) *ratios++ = ratio.value_or(none);
        out.inverted_count = static_cast<std::int32_t>(found.inverted.size());
        out.smallest_cell = found.smallest ? found.smallest->cell : -1;
        out.smallest_ratio = found.smallest ? found.smallest->value : none;
    });
}

espalier_status espalier_validity_largest_step(const espalier_validity* validity,
                                               int32_t vertex_count, const double* pose,
                                               double max_step, espalier_largest_step* step) {
    return c::guarded([&] {
        const auto& own = c::deref(validity, "validity");
        auto& out = c::deref(step, "step");
        const auto found = own.check.largestStep(c::posed(own, pose, vertex_count), max_step);
        out = {found.length, found.limitingCell.value_or(-1), found.isTight ? 1 : 0};
    });
}

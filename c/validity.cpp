// SPDX-License-Identifier: Apache-2.0
#include <espalier/solve/validity.h>
#include <espalier/stencils/composition.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "bind_options.h"
#include "espalier_solve.h"
#include "guard.h"
#include "handles.h"

using namespace espalier;

struct espalier_validity {
    far::TopologyRefiner levels;  ///< of the base, up to `level`
    stencils::Rules rules;
    int level = 0;  ///< of the cells; 0 for the limit
    solve::ValidityCheck check;
};

namespace espalier::c {
namespace {

std::vector<Point3> refined(const far::TopologyRefiner& levels, int level, stencils::Rules rules,
                            const double* positions, std::int32_t count, const char* name) {
    checkCount(count, levels.level(0).complex.count(0), "positions of vertices");
    return stencils::refinePositions(levels, level, rules, c::positions(positions, count, name));
}

std::vector<Point3> posed(const espalier_validity& validity, const double* pose,
                          std::int32_t count) {
    return refined(validity.levels, validity.level, validity.rules, pose, count, "pose");
}

Index cellCount(const espalier_validity& validity) {
    return validity.levels.level(validity.level).complex.count(3);
}

espalier_validity* newValidity(const espalier_refiner& refiner, const double* positions,
                               std::int32_t count, const espalier_validity_options& chosen) {
    const bool isLimit = choice(chosen.of_limit, 1, "of_limit") != 0;
    if (!isLimit && chosen.level < 1)
        throw Error("level is " + std::to_string(chosen.level) + "; expected 1 or more");
    far::TopologyRefiner levels = baseOf(refiner.refiner);
    const int level = isLimit ? 0 : chosen.level;
    // Checks the number of positions before anything is refined.
    const auto base = refined(levels, 0, refiner.rules, positions, count, "positions");
    levels.refineUniform(level);
    auto check =
        isLimit
            ? solve::ValidityCheck(limit::LimitParts(levels, refiner.rules, chosen.level), base)
            : solve::ValidityCheck(levels.level(level).complex,
                                   stencils::refinePositions(levels, level, refiner.rules, base));
    return new espalier_validity{std::move(levels), refiner.rules, level, std::move(check)};
}

}  // namespace
}  // namespace espalier::c

espalier_status espalier_validity_create(const espalier_refiner* refiner, int32_t vertex_count,
                                         const double* positions,
                                         const espalier_validity_options* options,
                                         espalier_validity** validity) {
    return c::guarded([&] {
        auto& out = c::deref(validity, "validity");
        const auto& own = c::deref(refiner, "refiner");
        const auto chosen =
            c::optionsOr(options, espalier_default_validity_options(),
                         sizeof(espalier_validity_options), "espalier_default_validity_options");
        out = c::newValidity(own, positions, vertex_count, chosen);
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
            throw Error("there is no cell " + std::to_string(cell) + " among " +
                        std::to_string(count));
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
            c::checkCount(cell_count, c::cellCount(own), "cells of room for the ratios");
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
                                               double most, espalier_largest_step* step) {
    return c::guarded([&] {
        const auto& own = c::deref(validity, "validity");
        auto& out = c::deref(step, "step");
        const auto found = own.check.largestStep(c::posed(own, pose, vertex_count), most);
        out = {found.length, found.limitingCell.value_or(-1), found.isTight ? 1 : 0};
    });
}

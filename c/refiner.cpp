// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>

#include <algorithm>

#include "handles.h"

using namespace espalier;

// choice() converts numbers from C by value, so the enumerations must have equal values.
static_assert(static_cast<int>(far::Rules::Cse96) == ESPALIER_RULES_CSE96);
static_assert(static_cast<int>(far::Rules::Mlca) == ESPALIER_RULES_MLCA);
static_assert(static_cast<int>(far::Boundary::EdgeOnly) == ESPALIER_BOUNDARY_EDGE_ONLY);
static_assert(static_cast<int>(far::Boundary::Open) == ESPALIER_BOUNDARY_OPEN);
static_assert(static_cast<int>(far::SharpEdges::Literal) == ESPALIER_SHARP_EDGES_LITERAL);
static_assert(static_cast<int>(far::Creasing::Chaikin) == ESPALIER_CREASING_CHAIKIN);
static_assert(static_cast<int>(far::TriangleSubdivision::Smooth) == ESPALIER_TRIANGLES_SMOOTH);
static_assert(far::kLeastInfinite == ESPALIER_SHARP);

namespace espalier::c {
namespace {

std::vector<std::int64_t> offsetsOf(const far::Incidence& relation) {
    std::vector<std::int64_t> offsets;
    offsets.reserve(relation.rowCount() + 1);
    for (Index row = 0; row <= relation.rowCount(); ++row) offsets.push_back(relation.offset(row));
    return offsets;
}

const espalier_refiner::LevelOffsets& offsetsOf(const espalier_refiner& refiner, int32_t level) {
    const far::CellComplex& complex = refiner.refiner.level(level).complex;
    // relation() may run a parallel loop, so it is called before the lock is taken.
    const far::Incidence& loops = complex.relation(2, 0);
    const std::lock_guard lock(refiner.offsetsMutex);
    const auto known = refiner.offsets.find(level);
    if (known != refiner.offsets.end()) return known->second;
    return refiner.offsets
        .emplace(level, espalier_refiner::LevelOffsets{offsetsOf(complex.relation(3, 2)),
                                                       offsetsOf(loops)})
        .first->second;
}

far::RefinerOptions refinerOptions(const espalier_refine_options& chosen, const Lattice& lattice) {
    const auto rules = choice(chosen.rules, far::Rules::Mlca, "rules");
    return espalier::refinerOptions(
        lattice,
        {choice(chosen.boundary, far::Boundary::Open, "boundary"),
         choice(chosen.creasing, far::Creasing::Chaikin, "creasing"),
         choice(chosen.triangles, far::TriangleSubdivision::Smooth, "triangles")},
        choice(chosen.sharp_edges, far::SharpEdges::Literal, "sharp_edges"), rules);
}

}  // namespace
}  // namespace espalier::c

espalier_status espalier_refiner_create(const espalier_lattice* lattice,
                                        const espalier_refine_options* options,
                                        espalier_refiner** refiner) {
    return c::result(refiner, "refiner", [&] {
        const Lattice& base = c::deref(lattice, "lattice").lattice;
        const auto chosen = c::optionsOrDefaults(options, espalier_default_refine_options(),
                                                 "espalier_default_refine_options");
        return new espalier_refiner{
            far::TopologyRefiner(base.complex, c::refinerOptions(chosen, base))};
    });
}

void espalier_refiner_destroy(espalier_refiner* refiner) {
    delete refiner;
}

espalier_status espalier_refiner_refine(espalier_refiner* refiner, int32_t level) {
    return c::guarded([&] {
        auto& own = c::deref(refiner, "refiner").refiner;
        if (level < 0) throw ArgumentError("", "level", std::to_string(level), "0 or more");
        own.refineUniform(level);
    });
}

espalier_status espalier_refiner_max_level(const espalier_refiner* refiner, int32_t* level) {
    return c::result(level, "level",
                     [&] { return c::deref(refiner, "refiner").refiner.maxLevel(); });
}

espalier_status espalier_refiner_counts(const espalier_refiner* refiner, int32_t level,
                                        int32_t counts[4]) {
    return c::guarded([&] {
        const auto& complex = c::deref(refiner, "refiner").refiner.level(level).complex;
        c::deref(counts, "counts");
        for (int d = 0; d <= kMaxDimension; ++d) counts[d] = complex.count(d);
    });
}

espalier_status espalier_refiner_cells(const espalier_refiner* refiner, int32_t level,
                                       espalier_cells* cells) {
    return c::guarded([&] {
        const auto& own = c::deref(refiner, "refiner");
        auto& out = c::deref(cells, "cells");
        const auto& offsets = c::offsetsOf(own, level);
        const auto& complex = own.refiner.level(level).complex;
        out = {complex.count(0),
               complex.count(2),
               complex.count(3),
               offsets.cells.data(),
               complex.relation(3, 2).values().data(),
               offsets.faces.data(),
               complex.relation(2, 0).values().data()};
    });
}

espalier_status espalier_refiner_face_signs(const espalier_refiner* refiner, int32_t level,
                                            const int8_t** signs) {
    return c::result(signs, "signs", [&] {
        const auto& complex = c::deref(refiner, "refiner").refiner.level(level).complex;
        return complex.boundary(3).signs().data();
    });
}

espalier_status espalier_refiner_edges(const espalier_refiner* refiner, int32_t level,
                                       int32_t* edge_count, const int32_t** ends) {
    return c::guarded([&] {
        const auto& complex = c::deref(refiner, "refiner").refiner.level(level).complex;
        auto& count = c::deref(edge_count, "edge_count");
        c::deref(ends, "ends") = complex.relation(1, 0).values().data();
        count = complex.count(1);
    });
}

espalier_status espalier_refiner_strata(const espalier_refiner* refiner, int32_t level,
                                        int32_t dimension, int32_t* count, const uint8_t** strata) {
    return c::guarded([&] {
        const auto& own = c::deref(refiner, "refiner").refiner.level(level);
        const auto chosen = c::choice(dimension, kMaxDimension, "dimension");
        auto& outCount = c::deref(count, "count");
        c::deref(strata, "strata") = own.strata.strata()[chosen].data();
        outCount = own.complex.count(chosen);
    });
}

espalier_status espalier_refiner_carry_values(const espalier_refiner* refiner, int32_t level,
                                              int32_t components, const double* values,
                                              int64_t size, double* result, int64_t result_size) {
    return c::guarded([&] {
        const auto& own = c::deref(refiner, "refiner");
        const auto from = c::array(values, size, "values");
        const auto to = c::array(result, result_size, "result");
        const auto countOf = [&](int each) -> std::int64_t {
            return own.refiner.level(each).complex.count(0);
        };
        if (components < 1)
            throw ArgumentError("", "components", std::to_string(components), "1 or more");
        c::checkCount(size, countOf(0) * components, "numbers on the vertices of the lattice");
        c::checkCount(result_size, countOf(level) * components,
                      "numbers in the array for the result");
        const auto carried = stencils::refineValues(own.refiner, level, from, components);
        std::copy(carried.begin(), carried.end(), to.begin());
    });
}

// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/nested_lattices.h>
#include <espalier/io/matrices/matrix_file.h>
#include <espalier/limit/limit_stencils.h>
#include <espalier/limit/vertex_limits.h>
#include <espalier/stencils/composition.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "handles.h"

using namespace espalier;

namespace espalier::c {
namespace {

espalier_table* newTable(stencils::StencilTable<double> table) {
    return new espalier_table{
        std::make_shared<const stencils::StencilTable<double>>(std::move(table))};
}

std::vector<limit::LimitLocation> limitLocations(std::int32_t count, const std::int32_t* cells,
                                                 const double* uvw) {
    const auto givenCells = array(cells, count, "cells");
    const auto givenPlaces = array(uvw, count, "uvw", 3);
    std::vector<limit::LimitLocation> locations(givenCells.size());
    for (std::size_t i = 0; i < locations.size(); ++i) {
        locations[i].cell = givenCells[i];
        std::copy_n(&givenPlaces[3 * i], 3, locations[i].uvw.begin());
    }
    return locations;
}

}  // namespace
}  // namespace espalier::c

espalier_status espalier_table_create_stencils(const espalier_refiner* refiner, int32_t level,
                                               espalier_table** table) {
    return c::result(table, "table", [&] {
        const auto& own = c::deref(refiner, "refiner");
        return c::newTable(stencils::buildStencils(own.refiner, level));
    });
}

espalier_status espalier_table_create_level(const espalier_refiner* refiner, int32_t level,
                                            espalier_table** table) {
    return c::result(table, "table", [&] {
        const auto& own = c::deref(refiner, "refiner");
        return c::newTable(stencils::buildLevelTable(own.refiner, level));
    });
}

espalier_status espalier_table_create_limits(const espalier_refiner* refiner, int32_t level,
                                             espalier_table** table) {
    return c::result(table, "table", [&] {
        const auto& own = c::deref(refiner, "refiner");
        return c::newTable(limit::buildVertexLimits(own.refiner, level));
    });
}

espalier_status espalier_table_create_limit_stencils(const espalier_refiner* refiner, int32_t level,
                                                     int32_t place_count, const int32_t* cells,
                                                     const double* uvw,
                                                     const espalier_limit_stencil_options* options,
                                                     int32_t table_count, espalier_table** tables) {
    return c::guarded([&] {
        const auto& own = c::deref(refiner, "refiner");
        const auto chosen = c::optionsOrDefaults(options, espalier_default_limit_stencil_options(),
                                                 "espalier_default_limit_stencil_options");
        if (chosen.derivatives < 0 || chosen.derivatives > 2)
            throw ArgumentError("", "derivatives", std::to_string(chosen.derivatives), "0 to 2");
        c::checkCount(table_count, ESPALIER_LIMIT_STENCIL_TABLES(chosen.derivatives),
                      "tables in the array for the result");
        const auto out = c::array(tables, table_count, "tables");
        auto made = limit::buildLimitStencils(
            own.refiner, level, c::limitLocations(place_count, cells, uvw),
            {.tolerance = chosen.tolerance, .derivatives = chosen.derivatives});
        std::vector<std::unique_ptr<espalier_table>> results;
        // emplace_back() must not allocate: if that failed, the table that was just made would
        // leak.
        results.reserve(out.size());
        results.emplace_back(c::newTable(std::move(made.position)));
        if (chosen.derivatives >= 1)
            for (auto& table : made.first) results.emplace_back(c::newTable(std::move(table)));
        if (chosen.derivatives >= 2)
            for (auto& table : made.second) results.emplace_back(c::newTable(std::move(table)));
        for (std::size_t i = 0; i < results.size(); ++i) out[i] = results[i].release();
    });
}

espalier_status espalier_table_write(const espalier_table* table, const char* path) {
    return c::guarded(
        [&] { io::writeMatrix(&c::deref(path, "path"), *c::deref(table, "table").table); });
}

espalier_status espalier_table_read(const char* path, espalier_table** table) {
    return c::result(table, "table",
                     [&] { return c::newTable(io::readMatrix(&c::deref(path, "path"))); });
}

espalier_status espalier_table_create_nested(
    const espalier_table* child, int32_t child_vertex_count, const double* child_pose,
    const espalier_refiner* parent, int32_t parent_vertex_count, const double* parent_positions,
    const espalier_bind_options* options, espalier_table** table) {
    return c::result(table, "table", [&] {
        const auto& own = *c::deref(child, "child").table;
        const auto& outer = c::deref(parent, "parent");
        const auto& complex = outer.refiner.level(0).complex;
        c::checkCount(child_vertex_count, own.columnCount(), "positions of the child's vertices");
        c::checkCount(parent_vertex_count, complex.count(0), "positions of the parent's vertices");
        const auto pose = c::positions(child_pose, child_vertex_count, "child_pose");
        const auto rest = c::positions(parent_positions, parent_vertex_count, "parent_positions");
        const auto chosen =
            c::levelBindOptions(options, "lattices nest in a level, not in the limit");
        return c::newTable(
            embed::nestTables(own, pose, {c::baseOf(outer.refiner), rest},
                              {.level = chosen.level, .embedding = c::embeddingOptions(chosen)}));
    });
}

void espalier_table_destroy(espalier_table* table) {
    delete table;
}

espalier_status espalier_table_csr(const espalier_table* table, espalier_csr* csr) {
    return c::guarded([&] {
        const auto& own = *c::deref(table, "table").table;
        c::deref(csr, "csr") = {own.rowCount(), own.columnCount(), own.offsets().data(),
                                own.columns().data(), own.weights().data()};
    });
}

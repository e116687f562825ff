// SPDX-License-Identifier: Apache-2.0
#include <espalier/stencils/composition.h>

#include <utility>

#include "arguments.h"
#include "guard.h"
#include "handles.h"

using namespace espalier;

namespace espalier::c {
namespace {

espalier_table* newTable(stencils::StencilTable<double> table) {
    return new espalier_table{
        std::make_shared<const stencils::StencilTable<double>>(std::move(table))};
}

}  // namespace
}  // namespace espalier::c

espalier_status espalier_table_create_stencils(const espalier_refiner* refiner, int32_t level,
                                               espalier_table** table) {
    return c::guarded([&] {
        auto& out = c::deref(table, "table");
        const auto& own = c::deref(refiner, "refiner");
        out = c::newTable(stencils::buildStencils<double>(own.refiner, level, own.rules));
    });
}

espalier_status espalier_table_create_level(const espalier_refiner* refiner, int32_t level,
                                            espalier_table** table) {
    return c::guarded([&] {
        auto& out = c::deref(table, "table");
        const auto& own = c::deref(refiner, "refiner");
        out = c::newTable(stencils::buildLevelTable(own.refiner, level, own.rules));
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

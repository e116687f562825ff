// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/memory.h>
#include <espalier/embed/embedding.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/io/binding_file.h>
#include <espalier/shapes/lattice.h>
#include <espalier/stencils/stencil_table.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "guard.h"

// The structures behind the opaque types of the C API, and helpers that several files use.

struct espalier_lattice {
    espalier::Lattice lattice;
};

struct espalier_refiner {
    /// The offsets of the cells and the faces of a level. They are stored here because CellComplex
    /// may store them in another form.
    struct LevelOffsets {
        std::vector<std::int64_t> cells, faces;
    };

    espalier::far::TopologyRefiner refiner;
    mutable std::mutex offsetsMutex = {};
    mutable std::map<std::int32_t, LevelOffsets> offsets = {};  ///< one entry per requested level
};

struct espalier_table {
    std::shared_ptr<const espalier::stencils::StencilTable<double>> table;
};

struct espalier_binding {
    std::shared_ptr<const espalier::io::BoundModel> model;  ///< the tables made from it share it
};

namespace espalier::c {

/// Returns a point or a vector of three numbers.
inline Point3 point(const double* values, const char* name) {
    const auto given = array(values, 1, name, 3);
    return {given[0], given[1], given[2]};
}

/// Returns the given options, or the defaults.
/// \throws Error if the struct has a wrong size
inline espalier_bind_options bindOptions(const espalier_bind_options* options) {
    return optionsOrDefaults(options, espalier_default_bind_options(),
                             "espalier_default_bind_options",
                             offsetof(espalier_bind_options, limit_tolerance));
}

/// Refuses options that ask for the limit.
/// \throws ArgumentError with the reason
inline void checkNoLimit(const espalier_bind_options& chosen, const char* reason) {
    if (chosen.limit_tolerance != 0)
        throw ArgumentError("", "limit_tolerance", textOf(chosen.limit_tolerance),
                            concat("0, since ", reason));
}

/// Returns the given options, or the defaults, for a table of a level.
/// \throws Error if the options ask for the limit, with the reason, for gradients or for weights
inline espalier_bind_options levelBindOptions(const espalier_bind_options* options,
                                              const char* reason) {
    const espalier_bind_options chosen = bindOptions(options);
    checkNoLimit(chosen, reason);
    if (chosen.gradients != 0)
        throw ArgumentError("", "gradients", std::to_string(chosen.gradients),
                            "0, since only bindings have gradients");
    if (chosen.weights != nullptr || chosen.weight_slopes != nullptr || chosen.falloff != 0)
        throw Error(
            "weights, weight_slopes and falloff: expected null and 0, since only bindings "
            "have weights");
    return chosen;
}

/// \throws Error if the policy is unknown
inline embed::EmbeddingOptions embeddingOptions(const espalier_bind_options& chosen) {
    embed::EmbeddingOptions options;
    options.outside = choice(chosen.outside, embed::OutsidePolicy::Error, "outside");
    options.tolerance = chosen.tolerance;
    return options;
}

/// Returns a new refiner of the same base, to which points can be bound.
inline far::TopologyRefiner baseOf(const far::TopologyRefiner& refiner) {
    return far::TopologyRefiner(refiner.level(0).complex, refiner.options());
}

/// Calls `use` with the given rows of a table, or with the whole table if `rows` is null.
/// \param count number of rows; if `rows` is null it must be the number of rows of the table
/// \param what describes the rows in the message, such as "targets"
/// \throws Error that names the first row that does not exist
template <class Use>
auto withRows(const stencils::StencilTable<double>& table, std::int32_t count,
              const std::int32_t* rows, const char* what, const Use& use) {
    if (rows == nullptr) {
        checkCount(count, table.rowCount(), what);
        return use(table);
    }
    const auto some = array(rows, count, "rows");
    for (const std::int32_t row : some)
        if (row < 0 || row >= table.rowCount())
            throw Error(concat("rows: there is no row ", row, "; there are ", table.rowCount(),
                               ", numbered from 0"));
    return use(stencils::selectRows(table, some));
}

}  // namespace espalier::c

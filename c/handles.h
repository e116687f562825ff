// SPDX-License-Identifier: Apache-2.0
#pragma once

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

// The structures behind the opaque types of the C API, and the functions on them that several files
// use.

struct espalier_lattice {
    espalier::Lattice lattice;
};

struct espalier_refiner {
    /// The offsets of the cells and the faces of a level, which CellComplex may keep in another
    /// way.
    struct LevelOffsets {
        std::vector<std::int64_t> cells, faces;
    };

    espalier::far::TopologyRefiner refiner;
    mutable std::mutex offsetsMutex = {};
    mutable std::map<std::int32_t, LevelOffsets> offsets = {};  ///< of the levels asked for
};

struct espalier_table {
    std::shared_ptr<const espalier::stencils::StencilTable<double>> table;
};

struct espalier_binding {
    struct Data {
        espalier::io::BoundModel model;

        // How points were placed, which a file does not say.
        std::vector<espalier::embed::PointStatus> statuses = {};
        std::optional<double> largestResidual = {};
    };
    std::shared_ptr<const Data> data;  ///< shared with its tables
};

namespace espalier::c {

/// \throws Error for options of a wrong size
inline espalier_bind_options bindOptionsOr(const espalier_bind_options* options) {
    return optionsOr(options, espalier_default_bind_options(), "espalier_default_bind_options",
                     offsetof(espalier_bind_options, limit_tolerance));
}

/// Options for points bound to a level.
/// \throws Error if the limit is asked for, with the reason
inline espalier_bind_options levelOptionsOr(const espalier_bind_options* options,
                                            const char* reason) {
    const espalier_bind_options chosen = bindOptionsOr(options);
    if (chosen.limit_tolerance != 0)
        throw Error(
            concat("limit_tolerance is ", chosen.limit_tolerance, "; expected 0, since ", reason));
    return chosen;
}

/// \throws Error for an unknown policy
inline embed::EmbeddingOptions embeddingOptions(const espalier_bind_options& chosen) {
    embed::EmbeddingOptions options;
    options.outside = choice(chosen.outside, embed::OutsidePolicy::Error, "outside");
    options.tolerance = chosen.tolerance;
    return options;
}

/// A refiner of the same base, which points can be bound to.
inline far::TopologyRefiner baseOf(const far::TopologyRefiner& refiner) {
    return far::TopologyRefiner(refiner.level(0).complex, refiner.options());
}

/// Calls `use` with some rows of a table; with the table itself where `rows` is null.
/// \param count of rows; where `rows` is null it must be the number of rows of the table
/// \param what the rows are for: "targets"
/// \throws Error naming a row that is not there
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

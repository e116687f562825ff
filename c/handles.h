// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/embedding.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/io/binding_file.h>
#include <espalier/shapes/lattice.h>

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "espalier.h"

// What is behind the opaque types that more than one file knows.

struct espalier_lattice {
    espalier::Lattice lattice;
};

struct espalier_refiner {
    /// The offsets of the cells and the faces of a level, which CellComplex may keep in another
    /// way.
    struct LevelOffsets {
        std::vector<std::int64_t> cells, faces;
    };

    espalier_refiner(espalier::far::TopologyRefiner levels, espalier::stencils::Rules chosen)
        : refiner(std::move(levels)), rules(chosen) {}

    espalier::far::TopologyRefiner refiner;
    espalier::stencils::Rules rules;
    mutable std::mutex offsetsMutex;
    mutable std::map<std::int32_t, LevelOffsets> offsets;  ///< of the levels that were asked for
};

struct espalier_table {
    std::shared_ptr<const espalier::stencils::StencilTable<double>> table;
};

struct espalier_binding {
    /// How points were placed, which a file does not say.
    struct Placement {
        std::vector<espalier::embed::PointStatus> statuses;
        double largestResidual = 0;
    };
    struct Data {
        espalier::io::BoundModel model;
        std::optional<Placement> placement = {};
    };
    std::shared_ptr<const Data> data;  ///< shared with its tables
};

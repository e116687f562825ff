// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/refined_lattice.h>
#include <pybind11/stl.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "arguments.h"
#include "refiner.h"
#include "tables.h"

namespace espalier::python {

using namespace py::literals;

namespace {

using Word = std::optional<std::string>;

std::shared_ptr<Refiner> makeRefiner(const Shared<Lattice>& lattice, const std::string& rules,
                                     const Word& boundary, const std::string& sharpEdges,
                                     const Word& creasing, const Word& triangles,
                                     const Word& faceVarying) {
    auto options = refinerOptions(*lattice,
                                  {chosen(far::kBoundaryWords, "boundary", boundary),
                                   chosen(far::kCreasingWords, "creasing", creasing),
                                   chosen(far::kTriangleSubdivisionWords, "triangles", triangles)},
                                  chosen(far::kSharpEdgesWords, "sharp_edges", sharpEdges));
    options.rules = chosen(far::kRulesWords, "rules", rules);
    const auto linear = chosen(far::kFaceVaryingLinearWords, "face_varying", faceVarying);
    return withoutGil([&] { return std::make_shared<Refiner>(lattice, options, linear); });
}

std::shared_ptr<Lattice> refined(const Refiner& refiner, int level) {
    return sharedWithoutGil([&] {
        return stencils::refinedLattice(*refiner.upTo(level), level, *refiner.lattice(),
                                        refiner.faceVarying());
    });
}

py::array_t<double> refinedPositions(const Refiner& refiner, int level,
                                     const std::optional<ArrayLike>& pose) {
    const auto& rest = refiner.lattice()->positions;
    const auto base = pose ? toPoints(*pose, "pose", rest.size()) : rest;
    return toArray(
        withoutGil([&] { return stencils::refinePositions(*refiner.upTo(level), level, base); }));
}

std::shared_ptr<Table> stencilsOf(const Refiner& refiner, int level,
                                  const std::optional<ArrayLike>& vertices) {
    const auto rows = vertices ? toIndices(*vertices, "vertices") : std::vector<Index>();
    return sharedWithoutGil([&] {
        const auto levels = refiner.upTo(level);
        return vertices ? stencils::buildStencils(*levels, level, rows)
                        : stencils::buildStencils(*levels, level);
    });
}

std::shared_ptr<Table> levelTable(const Refiner& refiner, int level) {
    checkLevel(level);
    return sharedWithoutGil([&] { return stencils::buildLevelTable(*refiner.upTo(level), level); });
}

std::tuple<Index, Index, Index, Index> countsOf(const Refiner& refiner, int level) {
    return withoutGil([&] {
        const auto levels = refiner.upTo(level);
        const auto& complex = levels->level(level).complex;
        return std::tuple(complex.count(0), complex.count(1), complex.count(2), complex.count(3));
    });
}

py::array_t<std::uint8_t> strataOf(const Refiner& refiner, int level, int dimension) {
    return toArray(withoutGil([&] {
        const auto levels = refiner.upTo(level);
        const auto& [complex, strata, holes] = levels->level(level);
        if (dimension < 0 || dimension > complex.dimension())
            throw Error(
                concat("dimension: expected 0 to ", complex.dimension(), ", got ", dimension));
        std::vector<std::uint8_t> result;
        for (Index i = 0; i < complex.count(dimension); ++i)
            result.push_back(static_cast<std::uint8_t>(strata.of({dimension, i})));
        return result;
    }));
}

}  // namespace

void addRefiner(py::module_& module) {
    py::class_<Refiner, std::shared_ptr<Refiner>>(module, "Refiner", R"(
A lattice, mesh or curve, and the rules that it is refined by.

Functions that refine a lattice also take a Refiner: use one for rules other than the defaults.
Levels are made when they are first asked for, and kept.

lattice     : Lattice
rules       : "siggraph96", "cse96", "mlca"; "rats" for meshes and curves
boundary    : how the boundary is refined: "sharp", "edge-only" (corners are rounded) or "open" (no
              boundary rules; the region shrinks)
sharp_edges : which boundary edges of a lattice are sharp: "single-cell", those in one cell, or
              "literal", those between vertices that lie in at most two cells
creasing    : how semi-sharp edges lose sharpness: "uniform" or "chaikin"
triangles   : how triangles of a surface are weighted: "catmark" or "smooth"
face_varying : where texture coordinates are linear, OpenSubdiv's modes: "all", "none", "corners-only",
              "corners-plus1", "corners-plus2" or "boundaries"
None for boundary, creasing, triangles or face_varying means the lattice's tags, or else the first of
the words.
)")
        .def(py::init(&makeRefiner), "lattice"_a, py::kw_only(), "rules"_a = "siggraph96",
             "boundary"_a = py::none(), "sharp_edges"_a = "single-cell", "creasing"_a = py::none(),
             "triangles"_a = py::none(), "face_varying"_a = py::none())
        .def_property_readonly("lattice", getter(&Refiner::lattice), "The Lattice at level 0.")
        .def_property_readonly(
            "rules",
            [](const Refiner& self) { return wordOf(far::kRulesWords, {self.base().rules()}); },
            "The name of the rules: str.")
        .def("counts", &countsOf, "level"_a,
             "Numbers of vertices, edges, faces and cells of a level: tuple of 4 int.")
        .def("strata", &strataOf, "level"_a, "dimension"_a = 0, R"(
Returns the stratum of each vertex (dimension 0), edge (1), face (2) or cell (3) of a level: the kind
of feature that it lies on. Array (count,) of uint8: 0 corner, 1 sharp edge, 2 boundary surface, 3
interior.
)")
        .def("positions", &refinedPositions, "level"_a, "pose"_a = py::none(), R"(
Returns the positions of the vertices of a level: array (V_level, 3) of float64.

pose : array (V, 3), the positions of the vertices of level 0; by default those of the lattice
)")
        .def("refine", &refined, "level"_a = 1,
             "Returns a level as a Lattice, with its attributes and texture coordinates, and with "
             "the sharpness values that keep its features when it is refined further.")
        .def("stencils", &stencilsOf, "level"_a, "vertices"_a = py::none(), R"(
Returns S_level, a StencilTable of shape (V_level, V). Row i holds the weights of the vertices of
level 0 in vertex i of the level; rows sum to 1.

vertices : array (R,) of int, vertices of the level: only these rows, in this order
)")
        .def("level_table", &levelTable, "level"_a, R"(
Returns R_level, a StencilTable of shape (V_level, V_(level-1)): the weights from one level to the
next.
)");
    module.def(
        "refine",
        [](const RefinerLike& lattice, int level) { return refined(*refinerOf(lattice), level); },
        "lattice"_a, "level"_a = 1, R"(
Refines a Lattice, or the lattice of a Refiner, `level` times. Returns a Lattice, with refined
attributes and texture coordinates.

Each level has about 8 times (lattice), 4 times (mesh) or twice (curve) the cells, faces or edges of
the level before.
)");
}

}  // namespace espalier::python

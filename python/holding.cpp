// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/sort_unique.h>
#include <espalier/embed/continuity.h>
#include <espalier/embed/nested_lattices.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "arguments.h"
#include "refiner.h"
#include "tables.h"

namespace espalier::python {

using namespace py::literals;

namespace {

using embed::Continuity;

py::array_t<Index> hold(const RefinerLike& lattice, const std::optional<ArrayLike>& faces,
                        const std::optional<ArrayLike>& points, int level,
                        const std::string& continuity, const std::string& outside,
                        double tolerance) {
    if (!faces && !points) throw Error("hold: expected faces, points, or both");
    const auto refiner = refinerOf(lattice);
    const auto wanted = chosen(embed::kContinuityWords, "continuity", continuity);
    const embed::EmbeddingOptions options{chosen(embed::kOutsidePolicyWords, "outside", outside),
                                          tolerance};
    const auto heldFaces = faces ? toIndices(*faces, "faces") : std::vector<Index>();
    const auto heldPoints = points ? toPoints(*points, "points") : std::vector<Point3>();
    return toArray(withoutGil([&] {
        std::vector<Index> vertices;
        const auto add = [&](const std::vector<Index>& some) {
            vertices.insert(vertices.end(), some.begin(), some.end());
        };
        if (faces)
            add(embed::verticesHoldingFaces(refiner->base(), refiner->rules(), heldFaces, wanted));
        if (points)
            add(embed::verticesHoldingPoints(
                {refiner->base(), refiner->lattice()->positions, refiner->rules()}, heldPoints,
                wanted, {.level = level, .embedding = options}));
        sortUnique(vertices);
        return vertices;
    }));
}

std::shared_ptr<Table> nest(const TableLike& child, const ArrayLike& childPose,
                            const RefinerLike& parent, int level, const std::string& outside,
                            double tolerance) {
    const auto table = tableOf(child);
    const auto pose = toPoints(childPose, "child_pose", table->columnCount());
    const auto refiner = refinerOf(parent);
    const embed::EmbeddingOptions options{chosen(embed::kOutsidePolicyWords, "outside", outside),
                                          tolerance};
    return withoutGil([&] {
        return std::make_shared<Table>(embed::nestTables(
            *table, pose, {refiner->base(), refiner->lattice()->positions, refiner->rules()},
            {.level = level, .embedding = options}));
    });
}

}  // namespace

void addHolding(py::module_& module) {
    module.def("hold", &hold, "lattice"_a, py::kw_only(), "faces"_a = py::none(),
               "points"_a = py::none(), "level"_a = 3, "continuity"_a = "c1", "outside"_a = "keep",
               "tolerance"_a = 1e-6, R"(
The vertices to freeze so that a part of what a lattice deforms stays, and meets what moves smoothly:
array of int32, ascending, for fit(frozen=...) and DesignVariables.freeze().

lattice    : Lattice at rest, or Refiner
faces      : array of int, faces of the lattice to hold
points     : array (N, 3), points to hold; level, outside and tolerance are as bind() takes them
continuity : "c0", in place; "c1", with tangent planes; "c2", with curvatures, by the same vertices
)");
    module.def("nest", &nest, "child"_a, "child_pose"_a, "parent"_a, "level"_a = 3, py::kw_only(),
               "outside"_a = "error", "tolerance"_a = 1e-6, R"(
Carries points by a lattice, the child, that lies in another, the parent. Returns a StencilTable of
shape (N, vertices of the parent).

child      : D of the child: Binding, StencilTable or a sparse matrix of SciPy, of shape (N, V)
child_pose : array (V, 3): the child posed, where the parent is at rest
parent     : Lattice at rest, or Refiner; level : of the parent
outside    : of a vertex of the child that is outside of the parent: "nearest" takes it along, any
             other word refuses it
)");
}

}  // namespace espalier::python

// SPDX-License-Identifier: Apache-2.0
// What becomes of D: fitting, holding, nesting, and the variables of a design.
#include <espalier/base/sort_unique.h>
#include <espalier/embed/continuity.h>
#include <espalier/embed/nested_lattices.h>
#include <espalier/shapes/held.h>
#include <espalier/shapes/lattice.h>
#include <espalier/solve/design_variables.h>
#include <espalier/solve/lattice_fit.h>
#include <espalier/solve/section_variables.h>
#include <pybind11/stl.h>

#include <array>
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

std::vector<Index> indicesOf(const std::optional<ArrayLike>& indices, const char* name) {
    return indices ? toIndices(*indices, name) : std::vector<Index>();
}

solve::LatticeFit fit(const Lattice& lattice, const TableLike& deformation, const ArrayLike& misses,
                      const std::optional<ArrayLike>& rows, const std::string& smoothing,
                      double strength, const std::optional<ArrayLike>& frozen,
                      const std::string& undetermined, bool moveHeld) {
    const auto table = tableOf(deformation);
    const auto chosenRows = indicesOf(rows, "rows");
    for (const Index row : chosenRows)
        if (row < 0 || row >= table->rowCount())
            throw Error(concat("rows: there is no row ", row, "; there are ", table->rowCount(),
                               ", numbered from 0"));
    const auto wanted = toPoints(misses, "misses", rows ? chosenRows.size() : table->rowCount());
    solve::FitOptions options;
    options.smoothing = chosen(solve::kSmoothingWords, "smoothing", smoothing);
    options.strength = strength;
    options.frozen = indicesOf(frozen, "frozen");
    if (!moveHeld) options.frozen = shapes::frozenWithHeld(lattice, options.frozen);
    options.undetermined = chosen(solve::kUndeterminedWords, "undetermined", undetermined);
    return withoutGil([&] {
        if (!rows) return solve::fitLattice(*table, wanted, lattice.complex, options);
        return solve::fitLattice(stencils::selectRows(*table, std::span(chosenRows)), wanted,
                                 lattice.complex, options);
    });
}

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
        if (faces) add(embed::verticesHoldingFaces(refiner->base(), heldFaces, wanted));
        if (points)
            add(embed::verticesHoldingPoints({refiner->base(), refiner->lattice()->positions},
                                             heldPoints, wanted,
                                             {.level = level, .embedding = options}));
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
    return sharedWithoutGil([&] {
        return embed::nestTables(*table, pose, {refiner->base(), refiner->lattice()->positions},
                                 {.level = level, .embedding = options});
    });
}

using solve::DesignVariables;

/// Returns the vertices of an integer or a one-dimensional array.
std::vector<Index> verticesOf(const ArrayLike& object) {
    const auto array = indexArray(object, "vertices");
    if (array.ndim() > 1)
        throw Error("vertices: expected an integer or an array of one dimension, got shape " +
                    shapeText(array));
    return {array.data(), array.data() + array.size()};
}

}  // namespace

void addFit(py::module_& module) {
    py::class_<solve::LatticeFit, std::shared_ptr<solve::LatticeFit>>(
        module, "LatticeFit",
        "The displacements that fit() finds, and how closely they reach the targets.")
        .def_property_readonly(
            "displacements",
            [](const py::object& self) {
                return viewOf(self.cast<const solve::LatticeFit&>().displacements, self);
            },
            "Displacements of the lattice vertices: array (V, 3) of float64, read-only, in the "
            "units of "
            "the targets.")
        .def_readonly("largest_miss", &solve::LatticeFit::largestMiss,
                      "The largest distance of a point from its target: float.")
        .def_readonly("rms_miss", &solve::LatticeFit::rmsMiss,
                      "The root mean square of these distances: float.")
        .def_readonly(
            "condition", &solve::LatticeFit::condition,
            "Condition number of the problem, its largest singular value over its smallest: "
            "float; inf if the targets do not determine all displacements.");
    module.def("fit", &fit, "lattice"_a, "deformation"_a, "misses"_a, py::kw_only(),
               "rows"_a = py::none(), "smoothing"_a = "none", "strength"_a = 1e-3,
               "frozen"_a = py::none(), "undetermined"_a = "smallest", "move_held"_a = false, R"(
Finds displacements of a lattice that move points to given targets, by least squares. Returns a
LatticeFit.

lattice      : Lattice
deformation  : D: Binding, StencilTable or a sparse matrix of SciPy, of shape (N, V)
misses       : array (N, 3): for each point its target minus its position at rest
rows         : array (K,) of int: the points that have targets, if not all have; misses is then (K, 3)
smoothing    : "none"; "tikhonov", small displacements; "laplacian", displacements like those of
               neighbouring vertices
strength     : weight of the smoothing, 1e-4 to 1e4; with 1 it counts about as much as the targets
frozen       : array of int: lattice vertices that must not move
undetermined : if the targets do not determine all vertices: "smallest" takes the smallest
               displacements, "refuse" raises an error
move_held    : if True, the vertices that the lattice holds (Lattice.held) may move, too
)");
}

void addHolding(py::module_& module) {
    module.def("hold", &hold, "lattice"_a, py::kw_only(), "faces"_a = py::none(),
               "points"_a = py::none(), "level"_a = 3, "continuity"_a = "c1", "outside"_a = "keep",
               "tolerance"_a = 1e-6, R"(
Returns the lattice vertices to freeze so that given faces or points stay where they are, and the rest
joins them smoothly: array of int32, ascending, for fit(frozen=...) and DesignVariables.freeze().

lattice    : Lattice at rest, or Refiner
faces      : array of int, faces of the lattice to hold
points     : array (N, 3), points to hold; level, outside and tolerance are as for bind()
continuity : how the held part meets the rest: "c0", without a gap; "c1", with the same tangent planes;
             "c2", with the same curvatures. "c1" and "c2" freeze the same vertices
)");
    module.def("nest", &nest, "child"_a, "child_pose"_a, "parent"_a, "level"_a = 3, py::kw_only(),
               "outside"_a = "error", "tolerance"_a = 1e-6, R"(
Combines two lattices: points move with a lattice, the child, whose vertices move with another, the
parent. Returns a StencilTable of shape (N, vertices of the parent).

child      : D of the child: Binding, StencilTable or a sparse matrix of SciPy, of shape (N, V)
child_pose : array (V, 3): the pose of the child while the parent is at rest
parent     : Lattice at rest, or Refiner
level      : the level of the parent to bind the child's vertices to
outside    : a vertex of the child outside the parent: "nearest" moves it with the nearest cell, any
             other word raises an error
)");
}

void addDesignVariables(py::module_& module) {
    using solve::SectionVariables;
    py::class_<SectionVariables>(module, "SectionVariables", R"(
Five variables for each section of a lattice along an axis: twist, scale of the chord, and a
translation x, y, z; section by section. Twists are in radians, anticlockwise seen from the tip of
the axis. Between sections they are linear in the coordinate along the axis.

positions : array (V, 3), the lattice at rest; stations : array (S,), coordinates of the sections
along the axis, ascending
axis, chord : 3 float each, directions; center : 3 float, a point on the axis
)")
        .def(py::init([](const ArrayLike& positions, const ArrayLike& stations, const Point3& axis,
                         const Point3& chord, const Point3& center) {
                 const auto array = realArray<double>(stations, "stations");
                 return SectionVariables(
                     toPoints(positions, "positions"),
                     {axis, chord, center, {array.data(), array.data() + array.size()}});
             }),
             "positions"_a, "stations"_a, "axis"_a = Point3{0, 0, 1}, "chord"_a = Point3{1, 0, 0},
             "center"_a = Point3{0, 0, 0})
        .def_property_readonly(
            "at_rest", [](const SectionVariables& self) { return toArray(self.atRest()); },
            "The values, an array (5 S,), that leave the lattice at rest: 0, 1, 0, 0, 0 for each "
            "section.")
        .def(
            "positions",
            [](const SectionVariables& self, const ArrayLike& values) {
                const auto array = realArray<double>(values, "values");
                return toArray(self.positions({array.data(), std::size_t(array.size())}));
            },
            "values"_a, "Returns the lattice, an array (V, 3), for some values: array (5 S,).")
        .def(
            "matrix",
            [](const SectionVariables& self, const ArrayLike& values) {
                const auto array = realArray<double>(values, "values");
                return std::make_shared<Table>(
                    self.matrix({array.data(), std::size_t(array.size())}));
            },
            "values"_a,
            "Returns the derivatives of the coordinates by the variables, a StencilTable 3 V × 5 S "
            "for jacobian(), at some values: array (5 S,).");
    py::class_<DesignVariables>(module, "DesignVariables", R"(
The variables that an optimiser may choose: at first one for each coordinate of each lattice vertex.
matrix() returns B, which turns variables into displacements.

vertex_count : V, the number of lattice vertices
)")
        .def(py::init<Index>(), "vertex_count"_a)
        .def(
            "freeze",
            [](DesignVariables& self, const ArrayLike& vertices, std::optional<int> axis) {
                for (const Index vertex : verticesOf(vertices))
                    axis ? self.freeze(vertex, *axis) : self.freeze(vertex);
            },
            "vertices"_a, "axis"_a = py::none(),
            "Keeps vertices, or one coordinate of them (0 to 2), where they are. vertices : int, "
            "or array (K,) of int")
        .def("link", &DesignVariables::link, "vertex"_a, "to"_a,
             "factors"_a = std::array<double, 3>{1, 1, 1},
             "Makes a vertex move like the vertex `to`, with each coordinate times its factor.")
        .def(
            "mirror",
            [](DesignVariables& self, const ArrayLike& positions, int axis, double at,
               double tolerance) {
                const auto points = toPoints(positions, "positions");
                self.mirror(points, axis, at, tolerance);
            },
            "positions"_a, "axis"_a, "at"_a = 0.0, "tolerance"_a = 1e-9, R"(
Links each vertex with its mirror image in a plane that is normal to an axis.

positions : array (V, 3), at rest
axis, at  : the axis, 0 to 2, and the coordinate of the plane on it
tolerance : largest distance of a vertex from the mirror image of its partner
)")
        .def(
            "scale",
            [](DesignVariables& self, const ArrayLike& vertices, double unit,
               std::optional<int> axis) {
                for (const Index vertex : verticesOf(vertices))
                    axis ? self.scale(vertex, *axis, unit) : self.scale(vertex, unit);
            },
            "vertices"_a, "unit"_a, "axis"_a = py::none(),
            "Sets how far vertices, or one coordinate of them, move when their variable grows by "
            "1. "
            "vertices : int, or array (K,) of int")
        .def(
            "matrix",
            [](const DesignVariables& self) {
                return sharedWithoutGil([&] { return self.matrix(); });
            },
            "Returns B, a StencilTable of shape (3 V, variables). Row 3 v + c is coordinate c of "
            "vertex v: (B @ variables).reshape(V, 3) are the displacements.");
    module.def(
        "jacobian",
        [](const TableLike& deformation, const TableLike& design) {
            const auto d = tableOf(deformation);
            const auto b = tableOf(design);
            return sharedWithoutGil([&] { return solve::buildJacobian(*d, *b); });
        },
        "deformation"_a, "design"_a, R"(
Returns the derivatives of the points with respect to the variables: a StencilTable of shape
(3 N, variables), whose row 3 i + c is coordinate c of point i.

deformation : D: Binding, StencilTable or a sparse matrix of SciPy, of shape (N, V)
design      : B: DesignVariables.matrix()
)");
}

}  // namespace espalier::python

// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/argument_error.h>
#include <espalier/base/number_text.h>
#include <espalier/base/printable.h>
#include <espalier/cages/cage.h>
#include <espalier/cages/collar.h>
#include <espalier/io/model.h>
#include <espalier/shapes/around.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/merge.h>
#include <espalier/shapes/solids.h>
#include <pybind11/stl.h>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <variant>
#include <vector>

#include "arguments.h"
#include "binding.h"

namespace espalier::python {

using namespace py::literals;

namespace {

shapes::DiskPattern patternOf(int rings, const std::string& core) {
    return {rings, chosen(shapes::kCoreWords, "core", core)};
}

/// Makes a lattice of the inventory.
template <class Options>
std::shared_ptr<Lattice> make(Lattice (*shape)(const Options&), const Options& options) {
    return sharedWithoutGil([&] { return shape(options); });
}

std::vector<shapes::ArmJoint> jointsOf(const ArrayLike& rows) {
    const auto array = realArray<double>(rows, "joints");
    if (array.ndim() != 2 || (array.shape(1) != 4 && array.shape(1) != 5))
        throw Error("joints: expected an array of shape (J, 4) or (J, 5), got " + shapeText(array));
    std::vector<shapes::ArmJoint> joints;
    for (py::ssize_t i = 0; i < array.shape(0); ++i)
        joints.push_back({{array.at(i, 0), array.at(i, 1), array.at(i, 2)},
                          array.at(i, 3),
                          array.shape(1) == 5 ? array.at(i, 4) : 0});
    return joints;
}

void addRoundShapes(py::module_& module) {
    module.def(
        "cylinder",
        [](int sectors, int rings, const std::string& core, int layers, double radius,
           const Point3& from, const Point3& to) {
            return make(shapes::cylinder,
                        {sectors, patternOf(rings, core), layers, radius, from, to});
        },
        py::kw_only(), "sectors"_a = 8, "rings"_a = 1, "core"_a = "wedges", "layers"_a = 1,
        "radius"_a = 1.0, "start"_a = Point3{0, 0, 0}, "end"_a = Point3{0, 0, 1}, R"(
A disk swept along an axis (MacCracken & Joy 1996, figures 1 and 5).

sectors : sides of the disk, 3 or more
rings, core : rings of cells in the disk, counting its core: "wedges" around the axis, or one "polygon"
layers : layers of cells along the axis
radius : radius of the outermost vertices; start, end : 3 float each, the centres of the two ends
)");
    module.def(
        "torus",
        [](int segments, const std::string& section, int gridCells, int sides, int rings,
           const std::string& core, double majorRadius, double minorRadius) {
            return make(shapes::torus,
                        {segments, chosen(shapes::kTorusSectionWords, "section", section),
                         gridCells, sides, patternOf(rings, core), majorRadius, minorRadius});
        },
        py::kw_only(), "segments"_a = 8, "section"_a = "grid", "grid_cells"_a = 1, "sides"_a = 6,
        "rings"_a = 1, "core"_a = "wedges", "major_radius"_a = 1.0, "minor_radius"_a = 0.4, R"(
A ring around the z axis, with its centre at the origin.

segments : cells around the ring, 3 or more
section : cross-section: "grid", a square of grid_cells by grid_cells, or "disk" of `sides`, `rings`
and `core`, as for cylinder()
major_radius, minor_radius : radius of the ring; radius of the disk, or half the side of the square
)");
    module.def(
        "star",
        [](int points, int rings, const std::string& core, int layers, double innerRadius,
           double outerRadius, double height) {
            return make(shapes::star,
                        {points, patternOf(rings, core), layers, innerRadius, outerRadius, height});
        },
        py::kw_only(), "points"_a = 5, "rings"_a = 1, "core"_a = "wedges", "layers"_a = 1,
        "inner_radius"_a = 0.5, "outer_radius"_a = 1.0, "height"_a = 0.25, R"(
A flat star with its centre at the origin (figure 7). With equal radii it is round: the rest pose.

points : points of the star, 2 or more; rings, core, layers : as for cylinder()
inner_radius, outer_radius, height : radius of the notches, radius of the points, thickness
)");
}

void addJointedShapes(py::module_& module) {
    module.def(
        "barbell",
        [](int endSegments, int barSegments, int barAcross, int rings, const std::string& core,
           int layers, double endRadius, double barLength, double barHalfWidth, double roundness,
           double height) {
            return make(shapes::barbell,
                        {endSegments, barSegments, barAcross, patternOf(rings, core), layers,
                         endRadius, barLength, barHalfWidth, roundness, height});
        },
        py::kw_only(), "end_segments"_a = 6, "bar_segments"_a = 2, "bar_across"_a = 2,
        "rings"_a = 1, "core"_a = "wedges", "layers"_a = 1, "end_radius"_a = 1.0,
        "bar_length"_a = 2.0, "bar_half_width"_a = 0.4, "roundness"_a = 1.0, "height"_a = 0.5, R"(
Two ends joined by a bar along x (figure 8).

end_segments : edges around an end, 3 or more; bar_segments, bar_across : cells along the bar and
across it; rings, core, layers : as for cylinder()
end_radius, bar_length, bar_half_width, height : sizes in any unit of length; height is the thickness
roundness : roundness of the ends, from 0 (square) to 1 (round)
)");
    const shapes::ArmOptions usual;
    std::vector<std::array<double, 4>> usualJoints;
    for (const auto& joint : usual.joints)
        usualJoints.push_back(
            {joint.position[0], joint.position[1], joint.position[2], joint.radius});
    module.def(
        "arm",
        [](const ArrayLike& joints, int segments, int sides, int rings, const std::string& core,
           const Point3& up) {
            return make(shapes::arm,
                        {jointsOf(joints), segments, sides, patternOf(rings, core), up});
        },
        py::kw_only(), "joints"_a = usualJoints, "segments"_a = 2, "sides"_a = 4, "rings"_a = 1,
        "core"_a = "polygon", "up"_a = Point3{0, 0, 1}, R"(
A tube around a limb (figure 9). Other positions and twists give a pose of the same lattice.

joints : array (J, 4) or (J, 5): x, y, z, radius and, if given, twist in radians of each joint
segments : cells from joint to joint; sides : sides of the cross-section, 3 or more
rings, core : as for cylinder()
up : 3 float, the direction from the first bone to the first vertex of the cross-section
)");
}

void addSolids(py::module_& module) {
    using Regular = shapes::RegularSolidOptions;
    const std::tuple<const char*, Lattice (*)(const Regular&), const char*> solids[] = {
        {"tetrahedron", shapes::tetrahedron, "4, with 3 edges at each."},
        {"cube", shapes::cube, "8, with 3 edges at each."},
        {"octahedron", shapes::octahedron, "6, with 4 edges at each."},
        {"dodecahedron", shapes::dodecahedron, "20, with 3 edges at each."},
        {"icosahedron", shapes::icosahedron, "12, with 5 edges at each."}};
    for (const auto& [name, shape, vertices] : solids) {
        const std::string text =
            "One cell with its vertices on a sphere of `radius` around the origin. Vertices: ";
        module.def(
            name, [shape = shape](double radius) { return make(shape, Regular{radius}); },
            py::kw_only(), "radius"_a = 1.0, (text + vertices).c_str());
    }
    using Polygonal = shapes::PolygonalSolidOptions;
    const auto addPolygonal = [&](const char* name, Lattice (*shape)(const Polygonal&),
                                  const char* text) {
        module.def(
            name,
            [shape](int sides, double radius, double height) {
                return make(shape, Polygonal{sides, radius, height});
            },
            py::kw_only(), "sides"_a = 4, "radius"_a = 1.0, "height"_a = 1.0, text);
    };
    addPolygonal("prism", shapes::prism,
                 "One cell between two polygons of `sides` and `radius`, `height` apart.");
    addPolygonal("pyramid", shapes::pyramid,
                 "One cell between a polygon of `sides` and `radius` and an apex at `height`.");
    addPolygonal("bipyramid", shapes::bipyramid,
                 "One cell with an apex on each side of a polygon of `sides` and `radius`.");
}

/// \param axis "x", "y" or "z"
shapes::SymmetryPlane planeOf(const std::string& axis, double at) {
    if (axis.size() != 1 || axis[0] < 'x' || axis[0] > 'z')
        throw ArgumentError("around", "symmetry", inQuotes(axis), "x, y or z");
    return {axis[0] - 'x', at};
}

void addAround(py::module_& module) {
    using Cells = std::variant<int, std::array<int, 3>>;
    module.def(
        "around",
        [](const py::handle& points, const std::optional<Cells>& cells, double cellSize,
           double margin, bool oriented, const std::optional<std::string>& symmetry,
           double symmetryAt) {
            const auto places = toPoints(points, "points");
            shapes::AroundOptions options{
                .cellSize = cellSize, .margin = margin, .oriented = oriented};
            if (symmetry) options.symmetry = planeOf(*symmetry, symmetryAt);
            if (!symmetry && symmetryAt != 0)
                throw ArgumentError("around", "symmetry_at", espalier::textOf(symmetryAt),
                                    "0 without the argument symmetry");
            if (cells && cells->index() == 0) options.cellsAlongLongest = std::get<0>(*cells);
            if (cells && cells->index() == 1) options.cells = std::get<1>(*cells);
            // Zeros would stand for the default.
            if (cells && cells->index() == 1 && options.cells == std::array<int, 3>{})
                throw ArgumentError("around", "cells", "(0, 0, 0)", "1 or more each");
            return sharedWithoutGil([&] { return shapes::around(places, options); });
        },
        "points"_a, py::kw_only(), "cells"_a = py::none(), "cell_size"_a = 0.0,
        "margin"_a = shapes::AroundOptions().margin, "oriented"_a = false,
        "symmetry"_a = py::none(), "symmetry_at"_a = 0.0, R"(
A box of hexahedra around the points of a model, which contains every point.

points : (N, 3) array of float
cells : number of cells along the longest side of the box, for cells that are closest to cubes (4 by
default); or 3 int, cells along x, y and z
cell_size : instead of `cells`, the largest edge of a cell
margin : distance from the points to the sides of the box, as a fraction of the diagonal of the box
around the points; doubled until rounding leaves no point outside
oriented : if True, the box is turned so that its volume is smallest; otherwise its sides are
parallel to the axes
symmetry : "x", "y" or "z": faces of the box lie exactly in the plane across this axis, a side of the
box if all points are on one side of the plane, else the middle
symmetry_at : coordinate of that plane
)");
}

void addCollar(py::module_& module) {
    using Words = std::variant<std::string, std::vector<std::string>>;
    module.def(
        "collar",
        [](const Lattice& lattice, int layers, double reach,
           const std::optional<std::array<Point3, 2>>& until, const Words& open, int held) {
            cages::CollarOptions options{
                .layers = layers, .reach = reach, .until = until, .held = held};
            if (open.index() == 1)
                options.open = cages::sidesOf(std::get<1>(open));
            else if (const std::string& word = std::get<0>(open); !word.empty())
                options.open = cages::sidesOf({&word, 1});
            return sharedWithoutGil([&] { return cages::collar(lattice, options).lattice; });
        },
        "lattice"_a, py::kw_only(), "layers"_a = cages::CollarOptions().layers, "reach"_a = 0.0,
        "until"_a = py::none(), "open"_a = "", "held"_a = 0, R"(
A lattice with layers of cells around it, whose outer vertices are held (Lattice.held), so that
motion fades out: C2 if two layers of vertices are held, C0 if one is. Vertices and cells of the
lattice keep their numbers. No cell is folded, except cells of the lattice that were before.

lattice : Lattice; layers : layers of cells, 1 to 100
reach : thickness of the collar, in the units of the lattice; or give `until`, (2, 3) float, the
corners of a box to reach to, around a box along the axes
open : sides without a collar: "z" for both ends of an axis, "+y", "-y"; or a list of such words
held : number of outer layers of vertices that are held: two, or one if there is one layer of cells
)");
}

/// The points and the faces of one or more models.
struct PointsAndFaces {
    std::vector<Point3> points;
    io::ModelFaces faces;
};

/// Adds the points and the faces of a model.
/// \throws Error if it has no faces
void append(const ModelFile& file, PointsAndFaces& all) {
    io::ModelFaces faces = file.model->readSurface().faces;
    // The mesh of a volume may have cells only.
    if (faces.count() == 0) faces = io::boundaryFaces(file.model->readCells().volume);
    if (faces.count() == 0)
        throw Error(concat(printable(file.name),
                           " has no faces; shapes.around() makes a box around points"));
    const auto points = file.model->positions();
    all.faces.append(faces, static_cast<Index>(all.points.size()));
    all.points.insert(all.points.end(), points.begin(), points.end());
}

/// Converts an array (F, k) or a list of loops.
io::ModelFaces modelFacesOf(const py::object& faces) {
    io::ModelFaces result;
    const auto add = [&](std::span<const Index> loop) {
        result.corners.insert(result.corners.end(), loop.begin(), loop.end());
        result.endFace();
    };
    if (const auto rows = indexRows(faces, "faces", "(F, k)")) {
        for (std::size_t i = 0; i < rows->count(); ++i) add((*rows)[i]);
    } else {
        const auto list = sequenceOf(faces, "faces", "an array or a list of loops");
        for (std::size_t i = 0; i < list.size(); ++i)
            add(toIndices(list[i], concat("faces[", i, "]")));
    }
    return result;
}

/// Converts a model, a list of models, or points with faces.
PointsAndFaces pointsAndFacesOf(const py::object& model, const py::object& faces) {
    PointsAndFaces all;
    if (!faces.is_none()) {
        all.points = toPoints(model, "model");
        all.faces = modelFacesOf(faces);
    } else if (py::isinstance<ModelFile>(model)) {
        append(model.cast<const ModelFile&>(), all);
    } else if (py::isinstance<py::list>(model) || py::isinstance<py::tuple>(model)) {
        for (const py::handle one : model) {
            if (!py::isinstance<ModelFile>(one))
                throw Error("model: expected a list of Model, got one with " + typeName(one) +
                            "; points need the argument `faces`");
            append(one.cast<const ModelFile&>(), all);
        }
    } else {
        throw Error("model: expected a Model or a list of Model, got " + typeName(model) +
                    "; points need the argument `faces`");
    }
    return all;
}

void addCage(py::module_& module) {
    const cages::CageOptions usual;
    module.def(
        "cage",
        [](const py::object& model, const py::object& faces, Index vertices, double cellSize,
           double margin, double shell, bool keepApart, const std::string& symmetric,
           double symmetry) {
            const PointsAndFaces all = pointsAndFacesOf(model, faces);
            const auto planes = chosen(cages::kSymmetricWords, "symmetric", symmetric);
            return sharedWithoutGil([&] {
                return cages::cage({all.points, all.faces.corners, all.faces.ends},
                                   {.vertices = vertices,
                                    .cellSize = cellSize,
                                    .margin = margin,
                                    .shell = shell,
                                    .keepApart = keepApart,
                                    .symmetric = planes,
                                    .symmetry = symmetry});
            });
        },
        "model"_a, "faces"_a = py::none(), py::kw_only(), "vertices"_a = usual.vertices,
        "cell_size"_a = usual.cellSize, "margin"_a = usual.margin, "shell"_a = usual.shell,
        "keep_apart"_a = usual.keepApart, "symmetric"_a = "auto", "symmetry"_a = usual.symmetry, R"(
A lattice of hexahedra that follows the shape of a model. It contains every point of the model, and
no cell of its limit volume is folded; both are proved.

model : Model with faces, or a list of them; or, with `faces`, the points: (N, 3) array of float
faces : (F, k) array of int, or a list of loops of points; any polygons, wound in any way
vertices : number of vertices, 8 to 100,000; the result has between 0.8 and 1.2 times as many
cell_size : instead of `vertices`, the edge of the cells before they are fitted
margin : least distance from the model to the boundary of the lattice, as a fraction of the diagonal
of the box around the model: 0 to 1
shell : if above 0, the lattice is made around the surface only, and contains all points within half
of this distance
keep_apart : if True, parts of the model stay separate even if they are nearer to each other than a
cell
symmetric : planes about which the lattice is symmetric: "x", "yz" and so on, across the axes and
through the middle of the box around the model; "auto": about which the model is symmetric; "none"
symmetry : largest distance of a mirrored point from the model that counts as symmetric, as a
fraction of the diagonal: 0 to 1
)");
}

void addAll(py::module_& shapesModule) {
    shapesModule.def(
        "box",
        [](const std::array<int, 3>& cells, const Point3& min, const Point3& max) {
            return make(shapes::box, {cells, min, max});
        },
        "cells"_a = std::array<int, 3>{1, 1, 1}, "min"_a = Point3{0, 0, 0},
        "max"_a = Point3{1, 1, 1}, R"(
A box of hexahedra (figure 1).

cells : 3 int, cells along x, y and z; min, max : 3 float each, the lowest and the highest corner
Vertex (i, j, k) is i + (cells[0] + 1) * (j + (cells[1] + 1) * k): positions reshaped to (cells[2] +
1, cells[1] + 1, cells[0] + 1, 3) are indexed by [k, j, i].
)");
    addAround(shapesModule);
    addCage(shapesModule);
    addCollar(shapesModule);
    addRoundShapes(shapesModule);
    addJointedShapes(shapesModule);
    addSolids(shapesModule);
    shapesModule.def(
        "merge",
        [](const std::vector<Shared<Lattice>>& lattices, double tolerance) {
            return sharedWithoutGil([&] {
                std::vector<Lattice> copies;  // cheap: their complexes are shared
                for (const auto& lattice : lattices) copies.push_back(*lattice);
                return shapes::merge(copies, {tolerance});
            });
        },
        "lattices"_a, py::kw_only(), "tolerance"_a = shapes::MergeOptions().tolerance, R"(
Merges lattices: vertices at the same place become one, and faces with the same vertices are shared.

lattices : list of Lattice, all of one dimension and with the same attributes
tolerance : largest distance of vertices that become one, as a fraction of the diagonal of the box
around all lattices
)");
}

}  // namespace

void addShapes(py::module_& module) {
    addSubmodule(module, "_shapes", "Ready-made lattices (MacCracken & Joy 1996, section 5).",
                 "espalier.shapes", addAll);
}

}  // namespace espalier::python

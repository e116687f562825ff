// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/model_part.h>
#include <espalier/solve/mesh_check.h>
#include <espalier/solve/sliding_points.h>

#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "arguments.h"
#include "binding.h"

namespace espalier::python {

using namespace py::literals;

namespace {

/// Returns the cells of a model.
/// \throws Error if there are none that can be checked
io::ModelCells cellsOf(const ModelFile& model) {
    io::ModelCells cells = model.model->readCells();
    if (cells.cellCount() > 0) return cells;
    const auto unchecked = io::uncheckedElements(cells);
    throw Error(unchecked.empty()
                    ? concat("model: ", printable(model.name), " has no cells")
                    : concat("model: ", printable(model.name), " has ", unchecked[0].count, " ",
                             unchecked[0].name, ", which cannot be checked, and no other cells"));
}

/// The cells of a model, and the check of its poses.
class MeshCheck {
public:
    explicit MeshCheck(const std::shared_ptr<const ModelFile>& model)
        : MeshCheck(model, cellsOf(*model)) {}

    const solve::MeshCheck& check() const { return check_; }
    const std::vector<io::ElementCount>& unchecked() const { return unchecked_; }
    std::vector<Point3> toPoses(const ArrayLike& points) const {
        return toPoints(points, "points", pointCount_);
    }

private:
    MeshCheck(std::shared_ptr<const ModelFile> model, const io::ModelCells& cells)
        : unchecked_(io::uncheckedElements(cells)),
          pointCount_(model->model->positions().size()),
          check_(cells, model->model->positions(),
                 {cells.isOpenFoam, [model](std::vector<Point3> points) {
                      return model->model->stored(std::move(points));
                  }}) {}

    std::vector<io::ElementCount> unchecked_;
    std::size_t pointCount_;
    solve::MeshCheck check_;
};

/// The points of patches that slide.
struct SlidingPoints {
    std::size_t pointCount;
    solve::SlidingPoints points;
};

SlidingPoints slidingPoints(const ModelFile& file, const std::vector<std::string>& patches) {
    std::vector<far::MeshPatch> found;
    for (const std::string& name : patches)
        found.push_back(io::patchOf(file.name, *file.model, name));
    const auto rest = file.model->positions();
    return {rest.size(), solve::SlidingPoints(found, rest)};
}

/// Returns [(kind, origin, direction, radius)] of each patch, by its name.
py::dict shapesOf(const solve::SlidingPoints& sliding) {
    py::dict all;
    for (const auto& patch : sliding.patches()) {
        py::list shapes;
        for (const solve::SlideShape& shape : patch.shapes)
            shapes.append(py::make_tuple(std::string(solve::nameOf(shape.kind)), shape.origin,
                                         shape.direction, shape.radius));
        all[py::str(patch.name)] = shapes;
    }
    return all;
}

template <class Value>
py::object valueOrNone(const std::optional<Value>& value) {
    return value ? py::object(py::float_(value->value)) : py::none();
}

py::dict toDict(const solve::MeshQuality& quality) {
    py::dict dict;
    dict["scaled_jacobian"] = valueOrNone(quality.smallestScaledJacobian);
    dict["non_orthogonality"] = valueOrNone(quality.largestNonOrthogonality);
    dict["mean_non_orthogonality"] = quality.largestNonOrthogonality
                                         ? py::object(py::float_(quality.meanNonOrthogonality))
                                         : py::none();
    dict["severely_non_orthogonal"] = quality.severelyNonOrthogonal;
    dict["beyond_right_angle"] = quality.beyondRightAngle;
    dict["skewness"] = valueOrNone(quality.largestSkewness);
    dict["smallest_volume"] = valueOrNone(quality.smallestVolume);
    dict["non_positive_volumes"] = quality.nonPositiveVolumes.size();
    dict["negative_pyramids"] = quality.negativePyramids;
    return dict;
}

}  // namespace

void addMeshCheck(py::module_& module) {
    py::class_<SlidingPoints>(module, "SlidingPoints", R"(
Keeps the points of patches in the planes, cylinders, lines or circles that they are on at rest, while a pose
moves them. Of a patch with edges, such as the four walls of a channel, each side has a shape of its own, and
points on an edge stay on both.

model   : Model, such as the mesh of a simulation
patches : names of Model.groups
Raises ValueError, which names a patch, a distance and a point, if a side is on none of these shapes. Points on
cylinders of fewer than eight sides are on planes.
)")
        .def(py::init([](const std::shared_ptr<const ModelFile>& model,
                         const std::vector<std::string>& patches) {
                 return withoutGil([&] {
                     return std::make_unique<SlidingPoints>(slidingPoints(*model, patches));
                 });
             }),
             "model"_a.none(false), "patches"_a)
        .def_property_readonly(
            "shapes", [](const SlidingPoints& self) { return shapesOf(self.points); }, R"(
The shapes of each patch: a dict from names to lists of (kind, origin, direction, radius). The kind is "plane",
"cylinder", "line" or "circle"; the direction is of length 1: the normal of a plane or of the plane of a circle,
the axis of a cylinder, or the direction of a line.)")
        .def_property_readonly(
            "point_count", [](const SlidingPoints& self) { return self.points.pointCount(); },
            "Number of points that slide: int.")
        .def(
            "slide",
            [](const SlidingPoints& self, const ArrayLike& points) {
                auto pose = toPoints(points, "points", self.pointCount);
                const auto correction = withoutGil([&] { return self.points.slide(pose); });
                return py::make_tuple(toArray(pose), correction.distance);
            },
            "points"_a, R"(
Moves deformed points, array (N, 3), to the nearest places of their shapes, to rounding. Returns all points, array
(N, 3), and the largest distance that a point was moved back. A point that is where it is at rest stays.
)");
    py::class_<MeshCheck>(module, "MeshCheck", R"(
Finds the cells of a mesh that a deformation turns inside out. A cell is checked all over its map:
trilinear for a hexahedron; for a polyhedron linear on the tetrahedra of OpenFOAM's decomposition; quadratic
for cells of second order. If the mesh has no cells of a volume, its triangles and quadrilaterals are checked.

model : Model with cells, such as the mesh of an OpenFOAM case, or a .su2
)")
        .def(py::init([](std::shared_ptr<const ModelFile> model) {
                 return withoutGil([&] { return std::make_unique<MeshCheck>(model); });
             }),
             "model"_a.none(false))
        .def_property_readonly(
            "cell_count", [](const MeshCheck& self) { return self.check().mesh().cellCount(); },
            "Number of cells that are checked: int.")
        .def_property_readonly(
            "not_checked",
            [](const MeshCheck& self) {
                py::dict elements;
                for (const auto& [count, name] : self.unchecked()) elements[name] = count;
                return elements;
            },
            "The elements that are not checked: a dict of their names and numbers.")
        .def_property_readonly(
            "bad_at_rest", [](const MeshCheck& self) { return toArray(self.check().badAtRest()); },
            "The cells that are flat or folded at rest, ascending: array of int32.")
        .def(
            "check",
            [](const MeshCheck& self, const ArrayLike& points) {
                const auto pose = self.toPoses(points);
                return withoutGil([&] { return self.check().validity().check(pose); });
            },
            "points"_a, "Checks deformed points, array (N, 3). Returns a PoseValidity.")
        .def(
            "largest_step",
            [](const MeshCheck& self, const ArrayLike& points, double most) {
                const auto pose = self.toPoses(points);
                return withoutGil([&] { return self.check().validity().largestStep(pose, most); });
            },
            "points"_a, "most"_a = 1.0, R"(
Finds how far the points can move from rest towards deformed points before a cell folds. Returns a
LargestStep.

points : array (N, 3)
most   : how far to look, up to 1e6; 1 is the whole way
)")
        .def(
            "shorten",
            [](const MeshCheck& self, const ArrayLike& points, const std::string& criterion) {
                auto pose = self.toPoses(points);
                const auto choice = chosen(solve::kCriterionWords, "criterion", criterion);
                const solve::MeshVerdict verdict =
                    withoutGil([&] { return self.check().shorten(pose, choice); });
                return py::make_tuple(toArray(pose), verdict.written);
            },
            "points"_a, "criterion"_a = "exact", R"(
Moves deformed points, array (N, 3), back towards rest until the mesh is valid. Returns the points and
the share of the way: 1 if the mesh is valid at the deformed points. The points are rounded as Model.write()
stores them. Patches (broken_patches) are left as they are.

criterion : "exact": no cell is inverted anywhere; "solver": the volumes are positive, and in a mesh of
            OpenFOAM, checkMesh finds no more wrong pyramids and angles than at rest
)")
        .def(
            "broken_patches",
            [](const MeshCheck& self, const ArrayLike& points) {
                const auto pose = self.toPoses(points);
                const auto deviations =
                    withoutGil([&] { return self.check().constraints().check(pose); });
                py::dict broken;
                for (const solve::PatchDeviation& deviation : deviations)
                    if (deviation.isBroken)
                        broken[py::str(self.check().mesh().patches[deviation.patch].name)] =
                            deviation.distance;
                return broken;
            },
            "points"_a, R"(
Finds the symmetry planes, wedges, empty patches and periodic pairs that points, array (N, 3), break.
Returns a dict of the names of the patches and the largest distances.
)")
        .def(
            "solver_errors",
            [](const MeshCheck& self, const ArrayLike& points) {
                const auto pose = self.toPoses(points);
                return withoutGil(
                    [&] { return self.check().solverErrors(self.check().qualityAt(pose)); });
            },
            "points"_a,
            "Counts the errors that the criterion \"solver\" finds at points, array (N, 3): int.")
        .def(
            "quality",
            [](const MeshCheck& self, const ArrayLike& points) {
                const auto pose = self.toPoses(points);
                return toDict(withoutGil([&] { return self.check().qualityAt(pose); }));
            },
            "points"_a, R"(
Measures the mesh at points, array (N, 3), with the definitions of OpenFOAM's checkMesh. Returns a dict:
scaled_jacobian, non_orthogonality and mean_non_orthogonality (degrees), severely_non_orthogonal (faces
above 70 degrees), beyond_right_angle (faces at or above 90 degrees), skewness, smallest_volume, non_positive_volumes (cells) and negative_pyramids (sides
of faces). A measure is None if the mesh has nothing with it, such as internal faces.
)");
}

}  // namespace espalier::python

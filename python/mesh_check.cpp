// SPDX-License-Identifier: Apache-2.0
#include <espalier/solve/mesh_quality.h>
#include <espalier/solve/validity.h>

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

/// \throws Error if the model has no cells of a volume
io::ModelVolume volumeOf(const ModelFile& model) {
    io::ModelVolume volume = model.model->readVolume();
    if (volume.mesh.cellCount() == 0 && volume.curvedCells > 0)
        throw Error(concat("model: ", printable(model.name), " has ", volume.curvedCells,
                           " cells of a volume, all with curved edges; only cells with straight "
                           "edges can be checked"));
    if (volume.mesh.cellCount() == 0)
        throw Error(concat("model: ", printable(model.name), " has no cells of a volume"));
    return volume;
}

/// The cells of a model, and the check of its poses.
class MeshCheck {
public:
    explicit MeshCheck(std::shared_ptr<const ModelFile> model)
        : model_(std::move(model)),
          volume_(volumeOf(*model_)),
          check_(volume_.mesh, model_->model->positions()) {}

    const io::ModelVolume& volume() const { return volume_; }
    const solve::ValidityCheck& check() const { return check_; }
    std::vector<Point3> toPoses(const ArrayLike& points) const {
        return toPoints(points, "points", model_->model->positions().size());
    }

private:
    std::shared_ptr<const ModelFile> model_;
    io::ModelVolume volume_;
    solve::ValidityCheck check_;
};

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
    dict["skewness"] = valueOrNone(quality.largestSkewness);
    dict["smallest_volume"] = valueOrNone(quality.smallestVolume);
    dict["non_positive_volumes"] = quality.nonPositiveVolumes.size();
    dict["negative_pyramids"] = quality.negativePyramids;
    return dict;
}

}  // namespace

void addMeshCheck(py::module_& module) {
    py::class_<MeshCheck>(module, "MeshCheck", R"(
Finds the cells of a volume mesh that a deformation turns inside out. A cell is checked all over its map:
trilinear for a hexahedron; for a polyhedron linear on the tetrahedra of OpenFOAM's decomposition.

model : Model with cells of a volume, such as the mesh of an OpenFOAM case, or a .su2
)")
        .def(py::init([](std::shared_ptr<const ModelFile> model) {
                 return withoutGil([&] { return std::make_unique<MeshCheck>(std::move(model)); });
             }),
             "model"_a.none(false))
        .def_property_readonly(
            "cell_count", [](const MeshCheck& self) { return self.volume().mesh.cellCount(); },
            "Number of cells that are checked: int.")
        .def_property_readonly(
            "curved_cells", [](const MeshCheck& self) { return self.volume().curvedCells; },
            "Number of cells with curved edges, which are not checked: int.")
        .def_property_readonly(
            "unknown_elements", [](const MeshCheck& self) { return self.volume().unknownElements; },
            "Number of elements of types that are not known here, which are not checked: int.")
        .def_property_readonly(
            "bad_at_rest", [](const MeshCheck& self) { return toArray(self.check().badAtRest()); },
            "The cells that are flat or folded at rest, ascending: array of int32.")
        .def(
            "check",
            [](const MeshCheck& self, const ArrayLike& points) {
                const auto pose = self.toPoses(points);
                return withoutGil([&] { return self.check().check(pose); });
            },
            "points"_a, "Checks deformed points, array (N, 3). Returns a PoseValidity.")
        .def(
            "largest_step",
            [](const MeshCheck& self, const ArrayLike& points, double most) {
                const auto pose = self.toPoses(points);
                return withoutGil([&] { return self.check().largestStep(pose, most); });
            },
            "points"_a, "most"_a = 1.0, R"(
Finds how far the points can move from rest towards deformed points before a cell folds. Returns a
LargestStep.

points : array (N, 3)
most   : how far to look, up to 1e6; 1 is the whole way
)")
        .def(
            "quality",
            [](const MeshCheck& self, const ArrayLike& points) {
                const auto pose = self.toPoses(points);
                return toDict(
                    withoutGil([&] { return solve::meshQuality(self.volume().mesh, pose); }));
            },
            "points"_a, R"(
Measures the mesh at points, array (N, 3), with the definitions of OpenFOAM's checkMesh. Returns a dict:
scaled_jacobian, non_orthogonality and mean_non_orthogonality (degrees), severely_non_orthogonal (faces
above 70 degrees), skewness, smallest_volume, non_positive_volumes (cells) and negative_pyramids (sides
of faces). A measure is None if the mesh has nothing with it, such as internal faces.
)");
}

}  // namespace espalier::python

// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/number_text.h>
#include <espalier/base/printable.h>
#include <espalier/io/directions.h>
#include <espalier/io/files/file.h>
#include <espalier/io/formats.h>
#include <espalier/io/model_part.h>
#include <espalier/io/read_notes.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <optional>
#include <utility>

#include "arguments.h"
#include "binding.h"

namespace espalier::python {

using namespace py::literals;

ModelFile modelOfBytes(std::string name, std::string bytes) {
    auto model = io::readModel(name, bytes);
    return {std::move(name), std::move(bytes), std::move(model)};
}

std::vector<Point3> pointsOf(const ModelFile& file) {
    const auto points = file.model->positions();
    return {points.begin(), points.end()};
}

namespace {

/// Converts the name as os.fsdecode() does: bytes that are not UTF-8 become surrogates.
py::str nameOf(const ModelFile& file) {
    PyObject* const name = PyUnicode_DecodeFSDefaultAndSize(
        file.name.data(), static_cast<Py_ssize_t>(file.name.size()));
    if (name == nullptr) throw py::error_already_set();
    return py::reinterpret_steal<py::str>(name);
}

std::vector<DeformationGradient> toGradients(const ArrayLike& object, std::size_t count) {
    const auto array = realArray<double>(object, "gradients");
    if (array.ndim() != 3 || array.shape(0) != static_cast<py::ssize_t>(count) ||
        array.shape(1) != 3 || array.shape(2) != 3)
        throw Error(concat("gradients: expected an array of shape (", count, ", 3, 3)"));
    std::vector<DeformationGradient> result(count);
    std::memcpy(result.data(), array.data(), count * sizeof(DeformationGradient));
    return result;
}

/// Turns directions by gradients.
template <Point3 (*carry)(const DeformationGradient&, const Point3&)>
py::array carriedBy(const ArrayLike& gradients, const ArrayLike& directions, const char* name) {
    auto vectors = toPoints(directions, name);
    const auto atPoints = toGradients(gradients, vectors.size());
    for (std::size_t i = 0; i < vectors.size(); ++i) vectors[i] = carry(atPoints[i], vectors[i]);
    py::array_t<double> result({static_cast<py::ssize_t>(vectors.size()), py::ssize_t{3}});
    std::memcpy(result.mutable_data(), vectors.data(), vectors.size() * sizeof(Point3));
    return result;
}

/// Returns a warning that directions stay where points have moved; or nothing.
std::string keptDirections(const ModelFile& file, const std::vector<Point3>& points) {
    const std::size_t count = file.model->directions().count();
    if (count == 0 || std::ranges::equal(points, file.model->positions())) return {};
    return concat(
        file.name, ": ", count,
        count == 1 ? " normal, tangent or splat stays" : " normals, tangents and splats stay",
        " as in the file, though points have moved: pass "
        "gradients=binding.gradients(pose), or gradients=False to leave them");
}

}  // namespace

void addModel(py::module_& module) {
    py::class_<ModelFile, std::shared_ptr<ModelFile>>(module, "Model", R"(
A model to deform: a file that contains points. Writing it with other points keeps everything else
byte for byte, unless it is written in another format. Made by read_model().
)")
        .def_property_readonly(
            "positions",
            [](const py::object& self) {
                const auto points = self.cast<const ModelFile&>().model->positions();
                return viewOf(std::span<const double>(points.data()->data(), 3 * points.size()),
                              {static_cast<py::ssize_t>(points.size()), 3}, self);
            },
            "The points, in the order of the file: array (N, 3) of float64, read-only. All are "
            "finite: "
            "the first finite point stands in for points of the file that are not, which write() "
            "keeps.")
        .def_property_readonly(
            "notes", [](const ModelFile& self) { return self.model->notes(); },
            "Phrases on parts of the file that are skipped, or kept without being understood: list "
            "of str, usually empty.")
        .def_property_readonly(
            "attributes",
            [](const ModelFile& self) { return io::namesOf(self.model->attributes()); },
            "Names of the numbers at the points that attribute() reads and bind() takes as "
            "weights: list of str. \"NAME:0\" is the first of several numbers.")
        .def_property_readonly(
            "groups",
            [](const ModelFile& self) {
                return io::namesOf(withoutGil([&] { return self.model->groups(); }));
            },
            "Names of the groups, objects and materials of an OBJ, of the meshes, nodes and "
            "materials of glTF, and of the patches, markers and groups of a mesh: list of str, for "
            "bind() and SlidingPoints.")
        .def(
            "attribute",
            [](const ModelFile& self, const std::string& name) {
                const auto values =
                    withoutGil([&] { return io::numbersOf(self.name, *self.model, name); });
                return py::array_t<double>(static_cast<py::ssize_t>(values.size()), values.data());
            },
            "name"_a, "Returns the numbers of one of the attributes: array (N,) of float64.")
        .def_property_readonly("name", &nameOf, "Name of the file, without folders: str.")
        .def(
            "write",
            [](const ModelFile& self, const std::filesystem::path& path, const ArrayLike& positions,
               const py::object& gradients) {
                const auto points =
                    toPoints(positions, "positions", self.model->positions().size());
                warn(withoutGil([&] { return self.model->checkTarget(path); }));
                const bool areKept =
                    py::isinstance<py::bool_>(gradients) && !gradients.cast<bool>();
                if (gradients.is_none()) warn(keptDirections(self, points));
                if (gradients.is_none() || areKept)
                    return withoutGil([&] { self.model->write(path, points); });
                const auto atPoints = toGradients(gradients, points.size());
                withoutGil([&] { self.model->write(path, points, atPoints); });
            },
            "path"_a, "positions"_a, "gradients"_a = py::none(), R"(
Writes the model with these points, array (N, 3). The extension of the path names the format. In the
model's own format, everything but the points is kept. A file in another model format gets the points,
the faces and the normals, and a UserWarning names the data that are not written.

gradients : array (N, 3, 3), by which normals, tangents and splats turn: Binding.gradients(). With False they stay as
            they are. Without gradients they stay, too, and a UserWarning counts them if points have moved
)")
        .def("__repr__", [](const ModelFile& self) {
            return py::str("<espalier.Model: {}, {} points>")
                .format(printable(self.name), self.model->positions().size());
        });
    module.def(
        "carry_normals",
        [](const ArrayLike& gradients, const ArrayLike& normals) {
            return carriedBy<io::carryNormal>(gradients, normals, "normals");
        },
        "gradients"_a, "normals"_a, R"(
Returns normals of a deformed surface, one per point, along det(F) F^-T n, with their lengths: array
(N, 3). A vector of zeros stays zero.

gradients : array (N, 3, 3), the deformation gradient F of each point: Binding.gradients()
normals   : array (N, 3), the normals at rest
)");
    module.def(
        "carry_tangents",
        [](const ArrayLike& gradients, const ArrayLike& tangents) {
            return carriedBy<io::carryTangent>(gradients, tangents, "tangents");
        },
        "gradients"_a, "tangents"_a,
        "Returns tangents of a deformed surface, one per point, along F t, with their lengths: "
        "array (N, 3). The arguments are as in carry_normals().");
    module.def(
        "read_model",
        [](const std::filesystem::path& path) {
            auto file = withoutGil([&] {
                const std::filesystem::path name = io::modelFile(path);
                auto bytes = io::readModelBytes(name);
                auto model = io::readModel(name, bytes);
                return std::make_shared<ModelFile>(
                    ModelFile{io::modelName(name), std::move(bytes), std::move(model)});
            });
            warn(io::describe(path, *file->model));
            return file;
        },
        "path"_a,
        ("Reads a Model from " + io::listOfFormats(io::FileContent::Model, io::FileUse::Read) +
         ". A UserWarning names parts of the file that are skipped, or kept without being "
         "understood: Model.notes.")
            .c_str());
}

}  // namespace espalier::python

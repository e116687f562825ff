// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/number_text.h>
#include <espalier/base/printable.h>
#include <espalier/io/files/file.h>
#include <espalier/io/formats.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
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
            "The points, in the order of the file: array (N, 3) of float64, read-only.")
        .def_property_readonly("name", &nameOf, "Name of the file, without folders: str.")
        .def(
            "write",
            [](const ModelFile& self, const std::filesystem::path& path,
               const ArrayLike& positions) {
                const auto points =
                    toPoints(positions, "positions", self.model->positions().size());
                warn(withoutGil([&] { return self.model->checkTarget(path); }));
                withoutGil([&] { self.model->write(path, points); });
            },
            "path"_a, "positions"_a, R"(
Writes the model with these points, array (N, 3). The extension of the path names the format. In the
model's own format, everything but the points is kept. A file in another model format gets the points,
the faces and the normals, and a UserWarning names the data that are not written.
)")
        .def("__repr__", [](const ModelFile& self) {
            return py::str("<espalier.Model: {}, {} points>")
                .format(printable(self.name), self.model->positions().size());
        });
    module.def(
        "read_model",
        [](const std::filesystem::path& path) {
            return withoutGil([&] {
                const std::filesystem::path file = io::modelFile(path);
                auto bytes = io::readFile(file);
                auto model = io::readModel(file, bytes);
                return std::make_shared<ModelFile>(
                    ModelFile{file.filename().string(), std::move(bytes), std::move(model)});
            });
        },
        "path"_a,
        ("Reads a Model from " + io::listOfFormats(io::FileContent::Model, io::FileUse::Read) + ".")
            .c_str());
}

}  // namespace espalier::python

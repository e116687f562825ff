// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>
#include <espalier/io/meshes/gmsh.h>
#include <espalier/io/meshes/medit.h>
#include <espalier/io/meshes/openfoam.h>
#include <espalier/io/meshes/plot3d.h>
#include <espalier/io/meshes/su2.h>
#include <espalier/io/model.h>
#include <espalier/io/models/obj.h>
#include <espalier/io/models/ply.h>
#include <espalier/io/models/stl.h>
#include <espalier/io/vtk/vtk_legacy.h>
#include <espalier/io/vtk/vtu.h>

#include <cmath>
#include <string>
#include <utility>

namespace espalier::io {
namespace {

struct ModelFormat {
    std::string_view extension;  ///< or the name of the file
    ModelReader read;
};

/// Returns all formats, with the formats of optional components.
std::vector<ModelFormat>& modelFormats() {
    static std::vector<ModelFormat> formats = {
        {".obj", readObj},           {".ply", readPly},         {".stl", readStl},
        {".vtu", readVtuModel},      {".vtp", readVtpModel},    {".vtk", readVtkLegacyModel},
        {".su2", readSu2Model},      {".msh", readGmshModel},   {".mesh", readMeditModel},
        {".xyz", readPlot3dModel},   {".p3d", readPlot3dModel}, {".fmt", readPlot3dModel},
        {kFoamPoints, readFoamModel}};
    return formats;
}

const ModelFormat* findModelFormat(const std::filesystem::path& path) {
    const std::string extension = lowerCase(path.extension().string());
    for (const ModelFormat& format : modelFormats())
        if (format.extension == extension || (format.read == readFoamModel && isFoamPath(path)))
            return &format;
    return nullptr;
}

const ModelFormat& requireFormat(const std::filesystem::path& path) {
    if (const ModelFormat* format = findModelFormat(path)) return *format;
    std::string known;
    for (const ModelFormat& format : modelFormats())
        if (format.read != readFoamModel)
            known.append(known.empty() ? "" : ", ").append(format.extension);
    throw FileError(path,
                    "is not of a known model format; expected " + known + " or an OpenFOAM case");
}

/// Throws unless there is one set of finite numbers per point.
template <class Numbers>
void checkAll(std::span<const Numbers> values, std::size_t pointCount, const std::string& plural,
              const std::string& singular) {
    if (values.size() != pointCount)
        throw Error(
            concat("got ", values.size(), " ", plural, " for a model of ", pointCount, " points"));
    for (std::size_t point = 0; point < values.size(); ++point)
        for (const double number : values[point])
            if (!std::isfinite(number))
                throw Error(concat("the ", singular, " of point ", point, " is not finite"));
}

}  // namespace

std::filesystem::path modelFile(const std::filesystem::path& path) {
    return foamPointsOf(path);
}

std::filesystem::path modelTarget(const std::filesystem::path& path) {
    return foamTargetOf(path);
}

void Model::checkTarget(const std::filesystem::path& path) const {
    // A new name without an extension may be meant as the folder of a case.
    std::error_code ignored;
    const bool isDevice = std::filesystem::exists(path, ignored) &&
                          !std::filesystem::is_regular_file(path, ignored) &&
                          !std::filesystem::is_directory(path, ignored);
    if (extension() == kFoamPoints && path.filename() != kFoamPoints && !isDevice)
        throw FileError(
            path,
            "the points of an OpenFOAM mesh are written to a file of the name 'points', "
            "or into a folder with a copy of the case (cp -r CASE COPY)");
    const ModelFormat* format = findModelFormat(path);
    if (format && format->extension != extension())
        throw FileError(
            path, concat("a model that was read as ", extension(), " can only be written as ",
                         extension(),
                         ", because everything but its coordinates is copied from "
                         "its file; name the output ",
                         shownPath(std::filesystem::path(path).replace_extension(extension())),
                         ", or convert the model to ", format->extension, " first"));
}

void Model::write(const std::filesystem::path& path, std::span<const Point3> moved) const {
    const std::filesystem::path target = modelTarget(path);
    check(target, moved);
    writeChecked(target, moved, {});
}

void Model::write(const std::filesystem::path& path, std::span<const Point3> moved,
                  std::span<const DeformationGradient> gradients) const {
    const std::filesystem::path target = modelTarget(path);
    check(target, moved);
    checkAll(gradients, positions().size(), "gradients", "gradient");
    writeChecked(target, moved, gradients);
}

void Model::check(const std::filesystem::path& path, std::span<const Point3> moved) const {
    checkTarget(path);
    checkAll(moved, positions().size(), "positions", "new position");
}

void addModelFormat(std::string_view extension, ModelReader read) {
    for (const ModelFormat& format : modelFormats())
        if (format.extension == extension) return;
    modelFormats().push_back({extension, read});
}

bool isModelFile(const std::filesystem::path& path) {
    return findModelFormat(path) != nullptr;
}

std::unique_ptr<Model> readModel(const std::filesystem::path& path) {
    const std::filesystem::path file = modelFile(path);
    requireFormat(file);
    return readModel(file, readFile(file));
}

std::unique_ptr<Model> readModel(const std::filesystem::path& path, std::string bytes) {
    std::unique_ptr<Model> model = requireFormat(path).read(path, std::move(bytes));
    if (model->positions().empty()) throw FileError(path, "the model has no points");
    return model;
}

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/printable.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>
#include <espalier/io/model.h>
#include <espalier/io/models/obj.h>
#include <espalier/io/models/ply.h>
#include <espalier/io/models/stl.h>
#include <espalier/io/vtk/vtk_legacy.h>
#include <espalier/io/vtk/vtu.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "models/model_conversion.h"
#include "models/surface_writers.h"
#include "vtk/vtk_surface_writers.h"

namespace espalier::io {
namespace {

using Normals = SurfaceFormat::Normals;

struct ModelFormat {
    SurfaceFormat surfaces;
    std::unique_ptr<Model> (*read)(const std::filesystem::path&, std::string bytes);

    std::string_view extension() const { return surfaces.extension; }
};

constexpr ModelFormat kModelFormats[] = {
    {{".obj", Normals::Corners, writeObjSurface}, readObj},
    {{".ply", Normals::Points, writePlySurface}, readPly},
    {{".stl", Normals::Facets, writeStlSurface}, readStl},
    {{".vtu", Normals::Points, writeVtuSurface}, readVtuModel},
    {{".vtp", Normals::Points, writeVtpSurface}, readVtpModel},
    {{".vtk", Normals::Points, writeVtkLegacySurface}, readVtkLegacyModel}};

const ModelFormat* findModelFormat(const std::filesystem::path& path) {
    const std::string extension = lowerCase(path.extension().string());
    for (const ModelFormat& format : kModelFormats)
        if (format.extension() == extension) return &format;
    return nullptr;
}

std::string knownExtensions() {
    std::string known;
    for (const ModelFormat& format : kModelFormats)
        known.append(known.empty() ? "" : ", ").append(format.extension());
    return known;
}

const ModelFormat& requireFormat(const std::filesystem::path& path) {
    if (const ModelFormat* format = findModelFormat(path)) return *format;
    const std::string known = knownExtensions();
    constexpr std::string_view kIndices[] = {".vtm", ".pvd", ".pvtu", ".pvtp"};
    if (std::ranges::count(kIndices, lowerCase(path.extension().string())) > 0)
        throw FileError(path, "lists other files; name one of these files (" + known + ")");
    throw FileError(path, "is not of a known model format; expected " + known);
}

/// Returns true for the number of a pose: ".0001".
bool isNumber(const std::string& extension) {
    return extension.size() > 1 &&
           extension.find_first_not_of("0123456789", 1) == std::string::npos;
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

void ModelSurface::addOther(const std::string& kind, const std::string& name) {
    auto other = std::ranges::find(others, kind, &OtherData::kind);
    if (other == others.end()) other = others.insert(others.end(), {kind, {}});
    if (!name.empty() && std::ranges::count(other->names, name) == 0) other->names.push_back(name);
}

std::string Model::checkTarget(const std::filesystem::path& path) const {
    const ModelFormat* format = findModelFormat(path);
    if (!format && path.has_extension() && !isNumber(path.extension().string()))
        return concat(shownPath(path), ": is written as ", extension(),
                      ", the format of the model, because ", printable(path.extension().string()),
                      " is no known model format; known are ", knownExtensions());
    if (!format || format->extension() == extension()) return {};
    return conversionTo(format->surfaces, path)->losses(path);
}

void Model::write(const std::filesystem::path& path, std::span<const Point3> moved) const {
    checkAll(moved, positions().size(), "positions", "new position");
    writeInFormat(path, moved, {});
}

void Model::write(const std::filesystem::path& path, std::span<const Point3> moved,
                  std::span<const DeformationGradient> gradients) const {
    checkAll(moved, positions().size(), "positions", "new position");
    checkAll(gradients, positions().size(), "gradients", "gradient");
    writeInFormat(path, moved, gradients);
}

void Model::writeInFormat(const std::filesystem::path& path, std::span<const Point3> moved,
                          std::span<const DeformationGradient> gradients) const {
    const ModelFormat* format = findModelFormat(path);
    if (!format || format->extension() == extension())
        writeChecked(path, moved, gradients);
    else
        conversionTo(format->surfaces, path)->write(path, moved, gradients);
}

std::shared_ptr<const ModelConversion> Model::conversionTo(
    const SurfaceFormat& format, const std::filesystem::path& path) const {
    {
        const std::lock_guard lock(conversionMutex_);
        if (conversion_ && conversion_->extension() == format.extension) return conversion_;
    }
    // Made without the lock, so that no thread waits. Several threads may make equal conversions.
    auto made = std::make_shared<const ModelConversion>(*this, format, path);
    const std::lock_guard lock(conversionMutex_);
    conversion_ = made;
    return made;
}

bool isModelFile(const std::filesystem::path& path) {
    return findModelFormat(path) != nullptr;
}

std::unique_ptr<Model> readModel(const std::filesystem::path& path) {
    requireFormat(path);
    return readModel(path, readFile(path));
}

std::unique_ptr<Model> readModel(const std::filesystem::path& path, std::string bytes) {
    std::unique_ptr<Model> model = requireFormat(path).read(path, std::move(bytes));
    if (model->positions().empty()) throw FileError(path, "the model has no points");
    return model;
}

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/printable.h>
#include <espalier/base/progress.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>
#include <espalier/io/model.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <system_error>
#include <utility>

#include "files/other_content.h"
#include "format.h"
#include "meshes/openfoam.h"
#include "models/coordinates.h"
#include "models/model_conversion.h"

namespace espalier::io {
namespace {

/// Returns the format to which a model is converted if it is written to `path`; null if it is
/// written in its own.
/// \throws FileError if the model, or any model, cannot be written under this name
const Format* conversionFor(const Model& model, const std::filesystem::path& path) {
    if (&model.format() == &kFoamFormat) return nullptr;
    if (isPathOf(model.format(), path)) return nullptr;
    const Format* format = findFormat(path, FileContent::Model);
    if (!format) return nullptr;
    if (!format->writeSurface)
        throw FileError(
            path,
            concat("a model that was read as ", model.extension(), " cannot be written as ",
                   format->extension(),
                   format->isMesh ? ", because this is a format of meshes with cells, and "
                                    "only the coordinates of such a mesh can be replaced"
                                  : ", which is only read",
                   "; name the output ",
                   shownPath(std::filesystem::path(path).replace_extension(model.extension()))));
    return format;
}

const Format& requireFormat(const std::filesystem::path& path) {
    if (const Format* format = findFormat(path, FileContent::Model)) return *format;
    constexpr std::string_view kIndices[] = {".vtm", ".pvd", ".pvtu", ".pvtp"};
    if (std::ranges::count(kIndices, lowerCase(path.extension().string())) > 0)
        throw FileError(path, "lists other files; name one of these files (" +
                                  listOfFormats(FileContent::Model, FileUse::Write) + ")");
    throw FileError(path, "is not of a known model format; expected " +
                              listOfFormats(FileContent::Model, FileUse::Read));
}

/// Returns the extension of the format that a path has; the first of the format if it has none.
std::string_view extensionOf(const Format& format, const std::filesystem::path& path) {
    const auto extension =
        std::ranges::find(format.extensions, lowerCase(path.extension().string()));
    return extension == format.extensions.end() || extension->empty() ? format.extension()
                                                                      : *extension;
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
    for (std::size_t point = 0; point < values.size(); ++point) {
        checkCancelledEvery(point, 16);
        for (const double number : values[point])
            if (!std::isfinite(number))
                throw Error(concat("the ", singular, " of point ", point, " is not finite"));
    }
}

std::vector<std::filesystem::path> pathsOf(const FoamCase& files) {
    std::vector<std::filesystem::path> paths;
    for (const auto& file : files.files) paths.push_back(files.root / file);
    return paths;
}

/// Returns the path that the format of a model writes: the file of points for a folder, but the
/// folder of a decomposed case itself.
std::filesystem::path modelTarget(const std::filesystem::path& path) {
    const FoamCase files = foamTargetOf(path);
    return files.isDecomposed ? path : files.root / files.files.front();
}

}  // namespace

std::filesystem::path modelFile(const std::filesystem::path& path) {
    std::error_code ignored;
    if (!namesFormat(path) && !std::filesystem::exists(path, ignored))
        throw FileError(path, "no such file or folder");
    const FoamCase files = foamCaseOf(path);
    return files.isDecomposed ? path : files.root / files.files.front();
}

std::vector<std::filesystem::path> modelFiles(const std::filesystem::path& path) {
    return pathsOf(foamCaseOf(path));
}

std::vector<std::filesystem::path> modelTargets(const std::filesystem::path& path) {
    return pathsOf(foamTargetOf(path));
}

std::string readModelBytes(const std::filesystem::path& path) {
    const FoamCase files = foamCaseOf(path);
    return files.isDecomposed ? archiveOf(files) : readFile(files.root / files.files.front());
}

std::string modelName(const std::filesystem::path& path) {
    const FoamCase files = foamCaseOf(path);
    return files.isDecomposed ? std::string(kFoamPoints) : files.files.front().string();
}

void ModelSurface::addOther(const std::string& kind, const std::string& name) {
    auto other = std::ranges::find(others, kind, &OtherData::kind);
    if (other == others.end()) other = others.insert(others.end(), {kind, {}});
    if (!name.empty() && known_.emplace(kind, name).second) other->names.push_back(name);
}

void ModelSurface::removePointData(const std::string& name) {
    std::erase_if(others, [&](OtherData& other) {
        const bool isOfPoints =
            other.kind == OtherData::kPointData || other.kind == OtherData::kPointProperties;
        return isOfPoints && std::erase(other.names, name) > 0 && other.names.empty();
    });
}

void ModelSurface::replaceFaces(
    const std::function<std::vector<std::vector<std::size_t>>(std::size_t face)>& replace) {
    ModelFaces newFaces;
    std::vector<Index> newNormals, newTextures, newMaterials;
    for (std::size_t face = 0; face < faces.count(); ++face) {
        const std::size_t begin = face == 0 ? 0 : faces.ends[face - 1];
        for (const std::vector<std::size_t>& loop : replace(face)) {
            for (const std::size_t corner : loop) {
                newFaces.corners.push_back(faces.corners[begin + corner]);
                if (!normalCorners.empty()) newNormals.push_back(normalCorners[begin + corner]);
                if (!textureCorners.empty()) newTextures.push_back(textureCorners[begin + corner]);
            }
            newFaces.endFace();
            if (!faceMaterials.empty()) newMaterials.push_back(faceMaterials[face]);
        }
    }
    faces = std::move(newFaces);
    normalCorners = std::move(newNormals);
    textureCorners = std::move(newTextures);
    faceMaterials = std::move(newMaterials);
}

std::vector<ElementCount> cellCounts(const far::SimulationMesh& mesh) {
    constexpr std::size_t kPolyhedra = 4, kTriangles = 5, kQuadrilaterals = 6;
    std::vector<ElementCount> counts = {{0, "tetrahedra"},    {0, "pyramids"},  {0, "wedges"},
                                        {0, "hexahedra"},     {0, "polyhedra"}, {0, "triangles"},
                                        {0, "quadrilaterals"}};
    for (Index cell = 0; cell < mesh.volume.cellCount(); ++cell) {
        const auto kind = mesh.volume.kind(cell);
        ++counts[kind ? static_cast<std::size_t>(*kind) : kPolyhedra].count;
    }
    for (Index face = 0; face < mesh.surface.faceCount(); ++face)
        ++counts[mesh.surface.corners(face).size() == 3 ? kTriangles : kQuadrilaterals].count;
    return counts;
}

Index secondOrderCount(const far::SimulationMesh& mesh) {
    Index count = 0;
    for (Index cell = 0; cell < mesh.volume.cellCount(); ++cell)
        count += mesh.volume.isSecondOrder(cell) ? 1 : 0;
    for (Index face = 0; face < mesh.surface.faceCount(); ++face)
        count += mesh.surface.isSecondOrder(face) ? 1 : 0;
    return count;
}

std::vector<ElementCount> uncheckedElements(const ModelCells& cells) {
    std::vector<ElementCount> all = {
        {cells.curvedCells, "cells of third order and above or of an unknown order of points"},
        {cells.curvedFaces, "faces of third order and above or of an unknown order of points"},
        {cells.polygons, "faces with more than 4 corners"},
        {cells.facesBeside, "faces of surfaces that are no faces of cells"},
        {cells.unknownElements, "elements of unknown types"},
        {cells.facesApart, "faces between processes, which have other points in each of the two"},
        {cells.missingElements, "elements that boundary conditions name, but no section has"}};
    std::erase_if(all, [](const ElementCount& elements) { return elements.count == 0; });
    return all;
}

std::vector<PointGroup> groupsOf(std::vector<far::MeshPatch> patches) {
    std::vector<PointGroup> groups;
    for (far::MeshPatch& patch : patches)
        groups.push_back(
            {std::move(patch.name), [points = std::move(patch.points)] { return points; }});
    return groups;
}

ModelFaces boundaryFaces(const far::VolumeMesh& mesh) {
    ModelFaces faces;
    for (Index face = mesh.internalFaceCount(); face < mesh.faceCount(); ++face) {
        const auto loop = mesh.face(face);
        faces.corners.insert(faces.corners.end(), loop.begin(), loop.end());
        faces.endFace();
    }
    return faces;
}

Model::Model(const Format& format, const std::filesystem::path& path)
    : format_(format), extension_(extensionOf(format, path)) {}

std::vector<Point3> Model::stored(std::vector<Point3> points) const {
    if (storage() == CoordinateStorage::Float)
        for (Point3& point : points)
            for (double& coordinate : point) roundToFloat(coordinate);
    return points;
}

std::string Model::checkTarget(const std::filesystem::path& name) const {
    const std::filesystem::path path = modelTarget(name);
    if (const Format* other = conversionFor(*this, path))
        return conversionTo(*other, path)->losses(path);
    checkExtension(path);
    checkOwnTarget(path);
    const std::string losses = ownLosses();
    return losses.empty() ? losses : shownPath(path) + ": " + losses;
}

/// Refuses an extension that is no model format. A file of this name in the format of the model
/// would mislead every program that reads it.
void Model::checkExtension(const std::filesystem::path& path) const {
    const std::string word = path.extension().string();
    if (&format_ != &kFoamFormat && !isFileOf(FileContent::Model, path) && !word.empty() &&
        !isNumber(word))
        throw FileError(path,
                        concat(printable(word), " is no known model format; expected ",
                               listOfFormats(FileContent::Model, FileUse::Write),
                               ", or a name without extension, which is written as ", extension()));
}

void Model::write(const std::filesystem::path& path, std::span<const Point3> moved) const {
    const std::filesystem::path target = modelTarget(path);
    checkAll(moved, positions().size(), "positions", "new position");
    writeInFormat(target, moved, {});
}

void Model::write(const std::filesystem::path& path, std::span<const Point3> moved,
                  std::span<const DeformationGradient> gradients) const {
    const std::filesystem::path target = modelTarget(path);
    checkAll(moved, positions().size(), "positions", "new position");
    checkAll(gradients, positions().size(), "gradients", "gradient");
    writeInFormat(target, moved, gradients);
}

void Model::writeInFormat(const std::filesystem::path& path, std::span<const Point3> moved,
                          std::span<const DeformationGradient> gradients) const {
    if (const Format* other = conversionFor(*this, path))
        return conversionTo(*other, path)->write(path, moved, gradients);
    checkExtension(path);
    checkOwnTarget(path);
    writeChecked(path, moved, gradients);
}

std::shared_ptr<const ModelConversion> Model::conversionTo(
    const Format& format, const std::filesystem::path& path) const {
    {
        const std::lock_guard lock(conversionMutex_);
        if (conversion_ && &conversion_->format() == &format) return conversion_;
    }
    // Made without the lock, so that no thread waits. Several threads may make equal conversions.
    auto made = std::make_shared<const ModelConversion>(*this, format, path);
    const std::lock_guard lock(conversionMutex_);
    conversion_ = made;
    return made;
}

void refuseHeldPoints(const std::filesystem::path& path, const Model& model) {
    if (const std::vector<Index> held = model.heldPoints(); !held.empty())
        throw FileError(path, concat("point ", held.front(), " is not finite"));
}

std::unique_ptr<Model> readModel(const std::filesystem::path& path) {
    const std::filesystem::path file = modelFile(path);
    requireFormat(file);
    return readModel(file, readModelBytes(file));
}

std::unique_ptr<Model> readModel(const std::filesystem::path& path, std::string bytes) {
    const Format& format = formatOfFile(requireFormat(path), path, FileContent::Model, bytes);
    return explainingContent(path, bytes, [&] {
        std::unique_ptr<Model> model = format.readModel(format, path, std::move(bytes));
        if (model->positions().empty()) throw FileError(path, "the model has no points");
        return model;
    });
}

}  // namespace espalier::io

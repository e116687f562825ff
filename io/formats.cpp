// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/text_reader.h>
#include <espalier/io/formats.h>

#include <algorithm>
#include <string>
#include <vector>

#include "format.h"

namespace espalier::io {
namespace {

/// All formats, in the order in which messages list them; and the formats of optional components.
std::vector<const Format*>& formats() {
    static std::vector<const Format*> formats = {&kOvmFormat,          &kObjFormat,
                                                 &kPlyFormat,          &kStlFormat,
                                                 &kVtuFormat,          &kVtpFormat,
                                                 &kVtkLegacyFormat,    &kGmshFormat,
                                                 &kSu2Format,          &kMeditFormat,
                                                 &kNastranFormat,      &kAbaqusFormat,
                                                 &kIdeasFormat,        &kFluentFormat,
                                                 &kPlot3dFormat,       &kFoamFormat,
                                                 &kMatrixMarketFormat, &kNumpyArchiveFormat,
                                                 &kNumpyArraysFormat,  &kPetscBinaryFormat,
                                                 &kPointCacheFormat,   &kMotionDesignerFormat,
                                                 &kGltfFormat,         &kBoundModelFormat,
                                                 &kTargetsFormat,      &kCommaSeparatedFormat};
    return formats;
}

/// Adds the extensions of a format. Several formats may have the same one.
void addExtensions(const Format& format, std::vector<std::string>& names) {
    for (const std::string_view extension : format.extensions)
        if (!extension.empty() && std::ranges::count(names, extension) == 0)
            names.emplace_back(extension);
}

/// Returns ".ovm, .vtu or .vtk".
std::string joined(const std::vector<std::string>& names) {
    std::string text;
    for (std::size_t i = 0; i < names.size(); ++i)
        text += (i == 0 ? "" : i + 1 < names.size() ? ", " : " or ") + names[i];
    return text;
}

}  // namespace

bool Format::holds(FileContent content, FileUse use) const {
    const bool isRead = use == FileUse::Read;
    switch (content) {
        case FileContent::Lattice:
            return isRead ? readLattice != nullptr : writeLattice != nullptr;
        case FileContent::Mesh:
            return isRead ? readMesh != nullptr : writeMesh != nullptr;
        case FileContent::Model:
            return isRead ? readModel != nullptr : writeSurface != nullptr;
        case FileContent::EditorMesh:
            return isEditorMesh;
        case FileContent::Matrix:
            return isRead ? readMatrix != nullptr : writeDoubles != nullptr;
        case FileContent::Animation:
            return !isRead && writeAnimation;
        case FileContent::BoundModel:
            return isBoundModel;
        case FileContent::Targets:
            return isRead && isTargets;
        case FileContent::Displacements:
            return isRead && isDisplacements;
    }
    return false;
}

bool isPathOf(const Format& format, const std::filesystem::path& path) {
    const std::string extension = lowerCase(path.extension().string());
    return (!extension.empty() && std::ranges::count(format.extensions, extension) > 0) ||
           (format.isPath && format.isPath(path));
}

const Format& formatOfFile(const Format& found, const std::filesystem::path& path,
                           FileContent content, std::string_view bytes) {
    for (const Format* format : formats())
        if (format->isContent && format->holds(content, FileUse::Read) && isPathOf(*format, path) &&
            format->isContent(bytes))
            return *format;
    return found;
}

const Format* findFormat(const std::filesystem::path& path, FileContent content, FileUse use) {
    for (const Format* format : formats())
        if (format->holds(content, use) && isPathOf(*format, path)) return format;
    return nullptr;
}

bool namesFormat(const std::filesystem::path& path) {
    return std::ranges::any_of(formats(),
                               [&](const Format* format) { return isPathOf(*format, path); });
}

void addFormat(const Format& format) {
    if (std::ranges::count(formats(), &format) == 0) formats().push_back(&format);
}

bool isFileOf(FileContent content, const std::filesystem::path& path, FileUse use) {
    return findFormat(path, content, use) != nullptr;
}

bool isMeshFile(const std::filesystem::path& path) {
    const Format* format = findFormat(path, FileContent::Model, FileUse::Read);
    return format && format->isMesh;
}

std::vector<std::string> extensionsOf(FileContent content, FileUse use) {
    std::vector<std::string> extensions;
    for (const Format* format : formats())
        if (format->holds(content, use) && format->words.empty())
            addExtensions(*format, extensions);
    return extensions;
}

std::string listOfFormats(FileContent content, FileUse use) {
    std::vector<std::string> usual, meshes;
    for (const Format* format : formats()) {
        if (!format->holds(content, use)) continue;
        auto& names = format->isMesh ? meshes : usual;
        if (!format->words.empty()) {
            names.emplace_back(format->words);
            continue;
        }
        addExtensions(*format, names);
    }
    if (meshes.empty()) return joined(usual);
    return joined(usual) + ", or the mesh of a simulation (" + joined(meshes) + ")";
}

}  // namespace espalier::io

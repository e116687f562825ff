// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/array.h>
#include <espalier/base/memory.h>
#include <espalier/io/directions.h>
#include <espalier/io/files/file.h>
#include <espalier/io/models/obj_mesh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <ostream>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "../files/text_output.h"
#include "file_model.h"
#include "obj_normals.h"
#include "obj_statements.h"
#include "point_data.h"
#include "surface_writers.h"

// Wavefront OBJ. Its points are the `v` statements, and its directions the `vn`
// statements. All other statements, and everything in a `v` besides x, y and z (w, colours,
// spacing, comments, line ends), are kept and not interpreted.
//
// A backslash at the end of a line continues the statement on the next line, except in a comment.
// A coordinate that changes is written as the shortest text that reads back as the same double; a
// coordinate that does not change keeps its text. A file without `v` is a model without points.
// Lines whose first word is not in the specification are kept, too, and a note counts them.
//
// obj_normals.h says how the normals follow.
//
// The faces are the statements `f` and `fo`.
//
// The text and 48 bytes per point are kept. Writing takes one pass, or three with gradients.

namespace espalier::io {

namespace {

FileNumbers readObjNumbers(const std::filesystem::path& path, std::string_view text) {
    FileNumbers numbers;
    const std::size_t expected = expectedPoints(text);
    requireMemory(expected * (sizeof(Point3) + sizeof(CoordinateOffsets)),
                  shownPath(path) + ": a list of its points");
    numbers.points.values.reserve(expected);
    numbers.points.offsets.reserve(expected);
    ObjKeywords keywords(path);
    forEachObjStatement(path, text, [&](ObjWords& words, std::size_t line) {
        const std::string_view keyword = keywords.read(words, line);
        if (keyword == "vn") ++numbers.ownNormals;
        if (keyword != "v") return;
        const ObjPoint point = readObjPoint(words, path, line);
        numbers.points.values.push_back(point.position);
        CoordinateOffsets& offsets = numbers.points.offsets.emplace_back();
        for (std::size_t axis = 0; axis < 3; ++axis)
            offsets[axis] = point.words[axis].data() - text.data();
    });
    keywords.checkFile(!numbers.points.values.empty());
    if (const std::string lines = keywords.unknown(); !lines.empty())
        numbers.notes.push_back("kept " + lines);
    return numbers;
}

void nameOtherData(std::string_view keyword, ModelSurface& surface) {
    constexpr std::pair<std::string_view, const char*> kKinds[] = {{"g", "groups"},
                                                                   {"o", "names of objects"},
                                                                   {"s", "smoothing groups"},
                                                                   {"mtllib", "material libraries"},
                                                                   {"l", "lines"},
                                                                   {"p", "point elements"},
                                                                   {"t", "tags of subdivision"}};
    constexpr std::string_view kFreeForm[] = {"curv", "curv2", "surf"};
    if (std::ranges::count(kFreeForm, keyword) > 0) {
        const std::string name = "free-form curves and surfaces";
        if (std::ranges::count(surface.otherShapes, name) == 0) surface.otherShapes.push_back(name);
        return;
    }
    for (const auto& [known, kind] : kKinds)
        if (known == keyword) return surface.addOther(kind);
    surface.addOther("statements", std::string(keyword));
}

/// Returns the words of a statement as one name, which may have spaces.
std::string nameIn(ObjWords& words) {
    std::string name(words.next());
    for (auto word = words.next(); !word.empty(); word = words.next()) name += concat(" ", word);
    return name;
}

/// Reads the surface of an OBJ, statement by statement.
class SurfaceReader {
public:
    explicit SurfaceReader(const FileView& file) : file_(file) {}

    ModelSurface read() {
        forEachObjStatement(file_.path, file_.bytes, [&](ObjWords& words, std::size_t line) {
            const std::string_view keyword = words.next();
            if (keyword == "v") {
                ++before_.points;
                addColor(words);
            } else if (keyword == "vn") {
                ++before_.normals;
                surface_.normals.push_back(readObjNormal(words));
            } else if (keyword == "vt") {
                addTexture(words);
            } else if (keyword == "f" || keyword == "fo") {
                addFace(words, line);
            } else if (keyword == "usemtl") {
                useMaterial(nameIn(words));
            } else if (!keyword.empty()) {
                nameOtherData(keyword, surface_);
            }
        });
        finish();
        return std::move(surface_);
    }

private:
    /// A coordinate that is missing is 0. Texture coordinates that are not finite count as none.
    void addTexture(ObjWords& words) {
        std::array<double, 2> texture = {};
        for (double& number : texture)
            if (const std::string_view word = words.next(); !word.empty())
                number = parseReal(word, Precision::Double);
        haveTextures_ = haveTextures_ && std::isfinite(texture[0]) && std::isfinite(texture[1]);
        surface_.textures.push_back(texture);
    }

    /// Three numbers after the coordinates are a colour; one is a weight.
    void addColor(ObjWords& words) {
        std::array<float, 4> color = {0, 0, 0, 1};
        for (std::size_t axis = 0; axis < 3; ++axis) words.next();
        std::size_t count = 0;
        for (std::string_view word = words.next(); !word.empty(); word = words.next(), ++count)
            if (count < 3) color[count] = static_cast<float>(parseReal(word, Precision::Float));
        haveExtras_ = haveExtras_ || count > 0;
        const bool isColor = std::ranges::all_of(color, [](float c) { return c >= 0 && c <= 1; });
        if (count == 3 && isColor) surface_.colors.push_back(color);
    }

    void addFace(ObjWords& words, std::size_t line) {
        const std::size_t pointCount = file_.numbers.points.values.size();
        for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
            const auto point =
                referenceOf(word.substr(0, word.find('/')), before_.points, pointCount);
            if (!point)
                throw FileError(file_.path, line,
                                concat("a face has the corner ", inQuotes(word),
                                       ", which names no point; there are ", before_.points,
                                       " before it and ", pointCount, " in the file"));
            surface_.faces.corners.push_back(static_cast<Index>(point->index));
            const auto corner = cornerOf(word);
            addCorner(corner ? corner->normal : "", before_.normals, surface_.normalCorners);
            const std::size_t slash = word.find('/');
            const std::string_view texture =
                slash == std::string_view::npos ? "" : word.substr(slash + 1);
            addCorner(texture.substr(0, texture.find('/')), surface_.textures.size(),
                      surface_.textureCorners);
        }
        surface_.faces.endFace();
        surface_.faceMaterials.push_back(material_);
    }

    /// Adds the number of a normal or of texture coordinates; -1 if the corner names none.
    static void addCorner(std::string_view word, std::size_t before, std::vector<Index>& corners) {
        const auto reference = referenceOf(word, before, kMaxIndex);
        corners.push_back(reference ? static_cast<Index>(reference->index) : -1);
    }

    void useMaterial(const std::string& name) {
        const auto [found, isNew] =
            materials_.try_emplace(name, static_cast<Index>(surface_.materials.size()));
        if (isNew) surface_.materials.push_back(name);
        material_ = found->second;
    }

    /// Drops normals and texture coordinates unless each corner has one. A corner may name one that
    /// follows it, so the numbers are checked at the end.
    template <class Value>
    void dropUnlessComplete(const char* name, std::vector<Value>& values,
                            std::vector<Index>& corners) {
        const bool isComplete = !corners.empty() && std::ranges::all_of(corners, [&](Index corner) {
            return 0 <= corner && corner < std::ssize(values);
        });
        if (isComplete) return;
        if (!values.empty())
            surface_.addOther(concat(name, surface_.faces.count() == 0
                                               ? " (the model has no faces)"
                                               : " (some corners have none)"));
        values.clear();
        corners.clear();
    }

    /// Gives corners without texture coordinates the pair 0 0, if others have some.
    void completeTextures() {
        const Index count = static_cast<Index>(surface_.textures.size());
        const auto isKnown = [&](Index corner) { return 0 <= corner && corner < count; };
        std::vector<Index>& corners = surface_.textureCorners;
        const auto known = std::ranges::count_if(corners, isKnown);
        if (known == 0 || known == std::ssize(corners)) return;
        surface_.textures.push_back({0, 0});
        for (Index& corner : corners)
            if (!isKnown(corner)) corner = count;
    }

    void finish() {
        dropUnlessComplete("normals", surface_.normals, surface_.normalCorners);
        if (haveTextures_)
            completeTextures();
        else
            surface_.textureCorners.clear();
        dropUnlessComplete("texture coordinates", surface_.textures, surface_.textureCorners);
        if (surface_.materials.empty()) surface_.faceMaterials.clear();
        if (surface_.colors.size() == before_.points) return;
        surface_.colors.clear();
        if (haveExtras_) surface_.addOther("weights or colours of points");
    }

    const FileView& file_;
    ModelSurface surface_;
    CountsBefore before_;
    std::unordered_map<std::string, Index> materials_;
    Index material_ = -1;
    bool haveTextures_ = true;  ///< all texture coordinates are finite
    bool haveExtras_ = false;   ///< some points have numbers beside their coordinates
};

ModelSurface readObjSurface(const FileView& file) {
    return SurfaceReader(file).read();
}

void writeObj(std::ostream& out, const FileView& file, std::span<const Point3> moved,
              std::span<const DeformationGradient> gradients) {
    if (gradients.empty() || file.numbers.ownNormals == 0)
        writeNumbers(out, file, moved, {});
    else
        writeObjNormals(out, file, moved, gradients);
}

/// Reads a colour channel of all points; nothing unless each point has three numbers after its
/// coordinates.
std::vector<double> readObjChannel(const FileView& file, std::size_t channel) {
    std::vector<double> values;
    bool haveColors = true;
    forEachObjStatement(file.path, file.bytes, [&](ObjWords& words, std::size_t) {
        if (!haveColors || words.next() != "v") return;
        for (std::size_t axis = 0; axis < 3; ++axis) words.next();
        std::array<std::string_view, 3> color;
        for (std::string_view& word : color) word = words.next();
        haveColors = !color[2].empty() && words.next().empty();
        values.push_back(parseReal(color[channel], Precision::Double));
    });
    if (!haveColors) values.clear();
    return values;
}

std::vector<PointAttribute> objAttributes(const FileView& file) {
    constexpr const char* kNames[] = {"red", "green", "blue"};
    std::vector<PointAttribute> attributes;
    if (readObjChannel(file, 0).empty()) return attributes;
    for (std::size_t channel = 0; channel < 3; ++channel)
        attributes.push_back(
            {kNames[channel], [file, channel] { return readObjChannel(file, channel); }});
    return attributes;
}

/// Calls onNames(names) for each statement that begins a group, an object or a material, and
/// onElement(words, countOfPoints) for each face, line and point element.
template <class OnNames, class OnElement>
void walkObjGroups(const FileView& file, OnNames onNames, OnElement onElement) {
    std::size_t pointsBefore = 0;
    std::array<std::vector<std::string>, 3> names;  // of the groups, the object, the material
    forEachObjStatement(file.path, file.bytes, [&](ObjWords& words, std::size_t) {
        const std::string_view keyword = words.next();
        if (keyword == "v") {
            ++pointsBefore;
        } else if (keyword == "g") {
            names[0].clear();
            for (auto word = words.next(); !word.empty(); word = words.next())
                names[0].emplace_back(word);
            onNames(names);
        } else if (keyword == "o") {
            names[1] = {nameIn(words)};
            onNames(names);
        } else if (keyword == "usemtl") {
            names[2] = {nameIn(words)};
            onNames(names);
        } else if (keyword == "f" || keyword == "fo" || keyword == "l" || keyword == "p") {
            onElement(words, pointsBefore);
        }
    });
}

/// Reads the points of the faces, lines and point elements of a group, an object or a material.
std::vector<Index> readObjGroup(const FileView& file, const std::string& name) {
    const std::size_t pointCount = file.numbers.points.values.size();
    std::vector<bool> isIn(pointCount);
    bool isCurrent = false;
    walkObjGroups(
        file,
        [&](const auto& names) {
            isCurrent = std::ranges::any_of(
                names, [&](const auto& list) { return std::ranges::count(list, name) > 0; });
        },
        [&](ObjWords& words, std::size_t before) {
            if (!isCurrent) return;
            for (auto word = words.next(); !word.empty(); word = words.next())
                if (const auto point =
                        referenceOf(word.substr(0, word.find('/')), before, pointCount))
                    isIn[point->index] = true;
        });
    return pointsIn(isIn);
}

/// Returns the groups, objects and materials that have elements.
std::vector<PointGroup> objGroups(const FileView& file) {
    GroupNames groups([file](const std::string& name) {
        return [file, name] { return readObjGroup(file, name); };
    });
    std::array<std::vector<std::string>, 3> current;
    bool areNew = false;
    walkObjGroups(
        file,
        [&](const auto& names) {
            current = names;
            areNew = true;
        },
        [&](ObjWords&, std::size_t) {
            if (!std::exchange(areNew, false)) return;
            for (const auto& list : current)
                for (const std::string& name : list) groups.add(name);
        });
    return groups.take();
}

constexpr FileModelFormat kObjModel = {.readNumbers = readObjNumbers,
                                       .readSurface = readObjSurface,
                                       .attributes = objAttributes,
                                       .groups = objGroups,
                                       .write = writeObj};

}  // namespace

const Format kObjFormat = {.extensions = {".obj"},
                           .readModel = readFileModel<kObjModel>,
                           .writeSurface = writeObjSurface,
                           .normals = Format::Normals::Corners,
                           .readMesh = readObjMesh,
                           .writeMesh = [](const std::filesystem::path& path,
                                           const Lattice& mesh) { writeObjMesh(path, mesh); },
                           .isEditorMesh = true};

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/array.h>
#include <espalier/base/cancellable_sort.h>
#include <espalier/base/memory.h>
#include <espalier/base/vector3.h>
#include <espalier/io/directions.h>
#include <espalier/io/files/file.h>
#include <espalier/io/models/obj_mesh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <numeric>
#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "../files/text_output.h"
#include "file_model.h"
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
// A `vn` has no point of its own. It is used at corners of `f`, `fo` and `surf`, and the gradients
// of the points at these corners carry it. The result is rounded to nine digits after the decimal
// point for a unit normal; a component that does not change at this precision keeps its text.
//
// - If all corners of a normal agree on the result, the normal is rewritten in place. A normal
//   without corners stays.
// - If they differ, the result at the first corner replaces the normal under its number, and each
//   other result gets a new `vn`. The new line follows the last `vn` before the corner that first
//   needs it, because many readers fail if a corner precedes its normal. (If the corner already
//   precedes its own `vn` in the old file, the new line follows that `vn`.)
// - A corner whose number no longer names the right normal is rewritten; a number that counts back
//   still counts back. If all normals precede the faces, the rewritten corners are those that need
//   a new normal, and all corners whose numbers count back.
// - A corner that names no normal of the file stays. A corner that names a normal but no point of
//   the file keeps its normal, and does not count as a corner of this normal above.
//
// The faces are the statements `f` and `fo`.
//
// The text and 48 bytes per point are kept. Writing takes one pass. With gradients it takes three,
// and temporarily 8 bytes per corner and about 80 per `vn`: corners of several points may share one
// `vn`, and the gradients at these points may carry it to different normals. These are the versions
// of the normal: the first version replaces the old `vn`, each other version gets a new line. A new
// line shifts the numbers of later normals, and the numbers that count back across it. A corner is
// rewritten only if its number no longer names its version.
//
//     normals_    the `vn` of the file, in its order, with the first version of each
//     additions_  the other versions, in the order of their first use
//     targets_    the version at each corner with a normal, in the order of the file: n for the
//                 first version of normal n, and the number of normals + a for addition a
//
// New lines follow the last `vn` before the corner that first needs them, because some readers
// resolve a corner as soon as they see it. In a file whose normals precede its faces, the old
// normals keep their numbers.

namespace espalier::io {

namespace {

/// Digits after the decimal point of a unit normal: finer than floats. With all digits of a double,
/// corners whose gradients differ only by rounding, as in a rigid motion, could no longer share a
/// normal.
constexpr int kDecimals = 9;

/// Returns the power of ten by which a vector of this length is multiplied before its components
/// are rounded to integers; infinite if the length is 0 or too small.
double decimalScale(double length) {
    return std::pow(10.0, kDecimals - std::floor(std::log10(length)));
}

Point3 rounded(Point3 direction, double scale) {
    if (!std::isfinite(scale)) return direction;
    // Adding 0 turns −0 into +0.
    for (double& component : direction) component = std::round(component * scale) / scale + 0.0;
    return direction;
}

/// A number in a corner, and the point or normal that it names.
struct Reference {
    std::int64_t number;  ///< the number in the file; negative numbers count back
    std::size_t index;    ///< number of the point or normal, from 0
};

/// Resolves a number in a corner.
/// \param before number of points (or normals) before the statement
/// \param total number of points (or normals) in the file
/// \return nothing if the word is no number, or names no point (or normal) of the file
std::optional<Reference> referenceOf(std::string_view word, std::size_t before, std::size_t total) {
    std::int64_t number = 0;
    if (!parseNumber(word, number)) return std::nullopt;
    const std::int64_t index = number < 0 ? static_cast<std::int64_t>(before) + number : number - 1;
    if (index < 0 || index >= static_cast<std::int64_t>(total)) return std::nullopt;
    return Reference{number, static_cast<std::size_t>(index)};
}

/// The numbers of a corner that names a normal.
struct Corner {
    std::string_view point;
    std::string_view normal;
};

/// Splits a corner such as "1//3" or "1/2/3". Returns nothing if it names no normal.
std::optional<Corner> cornerOf(std::string_view word) {
    const std::size_t first = word.find('/');
    if (first == std::string_view::npos) return std::nullopt;
    const std::size_t second = word.find('/', first + 1);
    if (second == std::string_view::npos) return std::nullopt;
    return Corner{word.substr(0, first), word.substr(second + 1)};
}

/// The numbers of points and normals that precede a statement.
struct CountsBefore {
    std::size_t points = 0;
    std::size_t normals = 0;
};

/// Calls onPoint(counts), onNormal(words, counts) and onCorner(corner, counts) for each `v`, `vn`
/// and corner with a normal, in the order of the file.
template <class OnPoint, class OnNormal, class OnCorner>
void walk(const std::filesystem::path& path, std::string_view text, OnPoint onPoint,
          OnNormal onNormal, OnCorner onCorner) {
    CountsBefore counts;
    forEachObjStatement(path, text, [&](ObjWords& words, std::size_t) {
        const std::string_view keyword = words.next();
        if (keyword == "v") {
            onPoint(counts);
            ++counts.points;
        } else if (keyword == "vn") {
            onNormal(words, counts);
            ++counts.normals;
        } else if (keyword == "f" || keyword == "fo" || keyword == "surf") {
            for (std::string_view word = words.next(); !word.empty(); word = words.next())
                if (const auto corner = cornerOf(word)) onCorner(*corner, counts);
        }
    });
}

constexpr auto kPassOver = [](auto&&...) {};

/// Reads the words after a `vn`. A word that is no number is NaN.
Point3 readObjNormal(ObjWords& words) {
    Point3 normal{};
    for (double& component : normal) component = parseReal(words.next(), Precision::Double);
    return normal;
}

struct Normal {
    Point3 value;
    double scale;                   ///< decimalScale(), by which its versions are rounded
    std::optional<Point3> carried;  ///< its first version
};

/// A version of a normal: the result of carrying it by the gradient of a point.
struct Version {
    std::size_t normal;
    Point3 value;
    bool operator==(const Version&) const = default;
};

struct VersionHash {
    std::size_t operator()(const Version& version) const {
        std::size_t hash = version.normal;
        for (const double number : version.value)
            hash = hash * 1000003 + std::hash<double>()(number);
        return hash;
    }
};

/// A version that gets a new line.
struct Addition {
    Point3 value;
    std::size_t anchor;    ///< the normal whose line it follows
    std::size_t rank = 0;  ///< its number in the order of the new file
};

class NormalWriter {
public:
    NormalWriter(const std::filesystem::path& path, std::string_view text,
                 std::span<const DeformationGradient> gradients)
        : path_(path), text_(text), gradients_(gradients) {
        walk(
            path_, text_, kPassOver,
            [&](ObjWords& words, const CountsBefore&) { normals_.push_back(readNormal(words)); },
            kPassOver);
        walk(path_, text_, kPassOver, kPassOver,
             [&](const Corner& corner, const CountsBefore& before) {
                 if (const auto normal = normalOf(corner, before))
                     targets_.push_back(targetOf(corner, normal->index, before));
             });
        orderAdditions();
    }

    void write(std::ostream& out, const VectorChange& points) const {
        TextChanges moves(text_, {&points, 1});
        TextPatch patch(out, text_);
        std::size_t corners = 0;
        walk(
            path_, text_,
            [&](const CountsBefore& before) {
                moves.applyUpTo(patch, points.offsets[before.points][2] + 1);
            },
            [&](ObjWords& words, const CountsBefore& before) {
                replaceNormal(patch, words, normals_[before.normals]);
                insertAdditions(patch, words.end(), before.normals);
            },
            [&](const Corner& corner, const CountsBefore& before) {
                const auto normal = normalOf(corner, before);
                if (!normal) return;
                const std::int64_t number = numberFor(targets_[corners++], *normal, before);
                if (number != normal->number) patch.replace(corner.normal, number);
            });
        patch.finish();
    }

private:
    static Normal readNormal(ObjWords& words) {
        Normal normal{};
        normal.value = readObjNormal(words);
        normal.scale = decimalScale(length(normal.value));
        return normal;
    }

    std::optional<Reference> normalOf(const Corner& corner, const CountsBefore& before) const {
        return referenceOf(corner.normal, before.normals, normals_.size());
    }

    std::size_t targetOf(const Corner& corner, std::size_t index, const CountsBefore& before) {
        Normal& normal = normals_[index];
        const auto point = referenceOf(corner.point, before.points, gradients_.size());
        if (!point || !isDirection(normal.value, Precision::Double)) return index;
        const Point3 carried =
            rounded(carryNormal(gradients_[point->index], normal.value), normal.scale);
        if (!normal.carried) normal.carried = carried;
        if (*normal.carried == carried) return index;
        const std::size_t next = normals_.size() + additions_.size();
        const auto [at, isNew] = added_.try_emplace({index, carried}, next);
        // If a corner precedes its normal, the new line follows the normal.
        if (isNew) additions_.push_back({carried, std::max(index + 1, before.normals) - 1});
        return at->second;
    }

    void orderAdditions() {
        order_.resize(additions_.size());
        std::iota(order_.begin(), order_.end(), std::size_t{0});
        stableSortCancellably(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) {
            return additions_[a].anchor < additions_[b].anchor;
        });
        additionsBefore_.assign(normals_.size() + 1, 0);
        for (std::size_t rank = 0; rank < order_.size(); ++rank) {
            Addition& addition = additions_[order_[rank]];
            addition.rank = rank;
            ++additionsBefore_[addition.anchor + 1];
        }
        std::partial_sum(additionsBefore_.begin(), additionsBefore_.end(),
                         additionsBefore_.begin());
    }

    /// Returns the number by which a corner names its version in the new file. It counts back if
    /// the old number did.
    std::int64_t numberFor(std::size_t target, const Reference& old,
                           const CountsBefore& before) const {
        std::size_t index = 0;
        if (target < normals_.size()) {
            index = target + additionsBefore_[target];
        } else {
            const Addition& addition = additions_[target - normals_.size()];
            index = addition.anchor + 1 + addition.rank;
        }
        const std::size_t nowBefore = before.normals + additionsBefore_[before.normals];
        return static_cast<std::int64_t>(index) -
               (old.number < 0 ? static_cast<std::int64_t>(nowBefore) : -1);
    }

    static void replaceNormal(TextPatch& patch, ObjWords& words, const Normal& normal) {
        if (!normal.carried) return;
        const Point3 before = rounded(normal.value, normal.scale);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::string_view word = words.next();
            if ((*normal.carried)[axis] != before[axis])
                patch.replace(word, (*normal.carried)[axis]);
        }
    }

    /// \param end end of the statement, without its line end
    void insertAdditions(TextPatch& patch, const char* end, std::size_t anchor) const {
        const std::size_t first = additionsBefore_[anchor];
        const std::size_t last = additionsBefore_[anchor + 1];
        if (first == last) return;
        const std::size_t offset = end - text_.data();
        const std::string_view lineEnd = text_.substr(offset).starts_with("\r\n") ? "\r\n" : "\n";
        const auto add = [&](std::string_view text) { patch.insert(offset, text); };
        // If the file ends in a backslash, it must not continue the statement with the new line.
        if (text_[offset - 1] == '\\') add(lineEnd);
        for (std::size_t i = first; i < last; ++i) {
            add(lineEnd);
            add("vn");
            for (const double component : additions_[order_[i]].value) {
                add(" ");
                add(formatNumber(component));
            }
        }
    }

    const std::filesystem::path& path_;
    std::string_view text_;
    std::span<const DeformationGradient> gradients_;
    std::vector<Normal> normals_;
    std::vector<Addition> additions_;
    std::unordered_map<Version, std::size_t, VersionHash> added_;  ///< target of each addition
    std::vector<std::size_t> targets_;
    std::vector<std::size_t> order_;            ///< the additions in the order of the new file
    std::vector<std::size_t> additionsBefore_;  ///< number before each normal; the total at the end
};

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

    void finish() {
        dropUnlessComplete("normals", surface_.normals, surface_.normalCorners);
        if (!haveTextures_) surface_.textureCorners.clear();
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
        NormalWriter(file.path, file.bytes, gradients)
            .write(out, file.numbers.points.changeTo(moved));
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

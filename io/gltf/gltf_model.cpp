// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/io/model.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "../format.h"
#include "../models/coordinates.h"
#include "../models/point_data.h"
#include "gltf_accessor.h"
#include "gltf_file.h"
#include "gltf_vectors.h"
#include "gltf_writer.h"

// glTF 2.0 (.gltf, .glb): the points of all meshes that nodes draw.
//
// A point is taken where it is drawn at rest: after the matrix of its node, or after the average of
// the matrices of its joints. A new position goes back through the inverse, as does a gradient. So
// a skinned mesh keeps its skeleton, and is deformed in its pose at rest. Where a matrix has no
// inverse, the points stay.
//
// NORMAL and TANGENT follow the gradients. The handedness of a tangent (its fourth number) stays:
// the normal n follows the cofactors of F and the tangent t follows F, so the bitangent w (n x t)
// follows F, also where F mirrors.
//
// A morph target is a set of points of its own, the points of the mesh plus its displacements, and
// so has its own rows in a lattice. The new displacements are its new points minus those of the
// mesh. Likewise its normals and tangents. The default weights of the targets are not applied.
//
// A mesh that several nodes draw at several places becomes several meshes, once points have moved.
// A mesh that no node draws stays.
//
// Accessors are replaced where they are, if they hold floats and nothing else has their bytes.
// Otherwise a new one is added, of floats. All else in the file stays.
//
// The faces are the triangles, strips and fans. Where a node mirrors, the faces are turned, as glTF
// asks. TEXCOORD_0, COLOR_0 and the materials are their appearance.

namespace espalier::io {
namespace {

/// Returns how often the JSON names each accessor.
std::vector<std::size_t> countReferences(const GltfFile& file) {
    std::vector<std::size_t> counts(file.list("accessors").size());
    const auto count = [&](const Json& index) {
        if (const auto number = wholeNumber(index); number && *number < counts.size())
            ++counts[*number];
    };
    const auto countAll = [&](const Json& object, const char* key) {
        const auto found = object.find(key);
        if (found != object.end() && found->is_structured())
            for (const Json& index : *found) count(index);
    };
    const auto countOne = [&](const Json& object, const char* key) {
        if (const auto found = object.find(key); found != object.end()) count(*found);
    };
    const auto forEach = [](const Json& object, const char* key, const auto& f) {
        const auto found = object.find(key);
        if (found != object.end() && found->is_array())
            for (const Json& item : *found) f(item);
    };
    for (const Json& mesh : file.list("meshes"))
        forEach(mesh, "primitives", [&](const Json& primitive) {
            countAll(primitive, "attributes");
            countOne(primitive, "indices");
            forEach(primitive, "targets", [&](const Json& target) {
                for (const Json& index : target) count(index);
            });
        });
    for (const Json& skin : file.list("skins")) countOne(skin, "inverseBindMatrices");
    for (const Json& animation : file.list("animations"))
        forEach(animation, "samplers", [&](const Json& sampler) {
            countOne(sampler, "input");
            countOne(sampler, "output");
        });
    return counts;
}

constexpr const char* kTextureSemantic = "TEXCOORD_0";
constexpr const char* kColorSemantic = "COLOR_0";

/// Returns the sRGB value from 0 to 1 that stands for an intensity of light (IEC 61966-2-1).
float screenValueOf(float intensity) {
    const double x = intensity;
    return static_cast<float>(x <= 0.0031308 ? x * 12.92 : 1.055 * std::pow(x, 1 / 2.4) - 0.055);
}

bool isSamePoint(const Point3& a, const Point3& b) {
    return std::equal(a.begin(), a.end(), b.begin(), isSame);
}

class GltfModel final : public Model {
public:
    GltfModel(const Format& format, const std::filesystem::path& path, std::string bytes)
        : Model(format, path), file_(path, std::move(bytes)), scene_(readGltfScene(file_)) {
        if (scene_.positions.empty()) file_.fail("no node draws a mesh with points");
    }

    std::span<const Point3> positions() const override { return scene_.positions; }

    DirectionCounts directions() const override {
        DirectionCounts counts;
        for (const GltfVectors& vectors : scene_.vectors)
            if (vectors.kind != GltfVectorKind::Points)
                (vectors.kind == GltfVectorKind::Normals ? counts.normals : counts.tangents) +=
                    vectors.local.size();
        return counts;
    }

    CoordinateStorage storage() const override { return CoordinateStorage::Float; }

    std::vector<Point3> stored(std::vector<Point3> points) const override {
        std::vector<std::vector<Point3>> local(scene_.vectors.size());
        for (std::size_t v = 0; v < scene_.vectors.size(); ++v) {
            const GltfVectors& vectors = scene_.vectors[v];
            if (vectors.kind != GltfVectorKind::Points) continue;
            const GltfBlock& block = scene_.blocks[vectors.block];
            local[v] = newPoints(vectors, points);
            for (std::size_t i = 0; i < block.count; ++i) {
                Point3& point = points[block.first + i];
                if (point == scene_.positions[block.first + i]) continue;
                const Point3 zero = vectors.base ? local[*vectors.base][i] : Point3{};
                Point3 written = difference(local[v][i], zero);
                for (double& coordinate : written) roundToFloat(coordinate);
                local[v][i] = sum(zero, written);
                point = block.map(i) * local[v][i];
            }
        }
        return points;
    }

    ModelSurface readSurface() const override {
        return withJsonErrors(file_.path(), [&] { return surface(); });
    }

    std::vector<PointAttribute> attributes() const override {
        return withJsonErrors(file_.path(), [&] {
            // Primitives may have numbers of another kind: the largest number of components counts.
            std::vector<std::pair<std::string, std::size_t>> all;
            forEachPrimitive([&](const Json& primitive, const auto&) {
                for (const auto& [name, index] : primitive["attributes"].items()) {
                    if (name == "POSITION" || name == "NORMAL" || name == "TANGENT" ||
                        name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_"))
                        continue;
                    const std::size_t components =
                        accessorOf(file_, file_.needNumber(primitive["attributes"], name.c_str()))
                            .components;
                    const auto known =
                        std::ranges::find(all, name, &std::pair<std::string, std::size_t>::first);
                    if (known == all.end())
                        all.emplace_back(name, components);
                    else
                        known->second = std::max(known->second, components);
                }
            });
            std::vector<PointAttribute> attributes;
            for (const auto& [name, components] : all)
                for (std::size_t component = 0; component < components; ++component)
                    attributes.push_back(
                        {nameOfComponent(name, component, components),
                         [this, name = name, component] { return attribute(name, component); }});
            return attributes;
        });
    }

    std::vector<PointGroup> groups() const override {
        return withJsonErrors(file_.path(), [&] {
            GroupNames groups(
                [this](const std::string& name) { return [this, name] { return group(name); }; });
            forEachPrimitiveName(
                [&](const std::string& name, const Json&, const auto&) { groups.add(name); });
            return groups.take();
        });
    }

    ModelFaces facesOfShapes(std::vector<Index>& shapes) const override {
        shapes.assign(scene_.positions.size(), 0);
        return withJsonErrors(file_.path(), [&] {
            ModelFaces faces;
            forEachPrimitive([&](const Json& primitive, const auto& blocks) {
                for (std::size_t shape = 0; shape < blocks.size(); ++shape) {
                    const GltfBlock& block = *blocks[shape];
                    addFaces(primitive, block, faces);
                    for (std::size_t i = 0; i < block.count; ++i)
                        shapes[block.first + i] = static_cast<Index>(shape);
                }
            });
            return faces;
        });
    }

    std::vector<std::string> notes() const override {
        std::vector<std::string> notes;
        const std::size_t meshCount = file_.list("meshes").size();
        std::vector<std::size_t> places(meshCount);
        for (const GltfDrawnMesh& drawn : scene_.meshes) ++places[drawn.drawing.mesh];
        const auto add = [&](std::size_t count, const char* one, const char* many) {
            if (count > 0) notes.push_back(concat(count, count == 1 ? one : many));
        };
        add(std::ranges::count(places, std::size_t{0}), " mesh stays, because no node draws it",
            " meshes stay, because no node draws them");
        add(std::ranges::count_if(places, [](std::size_t count) { return count > 1; }),
            " mesh is drawn at several places, and becomes a mesh for each once its points move",
            " meshes are drawn at several places, and become a mesh for each once their points "
            "move");
        std::size_t fixed = 0;
        for (const GltfBlock& block : scene_.blocks)
            for (std::size_t i = 0; i < block.count; ++i) {
                if (block.maps->size() == 1 && i > 0) break;
                if (!inverse(block.map(i).linear))
                    fixed += block.maps->size() > 1 ? 1 : block.count;
            }
        add(fixed, " point stays, because the matrix that draws it has no inverse",
            " points stay, because the matrices that draw them have no inverse");
        return notes;
    }

private:
    /// Calls f(primitive, blocks) for each primitive of a mesh that has points. The blocks are its
    /// points, and the points of its morph targets.
    template <class F>
    void forEachPrimitiveOf(const GltfDrawnMesh& drawn, F f) const {
        const Json& primitives = file_.item("meshes", drawn.drawing.mesh)["primitives"];
        for (std::size_t p = 0; p < primitives.size(); ++p) {
            std::vector<const GltfBlock*> blocks = {&scene_.blocks[drawn.blocks[p]]};
            if (blocks.front()->count == 0) continue;
            for (const GltfUse& use : drawn.uses)
                if (use.primitive == p && use.target &&
                    scene_.vectors[use.vectors].kind == GltfVectorKind::Points)
                    blocks.push_back(&scene_.blocks[scene_.vectors[use.vectors].block]);
            f(primitives[p], blocks);
        }
    }
    template <class F>
    void forEachPrimitive(F f) const {
        for (const GltfDrawnMesh& drawn : scene_.meshes) forEachPrimitiveOf(drawn, f);
    }

    /// Calls f(name, primitive, blocks) for each name of each primitive: of its mesh, of the nodes
    /// that draw it, and of its material.
    template <class F>
    void forEachPrimitiveName(F f) const {
        for (const GltfDrawnMesh& drawn : scene_.meshes) {
            std::vector<std::string> names = {
                GltfFile::text(file_.item("meshes", drawn.drawing.mesh), "name")};
            for (const std::size_t node : drawn.drawing.nodes)
                names.push_back(GltfFile::text(file_.item("nodes", node), "name"));
            forEachPrimitiveOf(drawn, [&](const Json& primitive, const auto& blocks) {
                for (const std::string& name : names) f(name, primitive, blocks);
                if (const auto material = file_.number(primitive, "material"))
                    f(GltfFile::text(file_.item("materials", *material), "name"), primitive,
                      blocks);
            });
        }
    }

    /// Returns the corners of a primitive.
    std::vector<Index> cornersOf(const Json& primitive, const GltfBlock& block) const {
        if (const auto indices = file_.number(primitive, "indices"))
            return indicesOf(file_, *indices, block.count);
        std::vector<Index> corners(block.count);
        std::iota(corners.begin(), corners.end(), Index{0});
        return corners;
    }

    /// Returns the number of the material of a primitive, or -1.
    Index materialOf(const Json& primitive) const {
        const auto material = file_.number(primitive, "material");
        if (!material) return -1;
        file_.item("materials", *material);
        return static_cast<Index>(*material);
    }

    /// Adds the triangles of a primitive as if its points were those of a block.
    void addFaces(const Json& primitive, const GltfBlock& block, ModelFaces& faces) const;

    /// Reads the points of the primitives with a name.
    std::vector<Index> group(const std::string& wanted) const {
        return withJsonErrors(file_.path(), [&] {
            std::vector<bool> isIn(scene_.positions.size());
            forEachPrimitiveName(
                [&](const std::string& name, const Json& primitive, const auto& blocks) {
                    checkCancelled();
                    if (name != wanted) return;
                    for (const Index corner : cornersOf(primitive, *blocks.front()))
                        for (const GltfBlock* block : blocks) isIn[block->first + corner] = true;
                });
            return pointsIn(isIn);
        });
    }

    /// Reads a component of an attribute: 0 where a primitive lacks the attribute, and where it
    /// lacks the component, except that the alpha of a colour is then 1. Where primitives share
    /// points, the largest number counts.
    std::vector<double> attribute(const std::string& name, std::size_t component) const {
        constexpr std::size_t kAlpha = 3;
        const double missing = name.starts_with("COLOR_") && component == kAlpha ? 1 : 0;
        return withJsonErrors(file_.path(), [&] {
            std::vector<double> values(scene_.positions.size());
            std::vector<bool> isKnown(values.size());
            std::set<std::pair<std::size_t, const GltfBlock*>> done;
            forEachPrimitive([&](const Json& primitive, const auto& blocks) {
                const auto index = file_.number(primitive["attributes"], name.c_str());
                if (!index || !done.emplace(*index, blocks.front()).second) return;
                checkCancelled();
                const std::size_t components = accessorOf(file_, *index).components;
                const std::vector<double> numbers = numbersOf(file_, *index);
                for (const GltfBlock* block : blocks) {
                    if (numbers.size() != components * block->count)
                        file_.fail(concat("accessor ", *index, " has ", numbers.size(), " numbers ",
                                          inQuotes(name), "; expected ", components,
                                          " for each of ", block->count, " points"));
                    for (std::size_t i = 0; i < block->count; ++i) {
                        const double number =
                            component < components ? numbers[components * i + component] : missing;
                        double& value = values[block->first + i];
                        // A number that is not a number stays, to be refused.
                        if (!isKnown[block->first + i] || !(number <= value)) value = number;
                        isKnown[block->first + i] = true;
                    }
                }
            });
            return values;
        });
    }

    /// Returns new points in the mesh. A point that has not moved keeps its numbers.
    std::vector<Point3> newPoints(const GltfVectors& vectors, std::span<const Point3> moved) const {
        const GltfBlock& block = scene_.blocks[vectors.block];
        std::vector<Point3> points = vectors.local;
        std::optional<DeformationGradient> back;
        const Affine* backOf = nullptr;
        for (std::size_t i = 0; i < block.count; ++i) {
            checkCancelledEvery(i, 12);
            const Point3 move =
                difference(moved[block.first + i], scene_.positions[block.first + i]);
            if (move == Point3{}) continue;
            const Affine& map = block.map(i);
            if (map == Affine{}) {
                points[i] = moved[block.first + i];
                continue;
            }
            if (backOf != &map) {
                back = inverse(map.linear);
                backOf = &map;
            }
            if (back) points[i] = sum(points[i], *back * move);
        }
        return points;
    }

    /// Returns new directions in the mesh.
    std::vector<Point3> newDirections(const GltfVectors& vectors,
                                      std::span<const DeformationGradient> gradients) const {
        const GltfBlock& block = scene_.blocks[vectors.block];
        gradients = gradients.subspan(block.first, block.count);
        std::vector<DeformationGradient> local;
        if (block.maps->size() > 1 || block.map(0) != Affine{}) {
            local.assign(gradients.begin(), gradients.end());
            for (std::size_t i = 0; i < local.size(); ++i) {
                checkCancelledEvery(i, 12);
                if (local[i] == kIdentity) continue;
                const DeformationGradient& linear = block.map(i).linear;
                const auto back = inverse(linear);
                local[i] = back ? *back * (local[i] * linear) : kIdentity;
            }
            gradients = local;
        }
        return carried(vectors.local, gradients,
                       vectors.kind == GltfVectorKind::Normals ? carryNormal : carryTangent,
                       Precision::Float);
    }

    void writeChecked(const std::filesystem::path& path, std::span<const Point3> moved,
                      std::span<const DeformationGradient> gradients) const override {
        withJsonErrors(file_.path(), [&] { writeFile(path, moved, gradients); });
    }

    ModelSurface surface() const;
    void addTextures(const Json& primitive, const GltfBlock& block, std::span<const Index> corners,
                     ModelSurface& surface) const;
    void addColors(const Json& primitive, const GltfBlock& block, ModelSurface& surface) const;
    void writeFile(const std::filesystem::path& path, std::span<const Point3> moved,
                   std::span<const DeformationGradient> gradients) const;

    GltfFile file_;
    GltfScene scene_;
};

/// Calls f with the corners of each triangle of a primitive.
/// \param mode of glTF: 4 for triangles, 5 for strips, 6 for fans
template <class F>
void forEachTriangle(std::size_t mode, std::span<const Index> corners, F f) {
    if (mode == 4)
        for (std::size_t i = 0; i + 2 < corners.size(); i += 3)
            f(corners[i], corners[i + 1], corners[i + 2]);
    if (mode == 5)
        for (std::size_t i = 0; i + 2 < corners.size(); ++i)
            f(corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]);
    if (mode == 6)
        for (std::size_t i = 1; i + 1 < corners.size(); ++i)
            f(corners[i], corners[i + 1], corners[0]);
}

void GltfModel::addFaces(const Json& primitive, const GltfBlock& block, ModelFaces& faces) const {
    const std::size_t mode = file_.number(primitive, "mode").value_or(4);
    if (mode < 4 || mode > 6) return;
    forEachTriangle(mode, cornersOf(primitive, block), [&](Index a, Index b, Index c) {
        for (const Index corner : {a, b, c})
            faces.corners.push_back(static_cast<Index>(block.first) + corner);
        faces.endFace();
    });
}

/// Adds the texture coordinates of the corners of a primitive; 0 0 if it has none.
void GltfModel::addTextures(const Json& primitive, const GltfBlock& block,
                            std::span<const Index> corners, ModelSurface& surface) const {
    const std::size_t first = surface.textures.size();
    const auto accessor = file_.number(primitive["attributes"], kTextureSemantic);
    if (accessor) {
        const std::vector<double> numbers = numbersOf(file_, *accessor);
        if (numbers.size() != 2 * block.count)
            file_.fail(concat("accessor ", *accessor, " has ", numbers.size(),
                              " texture coordinates; expected 2 for each of ", block.count,
                              " points"));
        for (std::size_t i = 0; i < block.count; ++i)
            surface.textures.push_back({numbers[2 * i], 1 - numbers[2 * i + 1]});
    } else {
        surface.textures.push_back({0, 0});
    }
    for (const Index corner : corners)
        surface.textureCorners.push_back(static_cast<Index>(first) + (accessor ? corner : 0));
}

/// Sets the colours of the points of a primitive. glTF has intensities of light.
void GltfModel::addColors(const Json& primitive, const GltfBlock& block,
                          ModelSurface& surface) const {
    const auto accessor = file_.number(primitive["attributes"], kColorSemantic);
    if (!accessor) return;
    const std::size_t components = accessorOf(file_, *accessor).components;
    const std::vector<double> numbers = numbersOf(file_, *accessor);
    if ((components != 3 && components != 4) || numbers.size() != components * block.count)
        file_.fail(concat("accessor ", *accessor, " has no colours of ", block.count, " points"));
    if (surface.colors.empty()) surface.colors.assign(scene_.positions.size(), {1, 1, 1, 1});
    for (std::size_t i = 0; i < block.count; ++i) {
        auto& color = surface.colors[block.first + i];
        for (std::size_t c = 0; c < components; ++c) {
            const auto number = static_cast<float>(numbers[components * i + c]);
            const float known = number >= 0 ? std::min(number, 1.0F) : 0;
            color[c] = c < 3 ? screenValueOf(known) : known;
        }
    }
}

ModelSurface GltfModel::surface() const {
    ModelSurface surface;
    bool haveNormals = true, haveTextures = false;
    std::vector<std::optional<std::size_t>> firstNormals(scene_.vectors.size());
    for (const GltfDrawnMesh& drawn : scene_.meshes) {
        const Json& primitives = file_.item("meshes", drawn.drawing.mesh)["primitives"];
        for (std::size_t p = 0; p < primitives.size(); ++p) {
            const GltfBlock& block = scene_.blocks[drawn.blocks[p]];
            if (block.count == 0) continue;
            const Json& primitive = primitives[p];
            const std::size_t mode = file_.number(primitive, "mode").value_or(4);
            if (mode >= 1 && mode <= 3) surface.addOther("lines");
            for (const auto& [name, accessor] : primitive["attributes"].items())
                if (name != "POSITION" && name != "NORMAL" && name != kTextureSemantic &&
                    name != kColorSemantic)
                    surface.addOther("attributes", name);
            if (primitive.contains("targets")) {
                surface.addOther("morph targets");
                surface.dropsLoosePoints = true;
            }
            if (mode < 4 || mode > 6) continue;
            const std::vector<Index> corners = cornersOf(primitive, block);
            const std::size_t firstCorner = surface.faces.corners.size();
            const bool isMirrored = determinant(block.map(0).linear) < 0;
            const auto normals = drawn.normals[p];
            haveNormals = haveNormals && normals.has_value();
            if (normals && !firstNormals[*normals]) {
                firstNormals[*normals] = surface.normals.size();
                for (std::size_t i = 0; i < block.count; ++i)
                    surface.normals.push_back(
                        carryNormal(block.map(i).linear, scene_.vectors[*normals].local[i]));
            }
            forEachTriangle(mode, corners, [&](Index a, Index b, Index c) {
                if (isMirrored) std::swap(b, c);
                for (const Index corner : {a, b, c}) {
                    surface.faces.corners.push_back(static_cast<Index>(block.first) + corner);
                    if (haveNormals)
                        surface.normalCorners.push_back(
                            static_cast<Index>(*firstNormals[*normals]) + corner);
                }
                surface.faces.endFace();
            });
            std::vector<Index> inBlock;
            for (std::size_t i = firstCorner; i < surface.faces.corners.size(); ++i)
                inBlock.push_back(surface.faces.corners[i] - static_cast<Index>(block.first));
            addTextures(primitive, block, inBlock, surface);
            haveTextures = haveTextures || primitive["attributes"].contains(kTextureSemantic);
            addColors(primitive, block, surface);
            surface.faceMaterials.resize(surface.faces.count(), materialOf(primitive));
        }
    }
    if (!haveTextures) {
        surface.textures.clear();
        surface.textureCorners.clear();
    }
    for (const Json& material : file_.list("materials"))
        surface.materials.push_back(GltfFile::text(material, "name"));
    if (std::ranges::all_of(surface.faceMaterials, [](Index material) { return material < 0; }))
        surface.faceMaterials.clear();
    if (surface.faceMaterials.empty()) surface.materials.clear();
    if (!haveNormals) {
        surface.normals.clear();
        surface.normalCorners.clear();
        if (directions().normals > 0) surface.addOther("normals of some meshes");
    }
    std::vector<bool> isDrawn(file_.list("meshes").size());
    for (const GltfDrawnMesh& drawn : scene_.meshes) isDrawn[drawn.drawing.mesh] = true;
    if (std::ranges::count(isDrawn, false) > 0) surface.addOther("meshes that no node draws");
    if (const auto used = file_.json().find("extensionsUsed");
        used != file_.json().end() && used->is_array())
        for (const Json& name : *used)
            if (name.is_string()) surface.addOther("extensions", name.get<std::string>());
    for (const char* list : {"materials", "textures", "skins", "animations", "cameras"})
        if (!file_.list(list).empty()) surface.addOther(list);
    return surface;
}

void GltfModel::writeFile(const std::filesystem::path& path, std::span<const Point3> moved,
                          std::span<const DeformationGradient> gradients) const {
    // New vectors in the meshes; empty if none of them has changed.
    std::vector<std::vector<Point3>> now(scene_.vectors.size());
    std::vector<bool> isChanged(now.size());
    for (std::size_t v = 0; v < now.size(); ++v) {
        const GltfVectors& vectors = scene_.vectors[v];
        if (vectors.kind == GltfVectorKind::Points)
            now[v] = newPoints(vectors, moved);
        else if (!gradients.empty())
            now[v] = newDirections(vectors, gradients);
        else
            now[v] = vectors.local;
        isChanged[v] =
            !std::equal(now[v].begin(), now[v].end(), vectors.local.begin(), isSamePoint) ||
            (vectors.base && isChanged[*vectors.base]);
    }
    GltfEdit edit(file_);
    if (std::ranges::count(isChanged, true) == 0) return edit.write(path);

    // The numbers that the file gets.
    const auto numbersFor = [&](std::size_t v) {
        const GltfVectors& vectors = scene_.vectors[v];
        std::vector<Point3> numbers = std::move(now[v]);
        if (vectors.base) {
            const std::vector<Point3>& zero = now[*vectors.base];
            const std::vector<Point3>& zeroBefore = scene_.vectors[*vectors.base].local;
            for (std::size_t i = 0; i < numbers.size(); ++i)
                numbers[i] =
                    isSamePoint(numbers[i], vectors.local[i]) && isSamePoint(zero[i], zeroBefore[i])
                        ? vectors.displacements[i]
                        : difference(numbers[i], zero[i]);
        }
        const std::size_t first = scene_.blocks[vectors.block].first;
        for (std::size_t i = 0; i < numbers.size(); ++i)
            for (double& number : numbers[i])
                if (number == number) number = roundTo(Precision::Float, number, first + i);
        return numbers;
    };

    // An accessor can be replaced if nothing else has its numbers.
    std::vector<std::size_t> references = countReferences(file_);
    std::map<std::size_t, std::set<std::size_t>> vectorsOfAccessor;
    std::set<std::tuple<std::size_t, std::size_t, std::optional<std::size_t>, std::string>> uses;
    for (const GltfDrawnMesh& drawn : scene_.meshes)
        for (const GltfUse& use : drawn.uses) {
            const std::size_t accessor = scene_.vectors[use.vectors].accessor;
            vectorsOfAccessor[accessor].insert(use.vectors);
            if (uses.emplace(use.mesh, use.primitive, use.target, use.semantic).second)
                --references[accessor];
        }
    const std::vector<bool> overlaps = overlappingAccessors(file_);

    // Targets come after the vectors to which they are added, and so are written in reverse.
    std::vector<std::size_t> accessors(now.size());
    for (std::size_t v = now.size(); v-- > 0;) {
        const std::size_t accessor = scene_.vectors[v].accessor;
        accessors[v] = accessor;
        if (!isChanged[v]) continue;
        const bool isOwn = references[accessor] == 0 && vectorsOfAccessor[accessor].size() == 1;
        accessors[v] = writeVectors(edit, file_, accessor, numbersFor(v),
                                    {.isOwn = isOwn, .isAlone = !overlaps[accessor]});
    }

    // A mesh that is drawn at several places gets a copy for each place after the first.
    std::set<std::size_t> changedMeshes, drawnMeshes;
    for (const GltfDrawnMesh& drawn : scene_.meshes)
        for (const GltfUse& use : drawn.uses)
            if (isChanged[use.vectors]) changedMeshes.insert(use.mesh);
    for (const GltfDrawnMesh& drawn : scene_.meshes) {
        std::size_t mesh = drawn.drawing.mesh;
        if (!changedMeshes.contains(mesh)) continue;
        Json& json = edit.json();
        if (!drawnMeshes.insert(mesh).second) {
            const Json copy = file_.item("meshes", mesh);
            mesh = json["meshes"].size();
            json["meshes"].push_back(copy);
            for (const std::size_t node : drawn.drawing.nodes) json["nodes"][node]["mesh"] = mesh;
        }
        for (const GltfUse& use : drawn.uses) {
            if (accessors[use.vectors] == scene_.vectors[use.vectors].accessor) continue;
            Json& primitive = json["meshes"][mesh]["primitives"][use.primitive];
            Json& attributes =
                use.target ? primitive["targets"][*use.target] : primitive["attributes"];
            attributes[use.semantic] = accessors[use.vectors];
        }
    }
    edit.write(path);
}

std::unique_ptr<Model> readGltfModel(const Format& format, const std::filesystem::path& path,
                                     std::string bytes) {
    return withJsonErrors(
        path, [&] { return std::make_unique<GltfModel>(format, path, std::move(bytes)); });
}

}  // namespace

const Format kGltfFormat = {.extensions = {".glb", ".gltf"},
                            .readModel = readGltfModel,
                            .writeSurface = writeGltfSurface,
                            .normals = Format::Normals::Corners,
                            .holdsTriangles = true,
                            .holdsAppearance = true,
                            .writeAnimation = writeMorphTargets};

}  // namespace espalier::io

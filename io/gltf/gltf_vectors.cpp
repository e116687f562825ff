// SPDX-License-Identifier: Apache-2.0
#include "gltf_vectors.h"

#include <espalier/base/error.h>
#include <espalier/base/memory.h>
#include <espalier/base/progress.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <tuple>
#include <utility>

#include "gltf_accessor.h"

namespace espalier::io {
namespace {

constexpr std::pair<const char*, GltfVectorKind> kSemantics[] = {
    {"POSITION", GltfVectorKind::Points},
    {"NORMAL", GltfVectorKind::Normals},
    {"TANGENT", GltfVectorKind::Tangents}};

const char* nameOf(GltfVectorKind kind) {
    return kind == GltfVectorKind::Points    ? "positions"
           : kind == GltfVectorKind::Normals ? "normals"
                                             : "tangents";
}

/// Reads the vectors of all drawn meshes.
class SceneReader : public GltfScene {
public:
    explicit SceneReader(const GltfFile& file) : file_(file), world_(worldMaps(file)) {
        for (const GltfDrawing& drawing : drawingsOf(file, world_)) {
            checkCancelled();
            addMesh(drawing);
        }
    }

private:
    void addMesh(const GltfDrawing& drawing) {
        mesh_ = &meshes.emplace_back(GltfDrawnMesh{drawing, {}, {}, {}});
        const Json& json = file_.item("meshes", drawing.mesh);
        const auto primitives = json.find("primitives");
        if (primitives == json.end() || !primitives->is_array())
            file_.fail(concat("mesh ", drawing.mesh, " has no primitives"));
        for (std::size_t i = 0; i < primitives->size(); ++i) addPrimitive((*primitives)[i], i);
    }

    void addPrimitive(const Json& primitive, std::size_t number) {
        const auto attributes = primitive.find("attributes");
        const bool hasPoints = attributes != primitive.end() && attributes->is_object() &&
                               attributes->contains("POSITION");
        mesh_->normals.push_back(std::nullopt);
        mesh_->blocks.push_back(blocks.size());
        if (!hasPoints) {
            // Nothing is drawn of it.
            blocks.push_back({positions.size(), 0, identity()});
            return;
        }
        const std::size_t position = file_.needNumber(*attributes, "POSITION");
        const std::size_t count = accessorOf(file_, position).count;
        const auto maps = mapsOf(*attributes, count);
        std::map<GltfVectorKind, std::size_t> own;
        std::size_t block = 0;
        for (const auto& [semantic, kind] : kSemantics) {
            const auto accessor = file_.number(*attributes, semantic);
            if (!accessor) continue;
            if (kind == GltfVectorKind::Points)
                block = blockOf(position, std::nullopt, maps, count);
            own[kind] = vectorsOf(*accessor, kind, block, std::nullopt, count);
            mesh_->uses.push_back({mesh_->drawing.mesh, number, {}, semantic, own[kind]});
            if (kind == GltfVectorKind::Normals) mesh_->normals.back() = own[kind];
        }
        mesh_->blocks.back() = block;
        const auto targets = primitive.find("targets");
        if (targets == primitive.end()) return;
        if (!targets->is_array())
            file_.fail(
                concat("a primitive of mesh ", mesh_->drawing.mesh, " has malformed targets"));
        for (std::size_t target = 0; target < targets->size(); ++target) {
            std::size_t at = block;  // the points of a target without POSITION are the mesh's
            for (const auto& [semantic, kind] : kSemantics) {
                const Json& json = (*targets)[target];
                const auto accessor =
                    json.is_object() ? file_.number(json, semantic) : std::nullopt;
                if (!accessor || !own.contains(kind)) continue;
                if (kind == GltfVectorKind::Points) at = blockOf(position, *accessor, maps, count);
                mesh_->uses.push_back({mesh_->drawing.mesh, number, target, semantic,
                                       vectorsOf(*accessor, kind, at, own[kind], count)});
            }
        }
    }

    using Maps = std::shared_ptr<const std::vector<Affine>>;

    static Maps identity() {
        static const Maps kMaps = std::make_shared<const std::vector<Affine>>(1);
        return kMaps;
    }

    /// Returns the maps of the points of a primitive. Equal maps are one object.
    Maps mapsOf(const Json& attributes, std::size_t count) {
        const GltfDrawing& drawing = mesh_->drawing;
        if (!drawing.skin) {
            if (drawing.matrix == Affine{}) return identity();
            Maps& maps = matrices_[{drawing.matrix.linear, drawing.matrix.translation}];
            if (!maps) maps = std::make_shared<const std::vector<Affine>>(1, drawing.matrix);
            return maps;
        }
        std::string accessors = concat(*drawing.skin, " ", count);
        for (const auto& [name, accessor] : attributes.items())
            if (name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_"))
                accessors += concat(" ", name, " ", accessor.dump());
        Maps& maps = skins_[accessors];
        if (maps) return maps;
        auto joints = joints_.find(*drawing.skin);
        if (joints == joints_.end())
            joints = joints_.emplace(*drawing.skin, jointMaps(file_, world_, *drawing.skin)).first;
        maps = std::make_shared<const std::vector<Affine>>(
            skinMaps(file_, joints->second, attributes, count));
        return maps;
    }

    /// Returns the number of the block of these points, which is new or known.
    std::size_t blockOf(std::size_t position, std::optional<std::size_t> target, const Maps& maps,
                        std::size_t count) {
        const auto [found, isNew] =
            blocks_.try_emplace({position, target, maps.get()}, blocks.size());
        if (isNew) blocks.push_back({positions.size(), count, maps});
        return found->second;
    }

    /// Returns the number of these vectors, which are new or known. Adds new points to positions.
    std::size_t vectorsOf(std::size_t accessor, GltfVectorKind kind, std::size_t block,
                          std::optional<std::size_t> base, std::size_t count) {
        const auto [found, isNew] =
            vectors_.try_emplace({accessor, kind, block, base}, vectors.size());
        if (!isNew) return found->second;
        requireMemory(2 * count * sizeof(Point3), concat("accessor ", accessor));
        GltfVectors made{accessor, kind, block, base};
        made.local = io::vectorsOf(file_, accessor, nameOf(kind), count);
        if (base) {
            made.displacements = made.local;
            const std::vector<Point3>& zero = vectors[*base].local;
            for (std::size_t i = 0; i < count; ++i) made.local[i] = sum(zero[i], made.local[i]);
        }
        if (kind == GltfVectorKind::Points) {
            const GltfBlock& at = blocks[block];
            for (std::size_t i = 0; i < count; ++i) {
                checkCancelledEvery(i, 14);
                const Point3& local = made.local[i];
                const bool isDrawnAsIs = at.maps == identity();
                positions.push_back(isDrawnAsIs ? local : at.map(i) * local);
                if (!std::ranges::all_of(positions.back(),
                                         [](double x) { return std::isfinite(x); }))
                    file_.fail(concat("point ", i, " of accessor ", accessor, " is not finite"));
            }
        }
        vectors.push_back(std::move(made));
        return found->second;
    }

    const GltfFile& file_;
    const std::vector<Affine> world_;  ///< the maps of all nodes
    GltfDrawnMesh* mesh_ = nullptr;    ///< the current one
    std::map<std::pair<DeformationGradient, Point3>, Maps> matrices_;
    std::map<std::string, Maps> skins_;
    std::map<std::size_t, std::vector<Affine>> joints_;
    std::map<std::tuple<std::size_t, std::optional<std::size_t>, const void*>, std::size_t> blocks_;
    std::map<std::tuple<std::size_t, GltfVectorKind, std::size_t, std::optional<std::size_t>>,
             std::size_t>
        vectors_;
};

}  // namespace

GltfScene readGltfScene(const GltfFile& file) {
    SceneReader reader(file);
    return std::move(static_cast<GltfScene&>(reader));
}

}  // namespace espalier::io

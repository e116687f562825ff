// SPDX-License-Identifier: Apache-2.0
// Implements espalier_model.h.
#include <espalier/base/lazy.h>
#include <espalier/io/model_part.h>
#include <espalier/io/read_notes.h>
#include <espalier/solve/sliding_points.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "espalier_model.h"
#include "guard.h"

using namespace espalier;

struct espalier_model {
    struct Faces {
        std::vector<std::int64_t> offsets;
        std::vector<std::int32_t> corners;
    };

    /// Names as C takes them.
    struct Names {
        std::vector<std::string> texts;
        std::vector<const char*> pointers;
    };

    struct Appearance {
        io::ModelSurface surface;  ///< without faces
        Names materials;
    };

    std::unique_ptr<io::Model> model;
    std::string name;  ///< of the file, for messages
    std::string notes;
    mutable Lazy<Faces> faces = {};  ///< read on the first request, as are the names
    mutable Lazy<Names> attributes = {}, groups = {};
    mutable Lazy<Appearance> appearance = {};
};

struct espalier_sliding_points {
    solve::SlidingPoints points;
    Offset pointCount;
};

namespace espalier::c {
namespace {

std::vector<std::string> namesIn(const char* const* names, std::int32_t count, const char* what) {
    std::vector<std::string> texts;
    for (const char* const name : c::array(names, count, what))
        texts.emplace_back(&c::deref(name, what));
    return texts;
}

espalier_model* modelOf(const char* name, std::unique_ptr<io::Model> model) {
    std::string notes = io::describe(name, *model);
    return new espalier_model{std::move(model), name, std::move(notes)};
}

espalier_model::Faces facesOf(io::ModelFaces read) {
    espalier_model::Faces faces;
    faces.offsets.reserve(read.count() + 1);
    faces.offsets.push_back(0);
    for (const std::size_t end : read.ends) faces.offsets.push_back(std::int64_t(end));
    faces.corners = std::move(read.corners);
    return faces;
}

espalier_model::Names namesOf(std::vector<std::string> texts) {
    espalier_model::Names names;
    names.texts = std::move(texts);
    for (const std::string& text : names.texts) names.pointers.push_back(text.c_str());
    return names;
}

/// Reads the appearance of a model, and its faces in the same pass over the file.
espalier_model::Appearance readAppearance(const espalier_model& own) {
    espalier_model::Appearance result;
    io::ModelSurface& surface = result.surface;
    surface = own.model->readSurface();
    io::readAppearance(*own.model, surface);
    own.faces.get([&] { return facesOf(std::move(surface.faces)); });
    surface.faces = {};
    result.materials = namesOf(std::exchange(surface.materials, {}));
    return result;
}

/// Returns the address of the first number of an array; null if it is empty.
template <class Items>
auto* numbersOf(const Items& items) {
    if constexpr (std::is_scalar_v<typename Items::value_type>)
        return items.empty() ? nullptr : items.data();
    else
        return items.empty() ? nullptr : items.front().data();
}

void give(const espalier_model::Names& names, std::int32_t* count, const char* const** pointers) {
    auto& outCount = deref(count, "count");
    deref(pointers, "names") = names.pointers.data();
    outCount = static_cast<std::int32_t>(names.pointers.size());
}

}  // namespace
}  // namespace espalier::c

espalier_status espalier_model_read(const char* path, espalier_model** model) {
    return c::result(model, "model", [&] {
        const char* const name = &c::deref(path, "path");
        return c::modelOf(name, io::readModel(name));
    });
}

espalier_status espalier_model_read_bytes(const char* name, int64_t size, const void* bytes,
                                          espalier_model** model) {
    return c::result(model, "model", [&] {
        const auto given = c::array(static_cast<const char*>(bytes), size, "bytes");
        const char* const file = &c::deref(name, "name");
        return c::modelOf(file, io::readModel(file, std::string(given.begin(), given.end())));
    });
}

void espalier_model_destroy(espalier_model* model) {
    delete model;
}

espalier_status espalier_model_points(const espalier_model* model, int32_t* point_count,
                                      const double** points) {
    return c::guarded([&] {
        const auto own = c::deref(model, "model").model->positions();
        auto& count = c::deref(point_count, "point_count");
        c::deref(points, "points") = own.front().data();
        count = static_cast<std::int32_t>(own.size());
    });
}

espalier_status espalier_model_faces(const espalier_model* model, espalier_polygons* faces) {
    return c::result(faces, "faces", [&] {
        const auto& own = c::deref(model, "model");
        const auto& known =
            own.faces.get([&] { return c::facesOf(own.model->readSurface().faces); });
        return espalier_polygons{std::ssize(known.offsets) - 1, known.offsets.data(),
                                 known.corners.data()};
    });
}

espalier_status espalier_model_appearance(const espalier_model* model,
                                          espalier_appearance* appearance) {
    return c::result(appearance, "appearance", [&] {
        const auto& own = c::deref(model, "model");
        const auto& [surface, materials] =
            own.appearance.get([&] { return c::readAppearance(own); });
        espalier_appearance result = {};
        if (!surface.textureCorners.empty()) {
            result.texture_count = static_cast<std::int32_t>(surface.textures.size());
            result.textures = c::numbersOf(surface.textures);
            result.texture_corners = c::numbersOf(surface.textureCorners);
        }
        result.normal_count = static_cast<std::int32_t>(surface.normals.size());
        result.normals = c::numbersOf(surface.normals);
        result.normal_corners = c::numbersOf(surface.normalCorners);
        result.colors = c::numbersOf(surface.colors);
        result.covariances = c::numbersOf(surface.covariances);
        result.material_count = static_cast<std::int32_t>(materials.pointers.size());
        result.materials = c::numbersOf(materials.pointers);
        result.face_materials = c::numbersOf(surface.faceMaterials);
        return result;
    });
}

espalier_status espalier_model_has_directions(const espalier_model* model,
                                              int32_t* has_directions) {
    return c::result(has_directions, "has_directions",
                     [&] { return c::deref(model, "model").model->hasDirections() ? 1 : 0; });
}

espalier_status espalier_model_notes(const espalier_model* model, const char** notes) {
    return c::result(notes, "notes", [&] { return c::deref(model, "model").notes.c_str(); });
}

espalier_status espalier_model_attributes(const espalier_model* model, int32_t* count,
                                          const char* const** names) {
    return c::guarded([&] {
        const auto& own = c::deref(model, "model");
        c::give(
            own.attributes.get([&] { return c::namesOf(io::namesOf(own.model->attributes())); }),
            count, names);
    });
}

espalier_status espalier_model_groups(const espalier_model* model, int32_t* count,
                                      const char* const** names) {
    return c::guarded([&] {
        const auto& own = c::deref(model, "model");
        c::give(own.groups.get([&] { return c::namesOf(io::namesOf(own.model->groups())); }), count,
                names);
    });
}

espalier_status espalier_model_weights(const espalier_model* model, const char* attribute,
                                       int32_t group_count, const char* const* groups,
                                       int32_t point_count, double* weights) {
    return c::guarded([&] {
        const auto& own = c::deref(model, "model");
        c::checkCount(point_count, std::ssize(own.model->positions()), "points");
        const auto result = c::array(weights, point_count, "weights");
        io::ModelPart part;
        if (attribute != nullptr) part.weights = attribute;
        part.groups = c::namesIn(groups, group_count, "groups");
        const auto values = io::weightsOf(own.name, *own.model, part, false).values;
        if (values.empty())
            std::fill(result.begin(), result.end(), 1);
        else
            std::ranges::copy(values, result.begin());
    });
}

espalier_status espalier_model_hold(const espalier_model* model, int32_t group_count,
                                    const char* const* groups, int32_t point_count,
                                    double* weights) {
    return c::guarded([&] {
        const auto& own = c::deref(model, "model");
        c::checkCount(point_count, std::ssize(own.model->positions()), "points");
        const auto result = c::array(weights, point_count, "weights");
        io::ModelPart part;
        part.holds = c::namesIn(groups, group_count, "groups");
        for (const Index point : io::heldPointsOf(own.name, *own.model, part)) result[point] = 0;
    });
}

espalier_status espalier_sliding_points_create(const espalier_model* model, int32_t patch_count,
                                               const char* const* patches,
                                               espalier_sliding_points** sliding) {
    return c::result(sliding, "sliding", [&] {
        const auto& own = c::deref(model, "model");
        std::vector<far::MeshPatch> found;
        for (const std::string& name : c::namesIn(patches, patch_count, "patches"))
            found.push_back(io::patchOf(own.name, *own.model, name));
        const auto rest = own.model->positions();
        return new espalier_sliding_points{solve::SlidingPoints(found, rest), std::ssize(rest)};
    });
}

void espalier_sliding_points_destroy(espalier_sliding_points* sliding) {
    delete sliding;
}

espalier_status espalier_sliding_points_slide(const espalier_sliding_points* sliding,
                                              int32_t point_count, double* points,
                                              double* largest) {
    return c::guarded([&] {
        const auto& own = c::deref(sliding, "sliding");
        c::checkCount(point_count, own.pointCount, "points");
        auto moved = c::positions(points, point_count, "points");
        const auto correction = own.points.slide(moved);
        std::memcpy(points, moved.data(), moved.size() * sizeof(Point3));
        if (largest != nullptr) *largest = correction.distance;
    });
}

espalier_status espalier_model_weight_slopes(const espalier_model* model, int32_t point_count,
                                             const double* weights, double* slopes) {
    return c::guarded([&] {
        const io::Model& own = *c::deref(model, "model").model;
        c::checkCount(point_count, std::ssize(own.positions()), "points");
        const auto values = c::array(weights, point_count, "weights");
        const auto result = c::array(slopes, point_count, "slopes", 3);
        const auto found = io::withSlopes(own, {values.begin(), values.end()}).slopes;
        if (found.empty())
            std::fill(result.begin(), result.end(), 0);
        else
            std::memcpy(result.data(), found.data(), found.size() * sizeof(Point3));
    });
}

espalier_status espalier_model_write(const espalier_model* model, const char* path,
                                     int32_t point_count, const double* points,
                                     const double* gradients) {
    return c::guarded([&] {
        const io::Model& own = *c::deref(model, "model").model;
        const char* to = &c::deref(path, "path");
        c::checkCount(point_count, std::ssize(own.positions()), "points");
        const auto moved = c::positions(points, point_count, "points");
        if (gradients == nullptr) {
            own.write(to, moved);
            return;
        }
        std::vector<DeformationGradient> atPoints(moved.size());
        std::memcpy(atPoints.data(), gradients, atPoints.size() * sizeof(DeformationGradient));
        own.write(to, moved, atPoints);
    });
}

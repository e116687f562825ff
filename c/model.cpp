// SPDX-License-Identifier: Apache-2.0
// Implements espalier_model.h.
#include <espalier/base/lazy.h>
#include <espalier/io/model.h>
#include <espalier/io/read_notes.h>

#include <cstring>
#include <memory>
#include <string>
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

    std::unique_ptr<io::Model> model;
    std::string notes;
    mutable Lazy<Faces> faces = {};  ///< read on the first request
};

namespace espalier::c {
namespace {

espalier_model* modelOf(const char* name, std::unique_ptr<io::Model> model) {
    std::string notes = io::describe(name, *model);
    return new espalier_model{std::move(model), std::move(notes)};
}

espalier_model::Faces readFaces(const io::Model& model) {
    io::ModelFaces read = model.readSurface().faces;
    espalier_model::Faces faces;
    faces.offsets.reserve(read.count() + 1);
    faces.offsets.push_back(0);
    for (const std::size_t end : read.ends) faces.offsets.push_back(std::int64_t(end));
    faces.corners = std::move(read.corners);
    return faces;
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
        const auto& known = own.faces.get([&] { return c::readFaces(*own.model); });
        return espalier_polygons{std::ssize(known.offsets) - 1, known.offsets.data(),
                                 known.corners.data()};
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

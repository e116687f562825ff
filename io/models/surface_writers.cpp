// SPDX-License-Identifier: Apache-2.0
#include "surface_writers.h"

#include <cstddef>
#include <ostream>
#include <string_view>

#include "../files/text_output.h"

namespace espalier::io {
namespace {

void putVectors(TextOutput& out, std::string_view keyword, std::span<const Point3> vectors) {
    for (const Point3& vector : vectors)
        out.put(keyword, vector[0], " ", vector[1], " ", vector[2], "\n");
}

}  // namespace

void putObjPoints(TextOutput& out, std::span<const Point3> points) {
    putVectors(out, "v ", points);
}

void putObjFace(TextOutput& out, std::span<const Index> points, std::span<const Index> textures,
                std::span<const Index> normals) {
    out.put("f");
    for (std::size_t corner = 0; corner < points.size(); ++corner) {
        out.put(" ", points[corner] + 1);
        if (!textures.empty()) out.put("/", textures[corner] + 1);
        if (!normals.empty()) out.put(textures.empty() ? "//" : "/", normals[corner] + 1);
    }
    out.put("\n");
}

void writeObjSurface(std::ostream& stream, const SurfaceView& surface) {
    TextOutput out(stream);
    putObjPoints(out, surface.points);
    putVectors(out, "vn ", surface.normals);
    for (std::size_t face = 0; face < surface.faces.count(); ++face) {
        const auto corners = surface.faces[face];
        std::span<const Index> normals;
        if (!surface.normalCorners.empty())
            normals = surface.normalCorners.subspan(surface.faces.ends[face] - corners.size(),
                                                    corners.size());
        else if (!surface.normals.empty())
            normals = corners;
        putObjFace(out, corners, {}, normals);
    }
}

void writePlySurface(std::ostream& stream, const SurfaceView& surface) {
    TextOutput out(stream);
    out.put("ply\nformat ascii 1.0\nelement vertex ", surface.points.size(),
            "\nproperty double x\nproperty double y\nproperty double z\n");
    if (!surface.normals.empty())
        out.put("property double nx\nproperty double ny\nproperty double nz\n");
    out.put("element face ", surface.faces.count(),
            "\nproperty list int int vertex_indices\nend_header\n");
    for (std::size_t point = 0; point < surface.points.size(); ++point) {
        const auto put = [&](const Point3& vector) {
            out.put(vector[0], " ", vector[1], " ", vector[2]);
        };
        put(surface.points[point]);
        if (!surface.normals.empty()) {
            out.put(" ");
            put(surface.normals[point]);
        }
        out.put("\n");
    }
    for (std::size_t face = 0; face < surface.faces.count(); ++face) {
        const auto corners = surface.faces[face];
        out.put(corners.size());
        for (const Index corner : corners) out.put(" ", corner);
        out.put("\n");
    }
}

}  // namespace espalier::io

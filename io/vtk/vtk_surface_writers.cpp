// SPDX-License-Identifier: Apache-2.0
#include "vtk_surface_writers.h"

#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "../files/text_output.h"
#include "vtk_cells.h"
#include "vtk_xml_output.h"

namespace espalier::io {
namespace {

/// \param isGrid writes an UnstructuredGrid, else a PolyData
void writeXmlSurface(std::ostream& stream, const SurfaceView& surface, bool isGrid) {
    constexpr std::uint8_t kTriangle = 5, kQuadrilateral = 9;
    constexpr auto kPolygon = static_cast<std::uint8_t>(kVtkPolygon);
    const ModelFaces& faces = surface.faces;
    const std::vector<std::int64_t> corners(faces.corners.begin(), faces.corners.end());
    const std::vector<std::int64_t> ends(faces.ends.begin(), faces.ends.end());
    std::vector<std::uint8_t> types;
    for (std::size_t face = 0; face < faces.count() && isGrid; ++face) {
        const std::size_t size = faces[face].size();
        types.push_back(size == 3 ? kTriangle : size == 4 ? kQuadrilateral : kPolygon);
    }
    VtkXmlOutput out(stream, isGrid ? "UnstructuredGrid" : "PolyData", VtkArrayForm::Base64, true);
    const char* const cells = isGrid ? "Cells" : "Polys";
    out.file([&] {
        out.piece(surface.points.size(), cells, faces.count(), [&] {
            if (!surface.normals.empty())
                out.section(
                    "PointData", [&] { out.array("Normals", 3, coordinatesOf(surface.normals)); },
                    " Normals=\"Normals\"");
            out.section("Points", [&] { out.array("Points", 3, coordinatesOf(surface.points)); });
            out.section(cells, [&] {
                out.array("connectivity", corners);
                out.array("offsets", ends);
                if (isGrid) out.array("types", types);
            });
        });
    });
}

}  // namespace

void writeVtpSurface(std::ostream& out, const SurfaceView& surface) {
    writeXmlSurface(out, surface, false);
}

void writeVtuSurface(std::ostream& out, const SurfaceView& surface) {
    writeXmlSurface(out, surface, true);
}

void writeVtkLegacySurface(std::ostream& stream, const SurfaceView& surface) {
    TextOutput out(stream);
    const ModelFaces& faces = surface.faces;
    out.put("# vtk DataFile Version 3.0\nEspalier model\nASCII\nDATASET POLYDATA\nPOINTS ",
            surface.points.size(), " double\n");
    out.rows(coordinatesOf(surface.points), 3);
    if (faces.count() > 0)
        out.put("POLYGONS ", faces.count(), " ", faces.count() + faces.corners.size(), "\n");
    for (std::size_t face = 0; face < faces.count(); ++face) {
        out.put(faces[face].size());
        for (const Index corner : faces[face]) out.put(" ", corner);
        out.put("\n");
    }
    if (surface.normals.empty()) return;
    out.put("POINT_DATA ", surface.points.size(), "\nNORMALS Normals double\n");
    out.rows(coordinatesOf(surface.normals), 3);
}

}  // namespace espalier::io

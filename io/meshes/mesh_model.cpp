// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>

#include <algorithm>
#include <vector>

#include "../lattices/lattice_parts.h"
#include "mesh_cells.h"
#include "mesh_format.h"
#include "surface_faces.h"

namespace espalier::io {

void visitVolume(const far::VolumeMesh& mesh, CellVisitor& visitor) {
    std::vector<std::vector<Index>> loops;
    for (Index cell = 0; cell < mesh.cellCount(); ++cell) {
        loops.clear();
        for (const Index face : mesh.faces(cell)) {
            loops.emplace_back(mesh.face(face).begin(), mesh.face(face).end());
            if (mesh.owner(face) != cell) std::reverse(loops.back().begin(), loops.back().end());
        }
        visitor.polyhedron(loops);
    }
    for (Index face = mesh.internalFaceCount(); face < mesh.faceCount(); ++face)
        visitor.boundaryFace(mesh.face(face));
}

std::string listedFiles(std::span<const std::string> names) {
    constexpr std::size_t kShown = 3;
    std::string text;
    for (std::size_t i = 0; i < std::min(names.size(), kShown); ++i)
        text += (i == 0 ? "" : ", ") + inQuotes(names[i]);
    return names.size() > kShown ? concat(text, " and ", names.size() - kShown, " more") : text;
}

ModelSurface readMeshSurface(const MeshFormat& format, const FileView& file) {
    SurfaceFaces surface;
    format.readCells(file.path, file.bytes, file.pointCount(), surface);
    return surface.take();
}

ModelCells readMeshCells(const MeshFormat& format, const FileView& file) {
    if (format.readModelCells) return format.readModelCells(file);
    MeshCells cells;
    format.readCells(file.path, file.bytes, file.pointCount(), cells);
    return withPathInErrors(file.path, [&] { return cells.finish(file.numbers.points.values); });
}

}  // namespace espalier::io

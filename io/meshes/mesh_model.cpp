// SPDX-License-Identifier: Apache-2.0
#include "../lattices/lattice_parts.h"
#include "mesh_cells.h"
#include "mesh_format.h"
#include "surface_faces.h"

namespace espalier::io {

ModelSurface readMeshSurface(const MeshFormat& format, const FileView& file) {
    SurfaceFaces surface;
    format.readCells(file.path, file.bytes, file.pointCount(), surface);
    return surface.take();
}

ModelCells readMeshCells(const MeshFormat& format, const FileView& file) {
    if (format.readBeside) {
        // OpenFOAM is the only format that has its cells in other files.
        ModelCells cells{format.readBeside(file.path, file.pointCount())};
        cells.isOpenFoam = true;
        return cells;
    }
    MeshCells cells;
    format.readCells(file.path, file.bytes, file.pointCount(), cells);
    return withPathInErrors(file.path, [&] { return cells.finish(file.numbers.points.values); });
}

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#include "../lattices/lattice_parts.h"
#include "mesh_format.h"
#include "patch_collector.h"
#include "surface_faces.h"
#include "volume_cells.h"

namespace espalier::io {

ModelSurface readMeshSurface(const MeshFormat& format, const FileView& file) {
    SurfaceFaces surface;
    format.readCells(file.path, file.bytes, file.pointCount(), surface);
    return surface.take();
}

ModelVolume readMeshVolume(const MeshFormat& format, const FileView& file) {
    if (format.readVolume) {
        ModelVolume volume;
        volume.mesh = format.readVolume(file.path, file.pointCount());
        volume.isOpenFoam = true;  // The only format that has its cells in other files.
        return volume;
    }
    VolumeCells cells;
    format.readCells(file.path, file.bytes, file.pointCount(), cells);
    return withPathInErrors(file.path, [&] { return cells.finish(file.numbers.points.values); });
}

std::vector<far::MeshPatch> readMeshPatches(const MeshFormat& format, const FileView& file) {
    if (format.readPatches) return format.readPatches(file.path, file.pointCount());
    PatchCollector patches;
    format.readCells(file.path, file.bytes, file.pointCount(), patches);
    return patches.take();
}

}  // namespace espalier::io

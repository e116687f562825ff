// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <ostream>
#include <utility>

#include "../lattices/lattice_parts.h"
#include "mesh_format.h"
#include "surface_faces.h"
#include "volume_cells.h"

namespace espalier::io {
namespace {

class MeshModel final : public Model {
public:
    MeshModel(const MeshFormat& format, const std::filesystem::path& path, std::string bytes)
        : format_(format),
          path_(path),
          bytes_(std::move(bytes)),
          points_(format.readPoints(path_, bytes_)) {
        checkedIndex(path, points_.positions.size(), "points");
    }

    std::span<const Point3> positions() const override { return points_.positions; }
    std::string_view extension() const override { return format_.extension; }
    bool hasDirections() const override { return false; }

    CoordinateStorage storage() const override {
        return points_.order ? storageOf(points_.precision) : CoordinateStorage::Text;
    }

    ModelSurface readSurface() const override {
        SurfaceFaces surface;
        readCells(surface);
        return surface.take();
    }

    ModelVolume readVolume() const override {
        if (format_.readVolume)
            return {format_.readVolume(path_, static_cast<Index>(points_.positions.size()))};
        VolumeCells cells;
        readCells(cells);
        return withPathInErrors(path_, [&] { return cells.finish(points_.positions); });
    }

private:
    void readCells(CellVisitor& visitor) const {
        format_.readCells(path_, bytes_, static_cast<Index>(points_.positions.size()), visitor);
    }

    void checkOwnTarget(const std::filesystem::path& target) const override {
        if (format_.checkTarget)
            format_.checkTarget(path_, target, static_cast<Index>(points_.positions.size()));
    }

    void writeChecked(const std::filesystem::path& path, std::span<const Point3> moved,
                      std::span<const DeformationGradient>) const override {
        if (points_.dimension == 2)
            for (std::size_t point = 0; point < moved.size(); ++point)
                if (moved[point][2] != 0)
                    throw Error(concat(
                        "the new position of point ", point,
                        " has z = ", formatNumber(moved[point][2]),
                        ", but the mesh is of two dimensions and has no z; use a lattice whose "
                        "poses move the plane z = 0 into itself"));
        const VectorChange change{points_.places,
                                  points_.positions,
                                  moved,
                                  {points_.precision, points_.precision, points_.precision}};
        writeFile(path, [&](std::ostream& out) {
            if (points_.order)
                writeChangedBinary(out, bytes_, {&change, 1}, *points_.order, points_.dimension);
            else
                writeChangedInAnyOrder(out, bytes_, change, points_.dimension);
        });
    }

    const MeshFormat& format_;
    std::filesystem::path path_;  ///< path of the file that was read
    std::string bytes_;
    PlacedPoints points_;
};

}  // namespace

std::unique_ptr<Model> readMeshModel(const MeshFormat& format, const std::filesystem::path& path,
                                     std::string bytes) {
    return std::make_unique<MeshModel>(format, path, std::move(bytes));
}

}  // namespace espalier::io

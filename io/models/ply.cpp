// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/file.h>
#include <espalier/io/models/ply.h>

#include <algorithm>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "coordinates.h"
#include "ply_header.h"
#include "ply_rows.h"

namespace espalier::io {
namespace {

class PlyModel final : public Model {
public:
    PlyModel(const std::filesystem::path& path, std::string bytes)
        : bytes_(std::move(bytes)),
          header_(parsePlyHeader(path, bytes_)),
          points_(readPlyRows(path, bytes_, header_)) {}

    std::span<const Point3> positions() const override { return points_.positions.values; }
    std::string_view extension() const override { return ".ply"; }
    bool hasDirections() const override { return !points_.directions.empty(); }

private:
    void writeChecked(const std::filesystem::path& path, std::span<const Point3> moved,
                      std::span<const DeformationGradient> gradients) const override {
        std::vector<VectorChange> changes = {changeOf(points_.positions, moved)};
        std::vector<std::vector<Point3>> turned;
        for (std::size_t i = 0; i < points_.directions.size() && !gradients.empty(); ++i) {
            const PlyVectors& vectors = points_.directions[i];
            turned.push_back(carried(vectors.values, gradients, header_.directions[i].carry,
                                     narrowest(vectors.precisions)));
            changes.push_back(changeOf(vectors, turned.back()));
        }
        writeFile(path, [&](std::ostream& out) {
            if (header_.format == PlyFormat::Ascii)
                writeChanged(out, bytes_, changes);
            else
                writeBinary(out, changes);
        });
    }

    static VectorChange changeOf(const PlyVectors& vectors, std::span<const Point3> now) {
        return {vectors.places, vectors.values, now, vectors.precisions};
    }

    static Precision narrowest(const std::array<Precision, 3>& precisions) {
        return *std::min_element(precisions.begin(), precisions.end());
    }

    void writeBinary(std::ostream& out, std::span<const VectorChange> changes) const {
        std::string bytes = bytes_;
        for (const VectorChange& change : changes)
            for (std::size_t point = 0; point < change.places.size(); ++point)
                for (std::size_t axis = 0; axis < 3; ++axis)
                    if (const auto value = change.at(point, axis))
                        storeCoordinate(bytes, change.places[point][axis], *value,
                                        change.precisions[axis], header_.byteOrder());
        out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    }

    std::string bytes_;
    PlyHeader header_;
    PlyPoints points_;
};

}  // namespace

std::unique_ptr<Model> readPly(const std::filesystem::path& path, std::string bytes) {
    return std::make_unique<PlyModel>(path, std::move(bytes));
}

}  // namespace espalier::io

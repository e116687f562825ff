// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/coordinates.h>
#include <espalier/io/file.h>
#include <espalier/io/ply.h>
#include <espalier/io/ply_header.h>
#include <espalier/io/ply_rows.h>

#include <ostream>
#include <string>
#include <utility>

namespace espalier::io {
namespace {

class PlyModel final : public Model {
public:
    PlyModel(const std::filesystem::path& path, std::string bytes)
        : bytes_(std::move(bytes)),
          header_(parsePlyHeader(path, bytes_)),
          points_(readPlyRows(path, bytes_, header_)) {}

    std::span<const Point3> positions() const override { return points_.positions; }
    std::string_view extension() const override { return ".ply"; }

private:
    void writeChecked(const std::filesystem::path& path,
                      std::span<const Point3> moved) const override {
        writeFile(path, [&](std::ostream& out) {
            if (header_.format == PlyFormat::Ascii)
                writeWithPositions(out, bytes_, points_.places, points_.positions, moved,
                                   header_.precisions());
            else
                writeBinary(out, moved);
        });
    }

    void writeBinary(std::ostream& out, std::span<const Point3> moved) const {
        std::string bytes = bytes_;
        const auto precisions = header_.precisions();
        for (std::size_t point = 0; point < moved.size(); ++point) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double value = roundTo(precisions[axis], moved[point][axis], point);
                if (value == points_.positions[point][axis]) continue;
                storeCoordinate(bytes, points_.places[point][axis], value, precisions[axis],
                                header_.byteOrder());
            }
        }
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

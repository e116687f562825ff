// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/file.h>
#include <espalier/io/models/obj.h>

#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "coordinates.h"
#include "obj_normals.h"
#include "obj_statements.h"

namespace espalier::io {
namespace {

class ObjModel final : public Model {
public:
    ObjModel(const std::filesystem::path& path, std::string text)
        : path_(path), text_(std::move(text)) {
        forEachObjStatement(path, text_, [&](ObjWords& words, std::size_t line) {
            const std::string_view keyword = readObjKeyword(words, path, line);
            if (keyword == "v") addPoint(readObjPoint(words, path, line));
            if (keyword == "vn") hasNormals_ = true;
        });
    }

    std::span<const Point3> positions() const override { return positions_; }
    std::string_view extension() const override { return ".obj"; }
    bool hasDirections() const override { return hasNormals_; }

private:
    void addPoint(const ObjPoint& point) {
        positions_.push_back(point.position);
        CoordinatePlaces& place = places_.emplace_back();
        for (std::size_t axis = 0; axis < 3; ++axis)
            place[axis] = static_cast<std::size_t>(point.words[axis].data() - text_.data());
    }

    void writeChecked(const std::filesystem::path& path, std::span<const Point3> moved,
                      std::span<const DeformationGradient> gradients) const override {
        const VectorChange points{places_, positions_, moved};
        writeFile(path, [&](std::ostream& out) {
            if (gradients.empty() || !hasNormals_)
                writeChanged(out, text_, {&points, 1});
            else
                writeWithNormals(out, path_, text_, points, gradients);
        });
    }

    std::filesystem::path path_;  ///< of the file that was read
    std::string text_;
    std::vector<Point3> positions_;
    std::vector<CoordinatePlaces> places_;
    bool hasNormals_ = false;
};

}  // namespace

std::unique_ptr<Model> readObj(const std::filesystem::path& path, std::string bytes) {
    return std::make_unique<ObjModel>(path, std::move(bytes));
}

}  // namespace espalier::io

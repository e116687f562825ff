// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/coordinates.h>
#include <espalier/io/file.h>
#include <espalier/io/obj.h>
#include <espalier/io/obj_statements.h>

#include <ostream>
#include <string>
#include <utility>
#include <vector>

namespace espalier::io {
namespace {

class ObjModel final : public Model {
public:
    ObjModel(const std::filesystem::path& path, std::string text) : text_(std::move(text)) {
        forEachObjStatement(path, text_, [&](ObjWords& words, std::size_t line) {
            if (words.next() == "v") addPoint(readObjPoint(words, path, line));
        });
    }

    std::span<const Point3> positions() const override { return positions_; }
    std::string_view extension() const override { return ".obj"; }

private:
    void addPoint(const ObjPoint& point) {
        positions_.push_back(point.position);
        CoordinatePlaces& place = places_.emplace_back();
        for (std::size_t axis = 0; axis < 3; ++axis)
            place[axis] = static_cast<std::size_t>(point.words[axis].data() - text_.data());
    }

    void writeChecked(const std::filesystem::path& path,
                      std::span<const Point3> moved) const override {
        writeFile(path, [&](std::ostream& out) {
            writeWithPositions(out, text_, places_, positions_, moved,
                               {Precision::Double, Precision::Double, Precision::Double});
        });
    }

    std::string text_;
    std::vector<Point3> positions_;
    std::vector<CoordinatePlaces> places_;
};

}  // namespace

std::unique_ptr<Model> readObj(const std::filesystem::path& path, std::string bytes) {
    return std::make_unique<ObjModel>(path, std::move(bytes));
}

}  // namespace espalier::io

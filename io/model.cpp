// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/file.h>
#include <espalier/io/model.h>
#include <espalier/io/obj.h>
#include <espalier/io/ply.h>
#include <espalier/io/stl.h>
#include <espalier/io/text_reader.h>
#include <espalier/io/vtu_model.h>

#include <cmath>
#include <string>
#include <utility>

namespace espalier::io {
namespace {

/// A VtuModel behind the common interface.
class GridModel final : public Model {
public:
    explicit GridModel(VtuModel grid) : grid_(std::move(grid)) {}

    std::span<const Point3> positions() const override { return grid_.positions(); }
    std::string_view extension() const override { return ".vtu"; }

private:
    void writeChecked(const std::filesystem::path& path,
                      std::span<const Point3> moved) const override {
        grid_.write(path, moved);
    }

    VtuModel grid_;
};

std::unique_ptr<Model> readGrid(const std::filesystem::path& path, std::string bytes) {
    return std::make_unique<GridModel>(VtuModel::read(path, std::move(bytes)));
}

struct ModelFormat {
    std::string_view extension;
    std::unique_ptr<Model> (*read)(const std::filesystem::path&, std::string bytes);
};

constexpr ModelFormat kFormats[] = {
    {".obj", readObj}, {".ply", readPly}, {".stl", readStl}, {".vtu", readGrid}};

const ModelFormat* findFormat(const std::filesystem::path& path) {
    const std::string extension = lowerCase(path.extension().string());
    for (const ModelFormat& format : kFormats)
        if (format.extension == extension) return &format;
    return nullptr;
}

const ModelFormat& requireFormat(const std::filesystem::path& path) {
    if (const ModelFormat* format = findFormat(path)) return *format;
    std::string known;
    for (const ModelFormat& format : kFormats)
        known.append(known.empty() ? "" : ", ").append(format.extension);
    throw FileError(path, "is not of a model format; expected the extension " + known);
}

}  // namespace

void Model::checkTarget(const std::filesystem::path& path) const {
    const ModelFormat* format = findFormat(path);
    if (format && format->extension != extension())
        throw FileError(path, "the model was read as " + std::string(extension()) +
                                  " and can only be written as that");
}

void Model::write(const std::filesystem::path& path, std::span<const Point3> moved) const {
    checkTarget(path);
    if (moved.size() != positions().size())
        throw Error("got " + std::to_string(moved.size()) + " positions for a model of " +
                    std::to_string(positions().size()) + " points");
    for (std::size_t point = 0; point < moved.size(); ++point)
        for (const double coordinate : moved[point])
            if (!std::isfinite(coordinate))
                throw Error("the new position of point " + std::to_string(point) +
                            " is not finite");
    writeChecked(path, moved);
}

std::unique_ptr<Model> readModel(const std::filesystem::path& path) {
    requireFormat(path);
    return readModel(path, readFile(path));
}

std::unique_ptr<Model> readModel(const std::filesystem::path& path, std::string bytes) {
    std::unique_ptr<Model> model = requireFormat(path).read(path, std::move(bytes));
    if (model->positions().empty()) throw FileError(path, "the model has no points");
    return model;
}

}  // namespace espalier::io

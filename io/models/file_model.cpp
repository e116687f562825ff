// SPDX-License-Identifier: Apache-2.0
#include "file_model.h"

#include <espalier/base/error.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <ostream>
#include <utility>

#include "../lattices/lattice_parts.h"

namespace espalier::io {
namespace {

Precision narrowest(const FileVectors& vectors) {
    return *std::min_element(vectors.precisions.begin(), vectors.precisions.end());
}

class FileModel final : public Model {
public:
    FileModel(const FileModelFormat& functions, const Format& format,
              const std::filesystem::path& path, std::string bytes)
        : Model(format, path),
          functions_(functions),
          path_(path),
          bytes_(std::move(bytes)),
          numbers_(functions.readNumbers(path_, bytes_)) {
        checkedIndex(path, numbers_.points.values.size(), "points");
    }

    std::span<const Point3> positions() const override { return numbers_.points.values; }
    std::vector<std::string> notes() const override { return numbers_.notes; }
    CoordinateStorage storage() const override { return numbers_.storage; }
    DirectionCounts directions() const override {
        DirectionCounts counts{numbers_.ownNormals};
        for (const FileVectors& vectors : numbers_.directions)
            (vectors.carry == carryNormal ? counts.normals : counts.tangents) +=
                vectors.values.size();
        return counts;
    }
    ModelSurface readSurface() const override { return functions_.readSurface(view()); }
    ModelVolume readVolume() const override {
        return functions_.readVolume ? functions_.readVolume(view()) : ModelVolume{};
    }

private:
    FileView view() const { return {path_, bytes_, numbers_}; }

    void checkOwnTarget(const std::filesystem::path& target) const override {
        if (functions_.checkTarget) functions_.checkTarget(view(), target);
    }

    void writeChecked(const std::filesystem::path& path, std::span<const Point3> moved,
                      std::span<const DeformationGradient> gradients) const override {
        writeFile(path, [&](std::ostream& out) {
            (functions_.write ? functions_.write : writeNumbers)(out, view(), moved, gradients);
        });
    }

    const FileModelFormat& functions_;
    std::filesystem::path path_;  ///< path of the file that was read
    std::string bytes_;
    FileNumbers numbers_;
};

}  // namespace

std::vector<Point3> normalsOf(const FileNumbers& numbers) {
    const auto normals =
        std::ranges::find(numbers.directions, Carry{carryNormal}, &FileVectors::carry);
    if (normals == numbers.directions.end()) return {};
    return {normals->values.begin(), normals->values.end()};
}

void writeNumbers(std::ostream& out, const FileView& file, std::span<const Point3> moved,
                  std::span<const DeformationGradient> gradients) {
    const FileNumbers& numbers = file.numbers;
    if (numbers.dimension == 2)
        for (std::size_t point = 0; point < moved.size(); ++point)
            if (moved[point][2] != 0)
                throw Error(concat(
                    "the new position of point ", point, " has z = ", formatNumber(moved[point][2]),
                    ", but the mesh is of two dimensions and has no z; use a lattice whose "
                    "poses move the plane z = 0 into itself"));
    std::vector<VectorChange> changes = {numbers.points.changeTo(moved)};
    std::vector<std::vector<Point3>> turned;
    turned.reserve(numbers.directions.size());  // the changes refer to its vectors
    for (const FileVectors& vectors : numbers.directions) {
        if (gradients.empty()) break;
        turned.push_back(carried(vectors.values, gradients, vectors.carry, narrowest(vectors)));
        changes.push_back(vectors.changeTo(turned.back()));
    }
    if (numbers.order)
        writeChangedBinary(out, std::string(file.bytes), changes, *numbers.order,
                           numbers.dimension);
    else
        writeChanged(out, file.bytes, changes, numbers.dimension);
}

std::unique_ptr<Model> makeFileModel(const FileModelFormat& functions, const Format& format,
                                     const std::filesystem::path& path, std::string bytes) {
    return std::make_unique<FileModel>(functions, format, path, std::move(bytes));
}

}  // namespace espalier::io

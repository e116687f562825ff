// SPDX-License-Identifier: Apache-2.0
#include "file_model.h"

#include <espalier/base/error.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <utility>

#include "../files/text_output.h"
#include "../lattices/lattice_parts.h"
#include "held_points.h"

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
          numbers_(functions.readNumbers(path_, bytes_)),
          held_(numbers_.points.values) {
        checkedIndex(path, numbers_.points.values.size(), "points");
        if (const auto used = held_.findUsed(*this)) {
            held_.restore(numbers_.points.values);
            refuseNotFinitePoint(view(), *used);
        }
        if (!held_.empty()) numbers_.notes.push_back(held_.note());
    }

    std::span<const Point3> positions() const override { return numbers_.points.values; }
    std::vector<Index> heldPoints() const override { return held_.numbers(); }
    std::vector<std::string> notes() const override { return numbers_.notes; }
    CoordinateStorage storage() const override { return numbers_.storage; }
    DirectionCounts directions() const override {
        DirectionCounts counts{numbers_.ownNormals};
        for (const FileVectors& vectors : numbers_.directions)
            (vectors.carry == carryNormal ? counts.normals : counts.tangents) +=
                vectors.values.size();
        counts.splats = numbers_.splats.rows.size();
        counts.keptHarmonics = numbers_.splats.keptHarmonics;
        return counts;
    }
    ModelSurface readSurface() const override { return functions_.readSurface(view()); }
    ModelCells readCells() const override {
        return functions_.readCells ? functions_.readCells(view()) : ModelCells{};
    }
    std::vector<Point3> stored(std::vector<Point3> points) const override {
        return functions_.stored ? functions_.stored(view(), std::move(points))
                                 : Model::stored(std::move(points));
    }
    std::vector<PointAttribute> attributes() const override {
        return functions_.attributes ? functions_.attributes(view())
                                     : std::vector<PointAttribute>();
    }
    std::vector<PointGroup> groups() const override {
        return functions_.groups ? functions_.groups(view()) : groupsOf(readCells().patches);
    }

private:
    FileView view() const { return {path_, bytes_, numbers_}; }

    std::string ownLosses() const override {
        return functions_.losses ? functions_.losses(view()) : std::string();
    }

    void writeChecked(const std::filesystem::path& path, std::span<const Point3> moved,
                      std::span<const DeformationGradient> gradients) const override {
        const auto write = functions_.write ? functions_.write : writeNumbers;
        writeFile(path, [&](std::ostream& out) {
            if (held_.empty())
                write(out, view(), moved, gradients);
            else
                write(out, view(), held_.held(moved), held_.held(gradients));
        });
    }

    const FileModelFormat& functions_;
    std::filesystem::path path_;  ///< path of the file that was read
    std::string bytes_;
    FileNumbers numbers_;
    HeldPoints held_;  ///< the numbers have their stand-ins
};

}  // namespace

std::vector<Point3> normalsOf(const FileNumbers& numbers) {
    const auto normals =
        std::ranges::find(numbers.directions, Carry{carryNormal}, &FileVectors::carry);
    if (normals == numbers.directions.end()) return {};
    return {normals->values.begin(), normals->values.end()};
}

void refuseNotFinitePoint(const FileView& file, std::size_t point) {
    const auto& [values, offsets, precisions, carry] = file.numbers.points;
    std::size_t axis = 0;
    while (std::isfinite(values[point][axis])) ++axis;
    if (offsets.empty())
        throw FileError(file.path, concat(axisName(axis), " of point ", point, " is not finite"));
    const std::size_t offset = offsets[point][axis];
    if (file.numbers.order) refuseNotFinite(offset, axis, point, file.path);
    const std::string_view before = file.bytes.substr(0, offset);
    refuseNotFinite(numberAt(file.bytes, offset), axis, file.path,
                    1 + std::ranges::count(before, '\n'));
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
    const bool carriesSplats = !gradients.empty() && !numbers.splats.rows.empty();
    if (numbers.order) {
        // Rows of splats are in the order of the points. Parts of them need little memory.
        const auto& rows = numbers.splats.rows;
        const std::size_t atOnce = rows.empty() ? moved.size() : 1 << 14;
        for (std::size_t begin = 0, first = 0; begin < file.bytes.size(); first += atOnce) {
            const std::size_t last = std::min(first + atOnce, moved.size());
            const std::size_t end = last == moved.size() ? file.bytes.size() : rows[last];
            BinaryPart part{std::string(file.bytes.substr(begin, end - begin)), begin, first, last,
                            *numbers.order};
            changeBinary(part, changes, numbers.dimension);
            if (carriesSplats) carryBinary(numbers.splats, gradients, part);
            out.write(part.bytes.data(), static_cast<std::streamsize>(part.bytes.size()));
            begin = end;
        }
    } else {
        TextPatch patch(out, file.bytes);
        TextChanges others(file.bytes, changes, numbers.dimension);
        if (carriesSplats) carryText(numbers.splats, gradients, file.bytes, patch, others);
        others.applyUpTo(patch, file.bytes.size());
        patch.finish();
    }
}

std::unique_ptr<Model> makeFileModel(const FileModelFormat& functions, const Format& format,
                                     const std::filesystem::path& path, std::string bytes) {
    return std::make_unique<FileModel>(functions, format, path, std::move(bytes));
}

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/array.h>
#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/io/directions.h>
#include <espalier/io/model.h>

#include <array>
#include <bit>
#include <cstddef>
#include <filesystem>
#include <iosfwd>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "../format.h"
#include "coordinates.h"
#include "splats.h"

// The model of a file whose numbers are replaced where they stand; all other bytes are kept. A
// format gives functions that find the numbers and read the faces.

namespace espalier::io {

/// Vectors in a file, one per point: the points, or directions at them. A reader gives them as the
/// file has them, finite or not.
struct FileVectors {
    Array<Point3> values;
    Array<CoordinateOffsets> offsets;  ///< where the file has the numbers of each vector
    std::array<Precision, 3> precisions = {Precision::Double, Precision::Double, Precision::Double};
    Carry carry = nullptr;  ///< null for the points

    /// Makes room for `count` vectors, whose numbers are not set.
    void resize(std::size_t count) {
        values.resize(count);
        offsets.resize(count);
    }

    /// Makes room for `count` more vectors, so that no memory is left over.
    void reserveMore(std::size_t count) {
        values.reserve(values.size() + count);
        offsets.reserve(offsets.size() + count);
    }

    /// Returns the change to other vectors.
    VectorChange changeTo(std::span<const Point3> now) const {
        return {offsets, values, now, precisions};
    }
};

/// The numbers of a file that follow a lattice.
struct FileNumbers {
    FileVectors points;
    std::vector<FileVectors> directions;
    FileSplats splats;  ///< empty if the points are no splats

    std::optional<std::endian> order = {};  ///< byte order of binary numbers; nothing for text
    std::size_t dimension = 3;              ///< 2 or 3; in two dimensions, all z are 0
    CoordinateStorage storage = CoordinateStorage::Text;
    std::size_t ownNormals = 0;           ///< number of normals that the format writes itself
    std::vector<std::string> notes = {};  ///< Model::notes()

    /// Says that the file is binary, with points of this precision.
    void setBinary(std::endian byteOrder, Precision precision) {
        order = byteOrder;
        points.precisions.fill(precision);
        storage = storageOf(precision);
    }
};

/// Returns the normals of a file, one per point; empty if it has none.
std::vector<Point3> normalsOf(const FileNumbers& numbers);

/// A file that was read.
/// It is valid as long as the model.
struct FileView {
    const std::filesystem::path& path;
    std::string_view bytes;
    const FileNumbers& numbers;

    Index pointCount() const { return static_cast<Index>(numbers.points.values.size()); }
};

/// The functions of a format of such models. Each throws FileError if the file is malformed.
struct FileModelFormat {
    FileNumbers (*readNumbers)(const std::filesystem::path& path, std::string_view bytes);

    ModelSurface (*readSurface)(const FileView& file);

    /// Model::readCells(); null if the format has no cells.
    ModelCells (*readCells)(const FileView& file) = nullptr;

    /// Model::attributes() and Model::groups(); null if the format has none. The groups of a mesh
    /// are its patches.
    std::vector<PointAttribute> (*attributes)(const FileView& file) = nullptr;
    std::vector<PointGroup> (*groups)(const FileView& file) = nullptr;

    /// Writes the file, for formats with numbers that follow from others; null if writeNumbers()
    /// does it.
    /// \param gradients one per point, or empty
    void (*write)(std::ostream& out, const FileView& file, std::span<const Point3> moved,
                  std::span<const DeformationGradient> gradients) = nullptr;

    /// Model::stored(), for formats whose numbers have another precision than their storage has;
    /// null if there is no such number.
    std::vector<Point3> (*stored)(const FileView& file, std::vector<Point3> points) = nullptr;

    /// Returns what a file with other points loses, as a phrase; empty if it loses nothing. Null if
    /// no file loses anything.
    std::string (*losses)(const FileView& file) = nullptr;
};

/// Writes the file with moved points, and with directions that are carried by gradients, if there
/// are any.
/// \throws Error naming the point, if a file of two dimensions would get a z, or as roundTo()
void writeNumbers(std::ostream& out, const FileView& file, std::span<const Point3> moved,
                  std::span<const DeformationGradient> gradients);

/// Throws the error of a point whose numbers in the file are not finite.
[[noreturn]] void refuseNotFinitePoint(const FileView& file, std::size_t point);

/// Makes the model of a file.
/// \param functions must live for ever
std::unique_ptr<Model> makeFileModel(const FileModelFormat& functions, const Format& format,
                                     const std::filesystem::path& path, std::string bytes);

/// Format::readModel of a format that has these functions.
template <const FileModelFormat& functions>
std::unique_ptr<Model> readFileModel(const Format& format, const std::filesystem::path& path,
                                     std::string bytes) {
    return makeFileModel(functions, format, path, std::move(bytes));
}

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>

#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "../models/carried_directions.h"
#include "vtk_xml.h"

namespace espalier::io {

/// An unstructured grid (.vtu) as a thing that is deformed: only its points and the directions
/// there are read, and only they are replaced. All else in the file, whatever cells and arrays it
/// has, survives byte for byte, raw appended data included.
///
/// Directions are arrays of PointData of 3 components, Float32 or Float64: normals, if the array is
/// called "Normals" or the active Normals; tangents, if it is so by "Tangents". Any other is kept.
///
/// Immutable, and so safe to share between threads.
class VtuModel {
public:
    /// \throws FileError if the file cannot be read, is malformed, has a point that is not finite,
    /// or has an array of directions that are not one a point
    static VtuModel read(const std::filesystem::path& path);

    /// The same for a file that is in memory already.
    /// \param path for messages
    static VtuModel read(const std::filesystem::path& path, std::string bytes);

    /// The points of all pieces, in the order of the file.
    std::span<const Point3> positions() const { return positions_; }

    /// Whether a piece has directions.
    bool hasDirections() const;

    /// Writes the file with these points, one each, in place of its own, and its directions carried
    /// by the gradients.
    ///
    /// The array of Points becomes an inline one of the same number type (Float64, if that was of
    /// integers): ascii if it was ascii, else base64, compressed if the file is. In a piece where
    /// no point has moved it stays as it was. The same goes for arrays of directions.
    ///
    /// \param gradients one a point, or none: then the directions stay
    /// \throws Error if their number is not that of positions(), or one is too large for Float32;
    ///         FileError if the file cannot be written
    void write(const std::filesystem::path& path, std::span<const Point3> positions,
               std::span<const DeformationGradient> gradients = {}) const;

private:
    explicit VtuModel(VtkXmlFile file) : file_(std::move(file)) {}

    /// An array of the points of a piece, or of directions there.
    struct PlacedArray {
        VtkDataArray array;
        std::size_t firstPoint = 0;
        std::size_t pointCount = 0;
        Carry carry = nullptr;  ///< null for the points themselves
        std::vector<Point3> directions;
    };

    void addDirections(const VtkPiece& piece, std::size_t firstPoint, std::size_t pointCount);
    std::string changedElement(const PlacedArray& placed, std::span<const Point3> positions,
                               std::span<const DeformationGradient> gradients) const;

    VtkXmlFile file_;
    std::vector<PlacedArray> arrays_;  ///< in the order of the file
    std::vector<Point3> positions_;
};

}  // namespace espalier::io

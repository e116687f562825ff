// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/point.h>
#include <espalier/io/vtk_xml.h>

#include <filesystem>
#include <span>
#include <utility>
#include <vector>

namespace espalier::io {

/// An unstructured grid (.vtu) as a thing that is deformed: only its points are read, and only they
/// are replaced. All else in the file, whatever cells and arrays it has, survives byte for byte,
/// raw appended data included.
///
/// Immutable, and so safe to share between threads.
class VtuModel {
public:
    /// \throws FileError if the file cannot be read, is malformed, or has a point that is not
    /// finite
    static VtuModel read(const std::filesystem::path& path);

    /// The same for a file that is in memory already.
    /// \param path for messages
    static VtuModel read(const std::filesystem::path& path, std::string bytes);

    /// The points of all pieces, in the order of the file.
    std::span<const Point3> positions() const { return positions_; }

    /// Writes the file with these points, one each, in place of its own.
    ///
    /// The array of Points becomes an inline one of the same number type (Float64, if that was of
    /// integers): ascii if it was ascii, else base64, compressed if the file is. In a piece where
    /// no point has moved it stays as it was.
    ///
    /// \throws Error if their number is not that of positions(), or one is too large for Float32;
    ///         FileError if the file cannot be written
    void write(const std::filesystem::path& path, std::span<const Point3> positions) const;

private:
    explicit VtuModel(VtkXmlFile file) : file_(std::move(file)) {}

    /// The array of points of a piece that has some.
    struct PointArray {
        VtkDataArray array;
        std::size_t firstPoint = 0;
        std::size_t pointCount = 0;
    };

    VtkXmlFile file_;
    std::vector<PointArray> arrays_;
    std::vector<Point3> positions_;
};

}  // namespace espalier::io

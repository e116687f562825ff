// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/io/directions.h>

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace espalier::io {

/// The thing that is deformed: a file with points in it. Moved points are written into a copy of
/// that file in which all else is as it was read, byte for byte. Where no point has moved, the copy
/// is identical.
///
/// Directions at the points, normals and tangents, are left alone too, unless it is said how the
/// surroundings of each point are deformed. What is a direction is said in obj.h and ply.h; in a
/// VTU, arrays of PointData of 3 components, Float32 or Float64, that are called "Normals" or
/// "Tangents", or are the active ones.
///
/// Immutable, and so safe to share between threads.
class ESPALIER_API Model {
public:
    virtual ~Model() = default;
    Model(const Model&) = delete;
    Model& operator=(const Model&) = delete;

    /// The points in the order of the file; all are finite.
    virtual std::span<const Point3> positions() const = 0;

    /// Extension of the format, in lower case: ".obj". A model is written in the format that it was
    /// read in.
    virtual std::string_view extension() const = 0;

    /// Whether there are directions that write() carries where it is given gradients. The normals
    /// of an STL follow its points in any case, and do not count.
    virtual bool hasDirections() const = 0;

    /// Checks a name for write() without touching the file, so that it can be refused before long
    /// work. An extension that is not of any model format is accepted ("/dev/stdout").
    /// \throws FileError if `path` has the extension of another model format
    void checkTarget(const std::filesystem::path& path) const;

    /// Writes the model with these positions, one a point, in place of its own.
    ///
    /// A format of floats rounds them. The file is replaced when all is written (see writeFile).
    ///
    /// \throws Error if their number is not that of positions(), or if one is not finite or is too
    /// large for the format; FileError as checkTarget(), or if the file cannot be written
    void write(const std::filesystem::path& path, std::span<const Point3> positions) const;

    /// The same, with the directions at each point carried by its gradient: normals by
    /// carryNormal(), tangents by carryTangent(). They keep their lengths, but for the rounding of
    /// the format. Where all gradients are the identity and no point has moved, the copy is
    /// identical; three numbers that are no direction, as 0 0 0 or NaN, stay as they are.
    ///
    /// \param gradients one a point
    /// \throws as above; Error if their number is not that of positions(), or if one is not finite
    void write(const std::filesystem::path& path, std::span<const Point3> positions,
               std::span<const DeformationGradient> gradients) const;

protected:
    Model() = default;

private:
    void check(const std::filesystem::path& path, std::span<const Point3> positions) const;

    /// \param gradients one a point, or none: then the directions stay
    virtual void writeChecked(const std::filesystem::path& path, std::span<const Point3> positions,
                              std::span<const DeformationGradient> gradients) const = 0;
};

/// Reads a model in the format that its extension names, in upper or lower case.
/// \throws FileError if the extension is not known, if the file cannot be read or is malformed
/// (naming the line, or the byte in binary data), or if it has no points
ESPALIER_API std::unique_ptr<Model> readModel(const std::filesystem::path& path);

/// The same for a file that is in memory already.
/// \param path names the format, and the file in messages
/// \param bytes the whole file
ESPALIER_API std::unique_ptr<Model> readModel(const std::filesystem::path& path, std::string bytes);

}  // namespace espalier::io

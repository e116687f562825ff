// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/directions.h>
#include <espalier/io/model.h>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "../format.h"
#include "surface_writers.h"

namespace espalier::io {

/// Writes a model in another format: its points, faces and normals. May write any number of files.
class ModelConversion {
public:
    /// Reads the surface of the model.
    ///
    /// \param model, format must outlive the conversion
    /// \param path name of a new file, for messages
    /// \throws FileError if the format lacks a shape of the model, or has no place for points
    ///         without faces; if a face of the model is malformed
    ModelConversion(const Model& model, const Format& format, const std::filesystem::path& path);

    const Format& format() const { return format_; }

    /// Returns the surface of a new file with the points at rest.
    SurfaceView restSurface(const std::filesystem::path& path,
                            std::span<const Point3> points) const;

    /// Returns the points that the new file has, of all points of the model.
    std::vector<Point3> pointsOf(std::span<const Point3> points) const { return valuesOf(points); }

    /// Returns the values at the points that the new file has, of values at all points.
    template <class Value>
    std::vector<Value> valuesOf(std::span<const Value> values) const {
        if (!points_) return {values.begin(), values.end()};
        std::vector<Value> result;
        for (const Index point : *points_) result.push_back(values[point]);
        return result;
    }

    /// Returns one line for the user: the data of the model that the new file lacks, and the
    /// changes. Empty if the new file lacks nothing and nothing is changed.
    std::string losses(const std::filesystem::path& path) const;

    /// Writes a file.
    /// \param positions one per point of the model
    /// \param gradients one per point, and normals are carried; or empty, and they stay
    void write(const std::filesystem::path& path, std::span<const Point3> positions,
               std::span<const DeformationGradient> gradients) const;

private:
    void dropSmallFaces();
    void dropRepeatedPoints();
    void splitIntoTriangles();
    void dropAppearance();
    void moveNormalsToPoints();
    void moveNormalsToCorners();
    void carryNormals(std::span<const DeformationGradient> gradients, std::vector<Point3>& normals,
                      std::vector<Index>& normalCorners) const;

    const Model& model_;
    const Format& format_;
    ModelSurface surface_;                      ///< has the faces and normals of the new file
    std::optional<std::vector<Index>> points_;  ///< the points that are written, if not all are
    std::vector<std::string> changes_;
};

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/io/model.h>

#include <cstddef>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>

namespace espalier::cli {

/// The box around points, along the axes.
struct Extent {
    Point3 least, most;

    /// Returns the lengths of the sides.
    Point3 size() const;
    double diagonal() const;

    /// Returns the extent as the lines "bounds" and "size" of a report.
    std::string text() const;
};

/// \param points at least one
Extent extentOf(std::span<const Point3> points);

/// Returns the report of `info` on a model that was read from `path`:
///
///     model            the path
///     points, faces    their numbers
///     points_in_no_face
///     distinct_points  of an STL: the number of places at which it has points
///     components       parts of the surface that share no point; 0 without faces
///     closed           true if there are faces, and every edge is in exactly two of them
///     boundary_edges   edges in one face
///     nonmanifold_edges
///                      edges in three or more faces
///     bounds, size, diagonal
///                      the box around the points, with sides parallel to the axes
///     precision        how the file stores coordinates: "text", "float", "double" or "integer"
nlohmann::json reportModel(const std::string& path, const io::Model& model);

/// Returns the report as lines of text.
std::string modelText(const nlohmann::json& report);

}  // namespace espalier::cli

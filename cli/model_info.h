// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/bounding_box.h>
#include <espalier/io/model.h>

#include <nlohmann/json.hpp>
#include <string>

namespace espalier::cli {

/// Returns a box as the lines "bounds" and "size" of a report.
std::string boundsText(const BoundingBox& box);

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
///     attributes, groups
///                      names for --weights and --only
///     notes            phrases on parts of the file that are not understood; usually none
///     precision        how the file stores coordinates: "text", "float", "double" or "integer"
nlohmann::json reportModel(const std::string& path, const io::Model& model);

/// Returns the report as lines of text.
std::string modelText(const nlohmann::json& report);

}  // namespace espalier::cli

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/io/model.h>

#include <filesystem>
#include <iosfwd>
#include <span>

namespace espalier::io {

class TextOutput;

/// A surface that is to be written. Its parts must outlive it.
struct SurfaceView {
    std::span<const Point3> points;
    const ModelFaces& faces;
    /// Normals; empty if there are none.
    std::span<const Point3> normals = {};
    /// Per corner of the faces: the number of its normal. Empty if the normals are one per point.
    std::span<const Index> normalCorners = {};
    /// The name of the new file, for a format of several extensions; empty if it has none.
    std::filesystem::path path = {};
    /// Has the texture coordinates, colours and materials of the faces and points; null if there
    /// are none.
    const ModelSurface* appearance = nullptr;
};

// The writers below write a new file. Numbers of text formats are the shortest that read back as
// the same double.

/// Writes `v`, `vn` and `f` statements. If the normals are one per point, a point in no face loses
/// its normal, because only faces name normals.
void writeObjSurface(std::ostream& out, const SurfaceView& surface);

/// Writes an ASCII PLY with coordinates of type double.
/// \param surface its normals, if it has any, are one per point
void writePlySurface(std::ostream& out, const SurfaceView& surface);

/// Writes a binary STL, with coordinates rounded to floats and the normal of each facet.
/// \param surface its faces are triangles; its normals are ignored
/// \throws Error naming the point, if a coordinate exceeds the largest float
void writeStlSurface(std::ostream& out, const SurfaceView& surface);

// The statements of an OBJ, for writers of other data.

void putObjPoints(TextOutput& out, std::span<const Point3> points);

/// Writes an `f` statement.
/// \param textures, normals one per corner, or empty
void putObjFace(TextOutput& out, std::span<const Index> points,
                std::span<const Index> textures = {}, std::span<const Index> normals = {});

}  // namespace espalier::io

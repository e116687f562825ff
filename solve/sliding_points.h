// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/far/simulation_mesh.h>

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// Keeps the points of patches in the plane, cylinder, line or circle that they are on at rest,
// while a pose moves them.
namespace espalier::solve {

/// A surface or a curve on which points of a patch are at rest.
struct SlideShape {
    enum class Kind { Plane, Cylinder, Line, Circle };
    Kind kind = Kind::Plane;

    /// A point of the plane, of the axis of the cylinder or of the line; the centre of the circle.
    Point3 origin = {};

    /// Of length 1: the normal of the plane or of the plane of the circle, or the direction of the
    /// axis or of the line.
    Point3 direction = {};

    double radius = 0;  ///< of the cylinder or of the circle
};

/// Returns "plane", "cylinder", "line" or "circle".
ESPALIER_API std::string_view nameOf(SlideShape::Kind kind);

/// Slides points of patches on the shapes of these patches.
///
/// A patch is divided into pieces: faces or lines that share an edge or an end and turn there by at
/// most 50 degrees, so that eight sides or more are a cylinder. Each piece must be on one shape: a
/// patch of faces on a plane or a cylinder, a patch of lines on a line or a circle. So the four
/// walls of a channel are four planes, and the two sides of a mesh of two dimensions two planes. A
/// point that several pieces share stays on all of their shapes: on the line where two planes meet,
/// and in place in a corner.
///
/// A point is on a shape within a millionth of the size of the piece, or of its largest coordinate
/// if this is larger: files of six digits and of single precision keep no more. A point slides on
/// the shape through its own place at rest: on a parallel plane, or on a cylinder with the same
/// axis. So a point that has not moved stays exactly where it is.
///
/// Immutable; any number of threads may use one at once.
class ESPALIER_API SlidingPoints {
public:
    /// A patch and its shapes. Pieces on one shape have it once.
    struct Patch {
        std::string name;
        std::vector<SlideShape> shapes;
    };

    /// The largest correction of a pose.
    struct Correction {
        double distance = 0;         ///< how far a point would have left its shapes
        std::optional<Index> point;  ///< the point; nothing if no point was corrected
    };

    /// Finds the shapes.
    /// \param patches those whose points slide, of faces or lines. If a patch has neither, its
    ///        points are one piece
    /// \param rest positions of all points at rest
    /// \throws Error naming a patch, the best shape of a piece, and the distance of a point from
    ///         it; Error naming a patch of cells, or a patch with fewer points than determine a
    ///         shape
    /// \cost O(n log n) in the points of the patches
    SlidingPoints(std::span<const far::MeshPatch> patches, std::span<const Point3> rest);

    const std::vector<Patch>& patches() const { return patches_; }

    /// The number of points that slide.
    Index pointCount() const { return static_cast<Index>(points_.size()); }

    /// The first patch with a cylinder or a circle; nothing if there is none. The straight way of a
    /// point from rest to a pose leaves these shapes, but no plane and no line.
    std::optional<std::size_t> curvedPatch() const;

    /// Moves the points that slide to the nearest places of their shapes, to rounding. Of a point
    /// on a cylinder and another shape it is a place on both that is near, if not the nearest.
    /// \param points positions of all points in a pose
    /// \throws Error if `points` does not fit; Error naming a point and its patch that was moved to
    ///         the axis of its cylinder, or that finds no place on all of its shapes
    Correction slide(std::span<Point3> points) const;

private:
    /// A point, its place at rest, and its shapes.
    struct Point {
        Index number;
        std::size_t patch;  ///< the first one that has the point
        Point3 rest;
        std::vector<std::size_t> shapes;
        bool isFixed = false;
    };

    void addShapes(const far::MeshPatch& patch, std::span<const Point3> rest,
                   std::vector<std::vector<std::size_t>>& ofPoints);
    void intersect(Point& point);
    Point3 onShape(const Point& point, const SlideShape& shape, const Point3& place) const;
    Point3 onShapes(const Point& point, const Point3& place) const;

    std::vector<SlideShape> shapes_;
    std::vector<Point> points_;
    std::vector<Patch> patches_;
    std::size_t restCount_ = 0;
};

}  // namespace espalier::solve

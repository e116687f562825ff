// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/far/simulation_mesh.h>
#include <espalier/solve/mesh_quality.h>

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

// Checks that a pose keeps the patches of a mesh whose shape its solver relies on: planes of
// symmetry, wedges, the two sides of a mesh of two dimensions, and pairs of periodic patches.
namespace espalier::solve {

/// The shape that a patch must keep.
enum class Constraint {
    Plane,    ///< a symmetry plane, or the side of a wedge: the points stay in their plane, or in
              ///< their two planes; if a mesh has two wedges, they stay mirror images
    Sides,    ///< "empty": the points stay in their one or two planes, and opposite points opposite
    Periodic  ///< the patch stays the image of its partner, under the motion that maps it at rest
};

/// Returns the constraint of a patch, or nothing. By the type, as OpenFOAM names it: `symmetry`,
/// `symmetryPlane` and `wedge` are planes, `empty` has sides, and types that begin with `cyclic`
/// are periodic if they have a partner; likewise `periodic` and `shadow` of Fluent. As CGNS names
/// it: `BCSymmetryPlane` is a plane. Without a type: a patch with a partner is periodic; a patch of
/// faces or lines with "symm" in its name is a plane.
ESPALIER_API std::optional<Constraint> constraintOf(const far::MeshPatch& patch);

/// The effect of a pose on a constraint patch.
struct PatchDeviation {
    std::size_t patch = 0;  ///< its number among the patches
    Constraint constraint = Constraint::Plane;

    /// The largest distance of a point from where the constraint has it, less the same distance at
    /// rest; and the point.
    double distance = 0;
    Index point = 0;

    /// True if this is the distance from the image of another point: of the mirror image in a
    /// wedge, the opposite point of a side, or the partner. False if it is the distance from a
    /// plane.
    bool isFromImage = false;

    /// True if the distance is above 1e-10 of the size of the mesh, and above 8 units of rounding
    /// of the largest coordinate.
    bool isBroken = false;
};

/// Checks the constraint patches of a mesh.
/// Immutable; any number of threads may use one at once.
class ESPALIER_API ConstraintPatches {
public:
    /// Finds the planes and the pairs of points at rest.
    /// \param patches all patches of the mesh
    /// \param rest positions of the points of the mesh at rest; copied
    /// \cost O(n log n) in the points of the patches
    ConstraintPatches(std::span<const far::MeshPatch> patches, std::span<const Point3> rest);

    /// The patches, by number, that have a constraint and do not fulfil it at rest, within 1e-6 of
    /// the size of the mesh: points out of their plane, or without a partner. They are not checked.
    const std::vector<std::size_t>& brokenAtRest() const { return brokenAtRest_; }

    /// Returns the deviations of all constraint patches that are fulfilled at rest, in their order.
    /// \param points positions of all points in a pose
    /// \throws Error if `points` does not fit
    std::vector<PatchDeviation> check(std::span<const Point3> points) const;

    /// Returns the faces of OpenFOAM's `cyclic` patches that are fulfilled at rest, for
    /// meshQuality(). checkMesh couples no others: the faces of `cyclicAMI` have no single image.
    /// \param patches those of the constructor
    std::vector<CoupledFace> coupledFaces(std::span<const far::MeshPatch> patches) const;

private:
    /// The points of a patch in one plane.
    struct Plane {
        Point3 origin, normal;
        std::vector<Index> points;
    };
    /// A point and its image.
    struct Pair {
        Index point, image;
    };
    struct Checked {
        std::size_t patch;
        Constraint constraint;
        std::vector<Plane> planes = {};
        std::vector<Pair> pairs = {};
        /// The motion of a periodic pair, or the mirroring of a wedge: x → axes · (x − from) + to.
        std::array<Point3, 3> axes = {};
        Point3 from = {}, to = {};
    };

    bool findPlanes(const far::MeshPatch& patch, Checked& checked) const;
    void fitPlane(Plane& plane) const;
    bool pairSides(Checked& checked, const Plane& front, const Plane& back) const;
    bool pairWedges(Checked& checked, const Plane& other) const;
    void pairPlanes(std::span<const far::MeshPatch> patches);
    bool findMotion(const far::MeshPatch& patch, const far::MeshPatch& partner,
                    Checked& checked) const;
    template <class Visit>
    void forEachDistance(const Checked& checked, std::span<const Point3> points, Visit visit) const;

    std::vector<Point3> rest_;
    double size_ = 0;
    double rounding_ = 0;  ///< of coordinates
    std::vector<Checked> checked_;
    std::vector<std::size_t> brokenAtRest_;
};

}  // namespace espalier::solve

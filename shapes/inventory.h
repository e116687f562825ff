// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/base/word.h>
#include <espalier/far/topology_error.h>
#include <espalier/shapes/lattice.h>
#include <espalier/shapes/section.h>

#include <array>
#include <vector>

/// \file
/// Makes ready lattices from a few numbers: box, cylinder, torus, star, barbell and arm (MacCracken
/// & Joy 1996, section 5). Each lattice is valid, without duplicate vertices, and its cells have
/// positive volume. Vertices and cells are numbered as by sweep(), layer by layer. The topology
/// depends only on the integer and enum fields: two sets of options that differ only in lengths and
/// positions give two poses of one lattice.
///
/// Every function throws ArgumentError for the first field out of range, and far::TopologyError if
/// there would be too many entities for an Index.
namespace espalier::shapes {

/// A box of hexahedra (figure 1, left). Vertex (i, j, k) is i + (cells[0] + 1) (j + (cells[1] + 1)
/// k); cell (i, j, k) likewise.
struct BoxOptions {
    std::array<int, 3> cells = {1, 1, 1};  ///< along x, y and z: 1 or more each
    Point3 min = {0, 0, 0};
    Point3 max = {1, 1, 1};  ///< above min in each coordinate
};
ESPALIER_API Lattice box(const BoxOptions& options = {});

/// A disk swept along an axis (figures 1 and 5, right). With the default core the cells at the axis
/// are wedges, and `sectors` of them meet there.
struct CylinderOptions {
    int sectors = 8;  ///< sides of the disk: 3 or more
    DiskPattern pattern = {};
    int layers = 1;           ///< 1 or more
    double radius = 1;        ///< distance of the outermost vertices from the axis, above 0
    Point3 from = {0, 0, 0};  ///< centre of the first end
    Point3 to = {0, 0, 1};    ///< centre of the last end; must differ from `from`
};
ESPALIER_API Lattice cylinder(const CylinderOptions& options = {});

enum class TorusSection { Grid, Disk };
inline constexpr Word<TorusSection> kTorusSectionWords[] = {{"grid", TorusSection::Grid},
                                                            {"disk", TorusSection::Disk}};

/// A cross-section swept around the z axis, with the centre at the origin.
struct TorusOptions {
    int segments = 8;  ///< cells around the ring: 3 or more
    TorusSection section = TorusSection::Grid;
    int gridCells = 1;         ///< Grid: cells along each side of the square, 1 or more
    int sides = 6;             ///< Disk: 3 or more
    DiskPattern pattern = {};  ///< Disk
    double majorRadius = 1;    ///< radius of the circle along which the section is swept
    double minorRadius = 0.4;  ///< half the side of the square, or the radius of the disk: above 0
                               ///< and below majorRadius
};
ESPALIER_API Lattice torus(const TorusOptions& options = {});

/// A flat star (figure 7): a disk in the plane z = 0, thickened to both sides. Its outermost
/// vertices alternate between outerRadius and innerRadius; the first is on the +x axis. With equal
/// radii it is the round rest pose of the same lattice.
struct StarOptions {
    int points = 5;  ///< 2 or more
    DiskPattern pattern = {};
    int layers = 1;            ///< 1 or more
    double innerRadius = 0.5;  ///< above 0
    double outerRadius = 1;    ///< above 0
    double height = 0.25;      ///< above 0
};
ESPALIER_API Lattice star(const StarOptions& options = {});

/// Two ends joined by a bar along x (figure 8): a mesh in the plane z = 0, thickened to both sides.
///
/// With roundness = 0, barHalfWidth = endRadius and endSegments a multiple of 3, it is a
/// rectangular block of barLength + 4 endRadius by 2 endRadius: the rest pose for a barbell of the
/// same topology.
struct BarbellOptions {
    int endSegments = 6;       ///< edges around an end, without the edges at the bar: 3 or more
    int barSegments = 2;       ///< cells along the bar: 1 or more
    int barAcross = 2;         ///< cells across the bar: 1 or more
    DiskPattern pattern = {};  ///< pattern of the ends
    int layers = 1;            ///< 1 or more
    double endRadius = 1;      ///< radius of a round end, or half the side of a square one: above 0
    double barLength = 2;      ///< distance between the ends: above 0
    double barHalfWidth = 0.4;  ///< above 0, at most endRadius; below it if roundness is 1
    double roundness = 1;       ///< shape of the ends: from 0, square, to 1, round
    double height = 0.5;        ///< above 0
};
ESPALIER_API Lattice barbell(const BarbellOptions& options = {});

/// A point of the polyline that an arm is built around.
struct ArmJoint {
    Point3 position = {0, 0, 0};
    double radius = 0.2;  ///< radius of the cross-section, above 0
    double twist = 0;     ///< rotation of the cross-section about the limb: radians, anticlockwise
                          ///< when looking back from the end of the limb
};

/// A tube around a limb (figure 9): shoulder, elbow, wrist, hand. Other positions and twists give a
/// pose of the same lattice.
///
/// Cross-sections are disks. At a joint the disk lies in the plane that bisects the two bones, and
/// is stretched across the bend so that the tube keeps its thickness (for bends up to a right
/// angle; beyond, the stretch does not grow). Between joints, position, radius, twist and plane
/// change linearly. The smallest rotation carries the frame from bone to bone, so that it never
/// flips, and the tube has no twist except the twist of the joints.
///
/// On the inner side of a bend the tube is shorter than the bones. For each bone, add the radius
/// times the tangent of half the bend at both of its ends. If the sum exceeds the length of the
/// bone, the sections cross and cells turn inside out.
struct ArmOptions {
    /// 2 or more joints; neighbours must differ, and the polyline must not turn back on itself.
    std::vector<ArmJoint> joints = {
        {{0, 0, 0}, 0.3, 0}, {{1, 0, 0}, 0.25, 0}, {{2, 0, 0}, 0.2, 0}, {{2.5, 0, 0}, 0.2, 0}};
    int segments = 2;  ///< cells from joint to joint: 1 or more
    int sides = 4;     ///< sides of the cross-section: 3 or more
    DiskPattern pattern = {1, Core::Polygon};
    /// Direction from the first bone to the first vertex of the cross-section. It must not be
    /// parallel to that bone, and must be the same for all poses of a lattice.
    Point3 up = {0, 0, 1};
};
ESPALIER_API Lattice arm(const ArmOptions& options = {});

}  // namespace espalier::shapes

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
/// The inventory of lattices (MacCracken & Joy 1996, section 5). Each is valid, has no vertex
/// twice, and cells of positive volume; vertex and cell numbers are those of sweep(), layer by
/// layer. The topology depends on the integer and enum fields alone: two sets of options that
/// differ in lengths and positions only give two poses of one lattice.
///
/// Every function throws Error naming the first field out of range, its value and what is allowed,
/// and far::TopologyError if there would be more entities than an Index counts.
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
    double radius = 1;        ///< of the outermost vertices, above 0
    Point3 from = {0, 0, 0};  ///< the centre of the first end
    Point3 to = {0, 0, 1};    ///< the centre of the last end, elsewhere
};
ESPALIER_API Lattice cylinder(const CylinderOptions& options = {});

enum class TorusSection { Grid, Disk };
inline constexpr Word<TorusSection> kTorusSectionWords[] = {{"grid", TorusSection::Grid},
                                                            {"disk", TorusSection::Disk}};

/// A cross-section swept round the z axis, about the origin.
struct TorusOptions {
    int segments = 8;  ///< cells round the ring: 3 or more
    TorusSection section = TorusSection::Grid;
    int gridCells = 1;         ///< Grid: cells along each side of the square, 1 or more
    int sides = 6;             ///< Disk: 3 or more
    DiskPattern pattern = {};  ///< Disk
    double majorRadius = 1;    ///< of the circle that the section is swept along
    double minorRadius = 0.4;  ///< half the side of the square, or the radius of the disk: above 0
                               ///< and below majorRadius
};
ESPALIER_API Lattice torus(const TorusOptions& options = {});

/// A flat star (figure 7): a disk in the plane z = 0, thickened to both sides, whose outermost
/// vertices are at outerRadius and innerRadius by turns, the first on the +x axis. With equal radii
/// it is the round rest pose of the same lattice.
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
/// With roundness = 0, barHalfWidth = endRadius and endSegments a multiple of 3 it is a rectangular
/// block of barLength + 4 endRadius by 2 endRadius: the rest pose for a barbell of the same
/// topology.
struct BarbellOptions {
    int endSegments = 6;        ///< edges round an end, apart from those at the bar: 3 or more
    int barSegments = 2;        ///< cells along the bar: 1 or more
    int barAcross = 2;          ///< cells across the bar: 1 or more
    DiskPattern pattern = {};   ///< of the ends
    int layers = 1;             ///< 1 or more
    double endRadius = 1;       ///< of a round end, or half the side of a square one: above 0
    double barLength = 2;       ///< from end to end: above 0
    double barHalfWidth = 0.4;  ///< above 0, at most endRadius; below it if roundness is 1
    double roundness = 1;       ///< of the ends: from 0, square, to 1, round
    double height = 0.5;        ///< above 0
};
ESPALIER_API Lattice barbell(const BarbellOptions& options = {});

/// A point of the polyline that an arm is built around.
struct ArmJoint {
    Point3 position = {0, 0, 0};
    double radius = 0.2;  ///< of the cross-section, above 0
    double twist = 0;     ///< of the cross-section about the limb: radians, anticlockwise looking
                          ///< back from the end of the limb
};

/// A tube round a limb (figure 9): shoulder, elbow, wrist, hand. Other positions and twists give a
/// pose of the same lattice.
///
/// Cross-sections are disks. At a joint the disk lies in the plane that bisects the two bones, and
/// is stretched across the bend so that the tube keeps its thickness (up to a bend of a right
/// angle; the stretch grows no further beyond). Between joints, position, radius, twist and plane
/// go over from one to the next linearly. The frame is carried from bone to bone by the smallest
/// rotation, so that it never flips and no twist comes in but that of the joints.
///
/// On the inner side of a bend the tube is shorter than the bones. Where the radius times the
/// tangent of half the bend exceeds a bone, counting the bends at both of its ends, the sections
/// cross and cells turn inside out.
struct ArmOptions {
    /// 2 or more, each away from the next; the polyline does not turn back on itself.
    std::vector<ArmJoint> joints = {
        {{0, 0, 0}, 0.3, 0}, {{1, 0, 0}, 0.25, 0}, {{2, 0, 0}, 0.2, 0}, {{2.5, 0, 0}, 0.2, 0}};
    int segments = 2;  ///< cells from joint to joint: 1 or more
    int sides = 4;     ///< of the cross-section: 3 or more
    DiskPattern pattern = {1, Core::Polygon};
    /// The side of the first bone on which the first vertex of the cross-section is. Not along that
    /// bone; the same for all poses of a lattice.
    Point3 up = {0, 0, 1};
};
ESPALIER_API Lattice arm(const ArmOptions& options = {});

}  // namespace espalier::shapes

// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>
#include <espalier/shapes/extrude.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/transform.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "checks.h"

namespace espalier::shapes {
namespace {

/// The x and y axes of the cross-section at a place of the limb, before twist and radius. They are
/// perpendicular unit vectors, except at a bend, where the cross-section is stretched.
struct Frame {
    Point3 x;
    Point3 y;
};

void check(const ArmOptions& options) {
    requireAtLeast("arm", "segments", options.segments, 1);
    requireAtLeast("arm", "sides", options.sides, 3);
    requireAtLeast("arm", "rings", options.pattern.rings, 1);
    requireFinite("arm", "up", options.up);
    if (options.joints.size() < 2)
        throw ArgumentError("arm", "joints", std::to_string(options.joints.size()), "2 or more");
    for (std::size_t i = 0; i < options.joints.size(); ++i) {
        const ArmJoint& joint = options.joints[i];
        requireFinite("arm", indexed("joints", i) + ".position", joint.position);
        requirePositive("arm", indexed("joints", i) + ".radius", joint.radius);
        requireFinite("arm", indexed("joints", i) + ".twist", joint.twist);
        if (i > 0 && !isFinite(difference(joint.position, options.joints[i - 1].position)))
            throw ArgumentError("arm", indexed("joints", i) + ".position", textOf(joint.position),
                                "a place at a finite distance from the joint before");
        if (i > 0 && joint.position == options.joints[i - 1].position)
            throw ArgumentError("arm", indexed("joints", i) + ".position", textOf(joint.position),
                                "a place other than the one of the joint before");
    }
}

/// Returns the unit directions of the bones.
std::vector<Point3> boneDirections(const std::vector<ArmJoint>& joints) {
    std::vector<Point3> directions;
    for (std::size_t i = 0; i + 1 < joints.size(); ++i)
        directions.push_back(normalised(difference(joints[i + 1].position, joints[i].position)));
    return directions;
}

Frame firstFrame(const Point3& direction, const Point3& up) {
    const Point3 upNearOne = scaledNearOne(up);
    const Point3 across = difference(upNearOne, scaled(direction, dot(upNearOne, direction)));
    // If `up` is nearer to the bone, its part across the bone is mostly rounding.
    if (!(length(across) > 1e-6 * length(upNearOne)))
        throw ArgumentError("arm", "up", textOf(up),
                            "a vector that is not along the first bone " + textOf(direction));
    const Point3 x = normalised(across);
    return {x, cross(direction, x)};
}

/// Returns the frame in the plane that bisects two bones: the frame of the first bone, rotated half
/// way to the second, and stretched across the bend.
Frame bisectingFrame(const Frame& frame, const Point3& before, const Point3& after) {
    const Point3 normal = normalised(sum(before, after));
    const Affine half = rotationBetween(before, normal);
    Frame turned = {half(frame.x), half(frame.y)};
    const Point3 axis = cross(before, after);
    if (!(length(axis) > 0)) return turned;
    const Point3 acrossBend = cross(normal, normalised(axis));
    const double stretch = std::min(1 / dot(before, normal), std::numbers::sqrt2);
    for (Point3* side : {&turned.x, &turned.y})
        *side = sum(*side, scaled(acrossBend, (stretch - 1) * dot(*side, acrossBend)));
    return turned;
}

/// Returns the frame at each joint.
std::vector<Frame> jointFrames(const ArmOptions& options) {
    const std::vector<Point3> bones = boneDirections(options.joints);
    Frame carried = firstFrame(bones.front(), options.up);
    std::vector<Frame> frames = {carried};
    for (std::size_t i = 1; i < bones.size(); ++i) {
        // -0.99984 is cos 179°. Beyond it, the plane of the bend is lost in rounding.
        if (dot(bones[i - 1], bones[i]) < -0.99984)
            throw ArgumentError("arm", indexed("joints", i) + ".position",
                                textOf(options.joints[i].position),
                                "a place at which the limb bends by less than 179 degrees");
        frames.push_back(bisectingFrame(carried, bones[i - 1], bones[i]));
        const Affine turn = rotationBetween(bones[i - 1], bones[i]);
        carried = {turn(carried.x), turn(carried.y)};
    }
    frames.push_back(carried);
    return frames;
}

/// Returns the map that takes the unit cross-section to the place at fraction t between two joints.
Affine station(const ArmJoint& a, const Frame& frameA, const ArmJoint& b, const Frame& frameB,
               double t) {
    const Point3 x = between(frameA.x, frameB.x, t);
    const Point3 y = between(frameA.y, frameB.y, t);
    const double radius = std::lerp(a.radius, b.radius, t);
    const double twist = std::lerp(a.twist, b.twist, t);
    const Point3 sideX =
        scaled(sum(scaled(x, std::cos(twist)), scaled(y, std::sin(twist))), radius);
    const Point3 sideY =
        scaled(sum(scaled(y, std::cos(twist)), scaled(x, -std::sin(twist))), radius);
    const Point3 along = cross(x, y);
    Affine station = translation(between(a.position, b.position, t));
    for (std::size_t row = 0; row < 3; ++row)
        station.linear[row] = {sideX[row], sideY[row], along[row]};
    return station;
}

}  // namespace

Lattice arm(const ArmOptions& options) {
    check(options);
    const std::vector<ArmJoint>& joints = options.joints;
    requireCountable("arm", {static_cast<Offset>(joints.size() - 1), options.segments,
                             options.sides, options.pattern.rings, 6});
    const std::vector<Frame> frames = jointFrames(options);
    std::vector<Affine> stations = {station(joints[0], frames[0], joints[1], frames[1], 0)};
    for (std::size_t i = 0; i + 1 < joints.size(); ++i)
        for (int segment = 1; segment <= options.segments; ++segment)
            stations.push_back(station(joints[i], frames[i], joints[i + 1], frames[i + 1],
                                       static_cast<double>(segment) / options.segments));
    return sweep(diskMesh(regularPolygon(options.sides, 1), {0, 0, 0}, options.pattern), stations);
}

}  // namespace espalier::shapes

// SPDX-License-Identifier: Apache-2.0
#include "boundary_forces.h"

#include <espalier/base/bounding_box.h>
#include <espalier/base/parallel.h>
#include <espalier/base/vector3.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace espalier::cages {
namespace {

/// Weight of the squared distance, in edges, of the surface from the points.
constexpr double kPull = 1;

/// Weight of the squared distance, in edges, by which a point sticks out.
constexpr double kPush = 1000;

/// Faces that points push are at most this far away, in cubes of the points.
constexpr Index kPushRings = 3;

/// Least cosine between the normals of a face and of the points that it is fitted to.
constexpr double kFacing = -0.5;

/// If at least this many groups have no proof, all clearances grow, so that points do not stick out
/// in turns. With fewer groups, they grow less.
constexpr double kManyFailures = 16;

/// Lists, for each cell, the cells that are close to it in space but not along the lattice: their
/// parts of the model are apart. In a full grid the number of faces between two cells is at most √3
/// times their distance in edges.
std::vector<std::vector<Index>> cellsApart(const Lattice& start, double edge) {
    constexpr double kNear = 5;   // edges
    constexpr int kMaxSteps = 9;  // more than √3 · kNear
    const far::CellComplex& complex = start.complex;
    std::vector<Point3> centres;
    for (Index cell = 0; cell < complex.count(3); ++cell) {
        std::vector<Point3> corners;
        for (const Index vertex : complex.relation(3, 0)[cell])
            corners.push_back(start.positions[vertex]);
        centres.push_back(mean(corners));
    }
    std::vector<std::vector<Index>> apart(centres.size());
    std::vector<int> steps(centres.size(), -1);
    std::vector<Index> reached;
    for (std::size_t a = 0; a < centres.size(); ++a) {
        reached = {static_cast<Index>(a)};
        steps[a] = 0;
        for (std::size_t i = 0; i < reached.size() && steps[reached[i]] < kMaxSteps; ++i)
            for (const Index face : complex.relation(3, 2)[reached[i]])
                for (const Index next : complex.relation(2, 3)[face])
                    if (steps[next] < 0) {
                        steps[next] = steps[reached[i]] + 1;
                        reached.push_back(next);
                    }
        for (std::size_t b = 0; b < centres.size(); ++b) {
            const double distance = length(difference(centres[a], centres[b])) / edge;
            if (distance > kNear) continue;
            if (steps[b] < 0 || steps[b] > std::sqrt(3) * distance + 0.5)
                apart[a].push_back(static_cast<Index>(b));
        }
        for (const Index cell : reached) steps[cell] = -1;
    }
    return apart;
}

}  // namespace

BoundaryForces::BoundaryForces(const CageSurface& surface, const PointGroups& groups,
                               const Lattice& start, double edge, double margin)
    : surface_(surface),
      groups_(groups),
      edge_(edge),
      margin_(margin),
      apart_(cellsApart(start, edge)) {}

void BoundaryForces::reset(double pull) {
    const std::size_t count = groups_.groups().size();
    clearance_.assign(count, margin_ + 0.01 * edge_);
    distanceToOthers_.assign(count, margin_ + 0.03 * edge_);
    pushFactor_.assign(count, 1.0);
    failures_.assign(count, 0);
    isRaised_.assign(count, 0);
    pullFactor_.assign(surface_.coarseCentres().rowCount(), pull);
}

/// Returns true if a group of points belongs to the part of the model that a cell holds.
bool BoundaryForces::belongs(Index group, Index cell) const {
    const auto of = groups_.groups()[group].cell;
    return !of || !std::ranges::binary_search(apart_[cell], *of);
}

/// Returns true if a face with this normal is fitted to a group of points. It may not face the
/// other way, as the far side of a thin part does, or the boundary of another part.
bool BoundaryForces::suits(Index group, Index cell, const Point3& normal) const {
    return !groups_.groups()[group].isInner &&
           dot(groups_.groups()[group].normal, normal) > kFacing && belongs(group, cell);
}

void BoundaryForces::match(std::span<const Point3> positions) {
    const std::vector<Point3> fine = surface_.fineVertices(positions);
    const std::span<const std::array<Index, 4>> faces = surface_.fineFaces().loops;
    std::vector<Point3> centres(faces.size()), normals(faces.size());
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const auto& face = faces[f];
        centres[f] =
            scaled(sum(sum(fine[face[0]], fine[face[1]]), sum(fine[face[2]], fine[face[3]])), 0.25);
        normals[f] = cross(difference(fine[face[2]], fine[face[0]]),
                           difference(fine[face[3]], fine[face[1]]));
    }
    for (Point3& normal : normals) {
        const double size = length(normal);
        normal = size > 0 ? scaled(normal, 1 / size) : Point3{0, 0, 0};
    }
    measureDepths(fine, centres, normals);
    matchPulls(centres, normals);
    matchPushes(centres, normals);
}

/// Finds out how far the hulls of each face of level 3 reach inwards of its centre, so that a face
/// is as near to the points as the proof allows: hardly apart where the boundary is flat.
void BoundaryForces::measureDepths(std::span<const Point3> fine, const std::vector<Point3>& centres,
                                   const std::vector<Point3>& normals) {
    const double deepest = 0.1 * edge_;  // deeper hulls are of faces that are still folded
    depths_.assign(centres.size(), 0);
    const auto deepen = [&](Index f, std::span<const Index> hull, std::span<const Point3> points) {
        for (const Index vertex : hull) {
            const double depth = dot(normals[f], difference(centres[f], points[vertex]));
            depths_[f] = std::max(depths_[f], std::min(depth, deepest));
        }
    };
    for (Index f = 0; f < std::ssize(centres); ++f) deepen(f, surface_.fineFaces().loops[f], fine);
    const std::vector<Point3> finest = surface_.finestVertices(fine);
    const CageSurface::Faces& finestFaces = surface_.finestFaces();
    for (Index f = 0; f < std::ssize(finestFaces.loops); ++f)
        deepen(surface_.fineFaceOf(f), finestFaces.hull(f), finest);
}

/// Pulls each face of level 2 towards the nearest points.
void BoundaryForces::matchPulls(const std::vector<Point3>& centres,
                                const std::vector<Point3>& normals) {
    const double unit = 1 / (edge_ * edge_);
    std::vector<Point3> coarseCentres(pullFactor_.size(), {0, 0, 0}),
        coarseNormals(pullFactor_.size(), {0, 0, 0});
    std::vector<double> coarseDepths(pullFactor_.size(), 0);
    for (std::size_t f = 0; f < centres.size(); ++f) {
        const Index coarse = surface_.coarseFaceOf(static_cast<Index>(f));
        coarseNormals[coarse] = sum(coarseNormals[coarse], normals[f]);
        coarseDepths[coarse] += 0.25 * depths_[f];
        coarseCentres[coarse] = sum(coarseCentres[coarse], scaled(centres[f], 0.25));
    }
    const auto groups = groups_.groups();
    pulls_.assign(pullFactor_.size(), {});
    parallelFor(std::ssize(pulls_), 64, [&](Offset first, Offset last) {
        for (Offset c = first; c < last; ++c) {
            PlaneTerm& term = pulls_[c];
            term.row = static_cast<Index>(c);
            const double size = length(coarseNormals[c]);
            if (!(size > 0)) continue;
            const Point3 normal = scaled(coarseNormals[c], 1 / size);
            const Index cell = surface_.cellOfCoarse(term.row);
            const auto nearest = groups_.nearest(
                coarseCentres[c], 24, [&](Index group) { return suits(group, cell, normal); });
            if (!nearest) continue;
            const auto& group = groups[*nearest];
            Point3 way = difference(coarseCentres[c], group.centre);
            const double distance = length(way);
            // Near the points, the direction to one of them means little.
            const double trust = std::clamp(distance / groups_.grid().size - 1, 0.0, 1.0);
            if (dot(way, normal) > 0 && distance > 0)
                way = sum(scaled(way, trust / distance), scaled(normal, 1 - trust));
            else
                way = normal;
            term.direction = normalised(way);
            term.offset = dot(term.direction, groups_.farthest(group, term.direction)) +
                          clearance_[*nearest] + coarseDepths[c];
            if (isRaised_[*nearest]) pullFactor_[c] *= 0.8;
            term.outside = kPull * unit / 16 * pullFactor_[c];
            term.inside = 0;
            term.reach = 0.25 * edge_;
        }
    });
}

/// Returns the face of level 3 with the nearest centre, of those with accept(face); none if there
/// is none within `rings` rings of cubes.
template <class Accept>
std::optional<Index> BoundaryForces::nearestFace(const Point3& point, Index rings,
                                                 const std::vector<Point3>& centres,
                                                 Accept accept) const {
    const auto place = groups_.grid().coordinatesOf(point);
    double least = 0;
    std::optional<Index> best;
    for (Index ring = 0; ring <= rings; ++ring) {
        const double reach = (ring - 1) * groups_.grid().size;
        if (best && reach > 0 && reach * reach > least) break;
        groups_.grid().forEachInRing(place, ring, [&](Index cube) {
            for (Index f = firstOfCube_[cube]; f >= 0; f = nextOfFace_[f]) {
                const Point3 way = difference(centres[f], point);
                const double distance = dot(way, way);
                if (best && (distance > least || (distance == least && f > *best))) continue;
                if (!accept(f)) continue;
                best = f;
                least = distance;
            }
        });
    }
    return best;
}

/// Pushes the nearest face of level 3 of each group of points outwards. If several groups are
/// nearest to one face, the one that sticks out most counts. Pushes faces of other parts away from
/// the group.
void BoundaryForces::matchPushes(const std::vector<Point3>& centres,
                                 const std::vector<Point3>& normals) {
    const double unit = 1 / (edge_ * edge_);
    const auto groups = groups_.groups();
    const auto faceCount = static_cast<Index>(centres.size());
    firstOfCube_.assign(groups_.grid().cubeCount(), -1);
    nextOfFace_.assign(faceCount, -1);
    for (Index f = faceCount; f-- > 0;) {
        Index& first = firstOfCube_[groups_.grid().cubeOf(centres[f])];
        nextOfFace_[f] = first;
        first = f;
    }
    const std::vector<Index>& cells = surface_.fineFaces().cells;
    std::vector<BoundingBox> facesOf(apart_.size());  // boxes around the faces of each cell
    for (Index f = 0; f < faceCount; ++f) facesOf[cells[f]].include(centres[f]);
    const double reach = kPushRings * groups_.grid().size;
    const auto isNear = [&](Index group, Index cell) {
        for (int axis = 0; axis < 3; ++axis)
            if (facesOf[cell].min[axis] > groups[group].high[axis] + reach ||
                facesOf[cell].max[axis] < groups[group].low[axis] - reach)
                return false;
        return true;
    };
    std::vector<std::optional<Index>> own(groups.size()), other(groups.size());
    parallelFor(std::ssize(groups), 256, [&](Offset first, Offset last) {
        for (Offset g = first; g < last; ++g) {
            const auto group = static_cast<Index>(g);
            if (groups[g].isInner) continue;
            own[g] = nearestFace(groups[g].centre, kPushRings, centres,
                                 [&](Index f) { return suits(group, cells[f], normals[f]); });
            if (!groups[g].cell) continue;
            const std::vector<Index>& apart = apart_[*groups[g].cell];
            if (std::any_of(apart.begin(), apart.end(),
                            [&](Index cell) { return isNear(group, cell); }))
                other[g] = nearestFace(groups[g].centre, kPushRings, centres,
                                       [&](Index f) { return !belongs(group, cells[f]); });
        }
    });
    distance_.assign(groups.size(), 0);
    std::vector<double> leastOf(faceCount, 0.25 * edge_), leastOfOther = leastOf;
    std::vector<PlaneTerm> terms(faceCount), termsOfOther(faceCount);
    for (std::size_t g = 0; g < groups.size(); ++g) {
        if (const auto f = own[g]) {
            const Point3& normal = normals[*f];
            const double offset =
                dot(normal, groups_.farthest(groups[g], normal)) + clearance_[g] + depths_[*f];
            const double distance = dot(normal, centres[*f]) - offset;
            distance_[g] = distance;
            if (distance < leastOf[*f]) {
                leastOf[*f] = distance;
                terms[*f] = {*f, normal,      offset, kPush * pushFactor_[g] * unit / 64,
                             0,  0.05 * edge_};
            }
        }
        if (const auto f = other[g]) {
            const Point3 inwards = scaled(normals[*f], -1);
            const double offset =
                dot(inwards, groups_.farthest(groups[g], inwards)) + distanceToOthers_[g];
            const double distance = dot(inwards, centres[*f]) - offset;
            if (distance < leastOfOther[*f]) {
                leastOfOther[*f] = distance;
                termsOfOther[*f] = {*f, inwards, offset, kPush * unit / 64, 0, 0.05 * edge_};
            }
        }
    }
    pushes_.clear();
    for (const auto* list : {&terms, &termsOfOther})
        for (const PlaneTerm& term : *list)
            if (term.inside > 0) pushes_.push_back(term);
}

void BoundaryForces::addEnergy(std::span<const Point3> positions, double& energy,
                               std::span<Point3> gradient) const {
    energy += evaluatePlanes(surface_.coarseCentres(), pulls_, positions, gradient);
    energy += evaluatePlanes(surface_.fineCentres(), pushes_, positions, gradient);
}

void BoundaryForces::strengthen(std::span<const Uncovered> uncovered) {
    std::vector<double> raises(groups_.groups().size(), 0);
    for (const Uncovered& group : uncovered) {
        // A point that another part of the lattice covers, or nearly so.
        if (group.winding > 1 || (group.cell && !belongs(group.group, *group.cell))) {
            double& distance = distanceToOthers_[group.group];
            distance = std::min(distance + 0.01 * edge_, margin_ + 0.25 * edge_);
            continue;
        }
        if (distance_[group.group] < -0.02 * edge_)
            pushFactor_[group.group] = std::min(2 * pushFactor_[group.group], 64.0);
        // A group that fails again rises further each time.
        const int times = ++failures_[group.group];
        const double more = std::min(
            times * (std::min(1.1 * group.depth, 0.05 * edge_) + 0.003 * edge_), 0.06 * edge_);
        const auto place = groups_.grid().coordinatesOf(groups_.groups()[group.group].centre);
        for (Index ring = 0; ring <= 2; ++ring)
            groups_.grid().forEachInRing(place, ring, [&](Index cube) {
                groups_.forEachInCube(cube, [&](Index near) {
                    raises[near] = std::max(raises[near], more * (1 - 0.25 * ring));
                });
            });
    }
    const double raiseOfAll =
        0.003 * edge_ * std::min(1.0, static_cast<double>(uncovered.size()) / kManyFailures);
    for (std::size_t g = 0; g < raises.size(); ++g) {
        const double more = std::max(raises[g], raiseOfAll);
        clearance_[g] = std::min(clearance_[g] + more, margin_ + 0.25 * edge_);
        if (raises[g] > 0) isRaised_[g] = 1;
    }
}

void BoundaryForces::weakenPulls(std::span<const char> isChosen, double factor) {
    for (std::size_t c = 0; c < pullFactor_.size(); ++c)
        if (isChosen[surface_.cellOfCoarse(static_cast<Index>(c))] != 0) pullFactor_[c] *= factor;
}

}  // namespace espalier::cages

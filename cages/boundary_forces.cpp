// SPDX-License-Identifier: Apache-2.0
#include "boundary_forces.h"

#include <espalier/base/bounding_box.h>
#include <espalier/base/parallel.h>
#include <espalier/base/progress.h>
#include <espalier/base/vector3.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <optional>
#include <utility>

namespace espalier::cages {
namespace {

/// Weight of the squared distance, in edges, of the surface from the points.
constexpr double kPull = 1;

/// Weight of the squared distance, in edges, by which a point sticks out.
constexpr double kPush = 1000;

/// Points that pull a face are at most this far away, in cubes of the points.
constexpr Index kPullRings = 24;

/// Faces that points push are at most this far away, in cubes of the points.
constexpr Index kPushRings = 3;

/// Each attempt to prove multiplies by this the pulls towards points without proof, now or before,
/// and towards points near them.
constexpr double kFade = 0.4;

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
        checkCancelledEvery(a, 4);
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

/// Returns true if two boxes are at most `reach` apart along each axis.
bool areNear(const BoundingBox& a, const BoundingBox& b, double reach) {
    for (int axis = 0; axis < 3; ++axis)
        if (a.min[axis] > b.max[axis] + reach || a.max[axis] < b.min[axis] - reach) return false;
    return true;
}

}  // namespace

BoundaryForces::BoundaryForces(const CageSurface& surface, const PointGroups& groups,
                               const Lattice& start, double edge, double margin)
    : surface_(surface),
      groups_(groups),
      edge_(edge),
      margin_(margin),
      apart_(cellsApart(start, edge)),
      groupsOf_(apart_.size()) {
    for (const PointGroups::Group& group : groups.groups()) {
        if (!group.cell) continue;
        groupsOf_[*group.cell].include(group.bounds.min);
        groupsOf_[*group.cell].include(group.bounds.max);
    }
}

void BoundaryForces::reset(double pull) {
    const std::size_t count = groups_.groups().size();
    clearance_.assign(count, margin_ + 0.01 * edge_);
    distanceToOthers_.assign(count, margin_ + 0.03 * edge_);
    pushFactor_.assign(count, 1.0);
    failures_.assign(count, 0);
    isRaised_.assign(count, 0);
    pullFactor_.assign(surface_.coarseCentres().rowCount(), pull);
}

/// Returns true if points of one cell belong to the part of the model that another cell holds. A
/// face of that cell is fitted to no other points.
bool BoundaryForces::belongs(std::optional<Index> cellOfPoints, Index cell) const {
    return !cellOfPoints || !std::ranges::binary_search(apart_[cell], *cellOfPoints);
}

/// Returns true if a group of points faces about as a face does that may be fitted to the group.
/// The far side of a thin part faces the other way, and so does the boundary of another part.
bool BoundaryForces::faces(Index group, const Point3& normal) const {
    return dot(groups_.groups()[group].normal, normal) > kFacing;
}

void BoundaryForces::match(std::span<const Point3> positions) {
    measureFaces(positions);
    matchPulls();
    matchPushes();
}

/// Measures the faces. The depth of a face brings it as near to the points as the proof allows:
/// hardly apart where the boundary is flat.
void BoundaryForces::measureFaces(std::span<const Point3> positions) {
    const std::vector<Point3> fine = surface_.fineVertices(positions);
    const std::vector<Point3> irregular = surface_.irregularVertices(fine);
    const CageSurface::Faces& faces = surface_.fineFaces();
    const std::span<const std::array<Index, 4>> loops = faces.loops;
    fineFaces_.assign(loops.size(), {});
    for (std::size_t f = 0; f < loops.size(); ++f) {
        checkCancelledEvery(f, 12);
        const auto& [a, b, c, d] = loops[f];
        Face& face = fineFaces_[f];
        face.centre = scaled(sum(sum(fine[a], fine[b]), sum(fine[c], fine[d])), 0.25);
        const Point3 normal = cross(difference(fine[c], fine[a]), difference(fine[d], fine[b]));
        const double size = length(normal);
        if (size > 0) face.normal = scaled(normal, 1 / size);
        double lowest = dot(face.normal, face.centre);
        const double height = lowest;
        if (faces.isPatch[f] != 0) {
            lowest =
                std::min(lowest, faces.lowestOfPatch(static_cast<Index>(f), fine, face.normal));
        } else {
            for (const Index vertex : loops[f])
                lowest = std::min(lowest, dot(face.normal, fine[vertex]));
            for (const Index vertex : surface_.irregularHull(static_cast<Index>(f)))
                lowest = std::min(lowest, dot(face.normal, irregular[vertex]));
        }
        face.depth = height - lowest;
        // Deeper hulls are of faces that are still folded.
        face.depth = std::min(face.depth, 0.1 * edge_);
    }

    coarseFaces_.assign(pullFactor_.size(), {});
    for (std::size_t f = 0; f < fineFaces_.size(); ++f) {
        Face& coarse = coarseFaces_[surface_.coarseFaceOf(static_cast<Index>(f))];
        coarse.centre = sum(coarse.centre, scaled(fineFaces_[f].centre, 0.25));
        coarse.normal = sum(coarse.normal, fineFaces_[f].normal);
        coarse.depth += 0.25 * fineFaces_[f].depth;
    }
    for (Face& coarse : coarseFaces_) {
        const double size = length(coarse.normal);
        if (size > 0) coarse.normal = scaled(coarse.normal, 1 / size);
    }
}

/// Finds the nearest points of each face of level 2.
void BoundaryForces::matchPulls() {
    pulling_.resize(coarseFaces_.size());  // the last match is a good guess
    std::atomic<Offset> visitsOfAll = 0;
    parallelFor(std::ssize(pulling_), 64, [&](Offset first, Offset last) {
        Offset visits = 0;
        // The cells apart from the cell of the face: a search asks for many cells.
        std::vector<char> isApart(apart_.size(), 0);
        std::span<const Index> marked;
        for (Offset c = first; c < last; ++c) {
            const Point3& normal = coarseFaces_[c].normal;
            const auto guess = std::exchange(pulling_[c], std::nullopt);
            if (normal == Point3{0, 0, 0}) continue;
            for (const Index cell : marked) isApart[cell] = 0;
            marked = apart_[surface_.cellOfCoarse(static_cast<Index>(c))];
            for (const Index cell : marked) isApart[cell] = 1;
            pulling_[c] = groups_.nearest(
                coarseFaces_[c].centre, kPullRings,
                [&](std::optional<Index> cell) { return !cell || isApart[*cell] == 0; },
                [&](Index group) { return faces(group, normal); }, visits, guess);
        }
        visitsOfAll += visits;
    });
    visits_ = visitsOfAll;
}

/// Finds the nearest face of level 3 of each group of points, and the nearest one of another part.
void BoundaryForces::matchPushes() {
    const auto groups = groups_.groups();
    const CubeGrid& grid = groups_.grid();
    std::vector<Bins::Entry> entries;
    for (Index f = 0; f < std::ssize(fineFaces_); ++f)
        entries.push_back({grid.cubeOf(fineFaces_[f].centre), f});
    const Bins facesOfCubes(grid.cubeCount(), entries);
    const auto nearestFace = [&](const Point3& point, Index rings, std::optional<Index> guess,
                                 auto accept) {
        return grid.nearest(
            point, rings,
            [&](Index firstCube, Index lastCube, auto visit) {
                for (const Index f : facesOfCubes.itemsIn(firstCube, lastCube)) visit(f);
            },
            [&](Index f) -> const Point3& { return fineFaces_[f].centre; }, accept, guess);
    };
    const std::vector<Index>& cells = surface_.fineFaces().cells;
    std::vector<BoundingBox> facesOf(apart_.size());  // boxes around the faces of each cell
    for (std::size_t f = 0; f < fineFaces_.size(); ++f)
        facesOf[cells[f]].include(fineFaces_[f].centre);
    const double reach = kPushRings * grid.size;
    std::vector<std::vector<Index>> nearApart(apart_.size());  // of apart_: may be near a group
    for (std::size_t cell = 0; cell < apart_.size(); ++cell)
        for (const Index other : apart_[cell])
            if (areNear(facesOf[other], groupsOf_[cell], reach)) nearApart[cell].push_back(other);
    own_.resize(groups.size());
    other_.resize(groups.size());
    parallelFor(std::ssize(groups), 256, [&](Offset first, Offset last) {
        for (Offset g = first; g < last; ++g) {
            checkCancelledEvery(g, 5);
            const auto group = static_cast<Index>(g);
            const auto guess = std::exchange(other_[g], std::nullopt);
            if (groups[g].isInner) continue;
            // A group without proof must push a face, even a far one.
            const Index rings = failures_[g] > 0 ? kPullRings : kPushRings;
            own_[g] = nearestFace(groups[g].centre, rings, own_[g], [&](Index f) {
                return faces(group, fineFaces_[f].normal) && belongs(groups[g].cell, cells[f]);
            });
            if (!groups[g].cell) continue;
            if (std::ranges::any_of(nearApart[*groups[g].cell], [&](Index cell) {
                    return areNear(facesOf[cell], groups[g].bounds, reach);
                }))
                other_[g] = nearestFace(groups[g].centre, kPushRings, guess, [&](Index f) {
                    return !belongs(groups[g].cell, cells[f]);
                });
        }
    });
}

void BoundaryForces::renew() {
    pulls_.resize(coarseFaces_.size());
    for (std::size_t c = 0; c < pulls_.size(); ++c) pulls_[c] = pullOn(static_cast<Index>(c));
    renewPushes();
}

/// Pulls a face of level 2 towards the nearest points.
PlaneTerm BoundaryForces::pullOn(Index coarseFace) const {
    PlaneTerm term;
    term.row = coarseFace;
    const auto nearest = pulling_[coarseFace];
    if (!nearest) return term;
    const Face& face = coarseFaces_[coarseFace];
    const auto& group = groups_.groups()[*nearest];
    Point3 way = difference(face.centre, group.centre);
    const double distance = length(way);
    // Near the points, the direction to one of them means little.
    const double trust = std::clamp(distance / groups_.grid().size - 1, 0.0, 1.0);
    if (dot(way, face.normal) > 0 && distance > 0)
        way = sum(scaled(way, trust / distance), scaled(face.normal, 1 - trust));
    else
        way = face.normal;
    term.direction = normalised(way);
    term.offset = dot(term.direction, groups_.farthest(group, term.direction)) +
                  clearance_[*nearest] + face.depth;
    term.outside = kPull / (edge_ * edge_) / 16 * pullFactor_[coarseFace];
    term.reach = 0.25 * edge_;
    return term;
}

/// Returns the distance of the face that a group pushes outwards from the plane in which the face
/// is as near to the points as it may be; negative if the face must move outwards.
double BoundaryForces::pushedDistance(std::size_t group) const {
    const Face& face = fineFaces_[*own_[group]];
    const Point3& farthest = groups_.farthest(groups_.groups()[group], face.normal);
    return dot(face.normal, difference(face.centre, farthest)) - clearance_[group] - face.depth;
}

/// Pushes the nearest face of level 3 of each group of points outwards. If several groups are
/// nearest to one face, the one that sticks out most counts. Pushes faces of other parts away from
/// the group.
void BoundaryForces::renewPushes() {
    const double weight = kPush / (edge_ * edge_) / 64, reach = 0.05 * edge_;
    std::vector<double> leastOf(fineFaces_.size(), 0.25 * edge_), leastOfOther = leastOf;
    std::vector<PlaneTerm> terms(fineFaces_.size()), termsOfOther(fineFaces_.size());
    for (std::size_t g = 0; g < own_.size(); ++g) {
        if (const auto f = own_[g]) {
            const Face& face = fineFaces_[*f];
            const double distance = pushedDistance(g);
            if (distance < leastOf[*f]) {
                leastOf[*f] = distance;
                const double offset = dot(face.normal, face.centre) - distance;
                terms[*f] = {*f, face.normal, offset, weight * pushFactor_[g], 0, reach};
            }
        }
        if (const auto f = other_[g]) {
            const Point3 inwards = scaled(fineFaces_[*f].normal, -1);
            const double offset =
                dot(inwards, groups_.farthest(groups_.groups()[g], inwards)) + distanceToOthers_[g];
            const double distance = dot(inwards, fineFaces_[*f].centre) - offset;
            if (distance < leastOfOther[*f]) {
                leastOfOther[*f] = distance;
                termsOfOther[*f] = {*f, inwards, offset, weight, 0, reach};
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

double BoundaryForces::workOfMatch() const {
    constexpr double kPerGroup = 1000, kPerFace = 1000, kPerCube = 1;
    return kPerGroup * static_cast<double>(groups_.groups().size()) +
           kPerFace * surface_.fineCentres().rowCount() + kPerCube * groups_.grid().cubeCount();
}

double BoundaryForces::workOfPulls() const {
    constexpr double kPerVisit = 12;
    return kPerVisit * static_cast<double>(visits_);
}

double BoundaryForces::workOfEnergy() const {
    constexpr double kPerFace = 100;
    return kPerFace * (surface_.coarseCentres().rowCount() + static_cast<double>(pushes_.size()));
}

void BoundaryForces::strengthen(std::span<const Uncovered> uncovered) {
    std::vector<double> raises(groups_.groups().size(), 0);
    for (const Uncovered& group : uncovered) {
        // A point that another part of the lattice covers, or nearly so.
        if (group.winding > 1 ||
            (group.cell && !belongs(groups_.groups()[group.group].cell, *group.cell))) {
            double& distance = distanceToOthers_[group.group];
            distance = std::min(distance + 0.01 * edge_, margin_ + 0.25 * edge_);
            continue;
        }
        if (own_[group.group] && pushedDistance(group.group) < -0.02 * edge_)
            pushFactor_[group.group] = std::min(2 * pushFactor_[group.group], 64.0);
        // A group that fails again rises further each time.
        const int times = ++failures_[group.group];
        const double more = std::min(
            times * (std::min(1.5 * group.depth, 0.05 * edge_) + 0.005 * edge_), 0.06 * edge_);
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
    for (std::size_t c = 0; c < pullFactor_.size(); ++c)
        if (pulling_[c] && isRaised_[*pulling_[c]] != 0) pullFactor_[c] *= kFade;
}

Index BoundaryForces::countOutside(double distance) const {
    Index count = 0;
    for (std::size_t g = 0; g < own_.size(); ++g)
        if (own_[g] && pushedDistance(g) < -distance) ++count;
    return count;
}

std::optional<Index> BoundaryForces::pushedCell(Index group) const {
    if (!own_[group]) return std::nullopt;
    return surface_.fineFaces().cells[*own_[group]];
}

void BoundaryForces::weakenPulls(std::span<const char> isChosen, double factor) {
    for (std::size_t c = 0; c < pullFactor_.size(); ++c)
        if (isChosen[surface_.cellOfCoarse(static_cast<Index>(c))] != 0) pullFactor_[c] *= factor;
}

}  // namespace espalier::cages

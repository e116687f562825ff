// SPDX-License-Identifier: Apache-2.0
#include "fit_cage.h"

#include <espalier/base/bounding_box.h>
#include <espalier/base/error.h>
#include <espalier/base/number_text.h>
#include <espalier/base/parallel.h>
#include <espalier/base/sort_unique.h>
#include <espalier/base/vector3.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/solve/validity.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "cage_energy.h"
#include "cage_surface.h"
#include "point_groups.h"

namespace espalier::cages {
namespace {

/// Attempts to fit; each one pulls less than the one before, and keeps nearer to the start.
constexpr int kAttempts = 4;

/// A lattice that becomes larger than this, as a multiple of the volume of the start, is given up.
/// The start is wide already; only one that leaves points outside must grow.
constexpr double kMaxGrowth = 2;

/// How far a point may be outside the start, in edges of the start.
constexpr double kMaxOutside = 1;

/// After the first proof, at most kPolishes rounds give more weight to cells with a scaled Jacobian
/// below kGoodJacobian. Better cells move the boundary, so other rounds repair the proof.
constexpr int kPolishes = 3;
constexpr double kGoodJacobian = 0.3;

/// An attempt is given up if this many rounds of repair leave more than kLeftOver of the failures.
/// A few failures may come and go before the last one is repaired.
constexpr std::size_t kPatience = 3;
constexpr double kLeftOver = 0.75;
constexpr double kLastFailures = 4;

/// A round of repair is short, and changes only what is near the failures, if there are fewer
/// failures than this.
constexpr std::size_t kFewFailures = 16;

/// Faces that points push are at most this far away, in cubes of the points.
constexpr Index kPushRings = 3;

/// Least cosine between the normals of a face and of the points that it is fitted to.
constexpr double kFacing = -0.5;

struct Weights {
    double shape = 0.03;  ///< of a cell
    double pull = 1;      ///< of the squared distance, in edges, of the surface from the points
    double push = 1000;   ///< of the squared distance by which a point sticks out
};

void checkFinite(const Point3& point, const char* name, std::size_t number) {
    for (const double coordinate : point)
        if (!(std::abs(coordinate) <= 1e90))
            throw Error(concat(
                "fitting a cage: ", name, " ", number,
                std::isfinite(coordinate) ? " is too far from the origin" : " is not finite"));
}

/// Returns true if more rounds of repair will hardly help.
/// \param failures of all rounds so far: groups of points and cells without proof
bool isStuck(std::span<const std::size_t> failures) {
    if (failures.size() < 2) return false;
    const auto leastUpTo = [&](std::size_t count) {
        return static_cast<double>(
            *std::min_element(failures.begin(), failures.begin() + static_cast<Offset>(count)));
    };
    const auto last = static_cast<double>(failures.back());
    // The number grows where two parts push each other.
    if (last > 2 * leastUpTo(failures.size() - 1) + 20) return true;
    return failures.size() > kPatience &&
           last > kLeftOver * leastUpTo(failures.size() - kPatience) + kLastFailures;
}

/// The state of a fit.
class Fit {
public:
    Fit(const Lattice& start, std::span<const FitPoint> points, const FitOptions& options)
        : options_(options),
          base_(start.complex, refinerOptions(start)),
          refiner_(refined()),
          surface_(base_),
          start_(start.positions),
          positions_(start_),
          edge_(meanEdge(start)),
          groups_(points, gridAround(start, points, std::max(edge_ / 8, options.margin / 2))),
          shapes_(refiner_),
          parts_(base_, options.levelOfParts) {
        findApart();
    }

    std::vector<Point3> run();

private:
    far::TopologyRefiner refined() const {
        far::TopologyRefiner refiner(base_.level(0), base_.options());
        refiner.refineUniform(CellShapes::kLevel);
        return refiner;
    }
    static double meanEdge(const Lattice& lattice) {
        double total = 0;
        const auto& ends = lattice.complex.relation(1, 0);
        for (Index edge = 0; edge < lattice.complex.count(1); ++edge)
            total += length(
                difference(lattice.positions[ends[edge][0]], lattice.positions[ends[edge][1]]));
        return total / lattice.complex.count(1);
    }
    static CubeGrid gridAround(const Lattice& lattice, std::span<const FitPoint> points,
                               double size) {
        BoundingBox bounds(lattice.positions);
        for (const FitPoint& point : points) bounds.include(point.position);
        return {bounds.min, bounds.max, size};
    }

    void findApart();

    /// Returns true if a group of points belongs to the part of the model that a cell holds.
    bool belongs(Index group, Index cell) const {
        const Index of = groups_.groups()[group].cell;
        return of < 0 || !std::ranges::binary_search(apart_[cell], of);
    }

    /// Returns true if a face with this normal is fitted to a group of points. It may not face the
    /// other way, as the far side of a thin part does, or the boundary of another part.
    bool suits(Index group, Index cell, const Point3& normal) const {
        return !groups_.groups()[group].isInner &&
               dot(groups_.groups()[group].normal, normal) > kFacing && belongs(group, cell);
    }

    template <class Accept>
    Index nearestFace(const Point3& point, Index rings, const std::vector<Point3>& centres,
                      Accept accept) const;

    void begin(int attempt);
    void associate();
    void measureDepths(std::span<const Point3> fine, const std::vector<Point3>& centres,
                       const std::vector<Point3>& normals);
    void associatePulls(const std::vector<Point3>& centres, const std::vector<Point3>& normals);
    void associatePushes(const std::vector<Point3>& centres, const std::vector<Point3>& normals);
    void optimise(int iterations);
    void improve(int steps, int iterations);
    bool certify();
    void polish();
    void requireNear() const;
    double enclosedVolume() const;

    const FitOptions& options_;
    far::TopologyRefiner base_, refiner_;
    CageSurface surface_;
    std::vector<Point3> start_, positions_;
    double edge_;
    PointGroups groups_;
    CellShapes shapes_;
    limit::LimitParts parts_;
    std::vector<std::vector<Index>> apart_;  ///< of each cell, ascending; if points have cells
    std::vector<Index> firstOfCube_, nextOfFace_;  ///< lists of the faces of level 3 in each cube
    /// Least distance of the hulls of the boundary from each group.
    std::vector<double> clearance_;
    /// How far the hulls of each face of level 3 reach inwards of its centre.
    std::vector<double> depths_;
    std::vector<double> distanceToOthers_;  ///< of each group, from faces it does not belong to
    double anchor_ = 0;             ///< weight of the squared way of a vertex from the start
    std::vector<double> pushOf_;    ///< factor of each group
    std::vector<double> distance_;  ///< of each group from its plane, when it was last associated
    std::vector<double> raise_;     ///< of the clearance of each group
    std::vector<char> isRaised_;
    std::vector<int> failuresOf_;  ///< rounds in which each group had no proof
    std::vector<double> pull_;     ///< factor of each face of level 2
    std::vector<PlaneTerm> pulls_, pushes_;
    Weights weights_;
    std::size_t failureCount_ = 0;  ///< groups and cells without proof at the last certify()
    std::string failure_;
};

void Fit::begin(int attempt) {
    const double pull = attempt + 1 < kAttempts ? std::pow(0.3, attempt) : 0;
    positions_ = start_;
    anchor_ = 0.001 * std::pow(4, attempt) / (edge_ * edge_);
    shapes_.resetWeights();
    pull_.assign(surface_.coarseCentres().rowCount(), pull);
    clearance_.assign(groups_.groups().size(), options_.margin + 0.01 * edge_);
    distanceToOthers_.assign(clearance_.size(), options_.margin + 0.03 * edge_);
    pushOf_.assign(clearance_.size(), 1.0);
    isRaised_.assign(clearance_.size(), 0);
    failuresOf_.assign(clearance_.size(), 0);
}

/// Lists, for each cell, the cells that are close to it in space but not along the lattice: their
/// parts of the model are apart. In a full grid the number of faces between two cells is at most √3
/// times their distance in edges.
void Fit::findApart() {
    constexpr double kNear = 5;   // edges
    constexpr int kMaxSteps = 9;  // more than √3 · kNear
    const far::CellComplex& complex = base_.level(0).complex;
    std::vector<Point3> centres;
    for (Index cell = 0; cell < complex.count(3); ++cell) {
        std::vector<Point3> corners;
        for (const Index vertex : complex.relation(3, 0)[cell]) corners.push_back(start_[vertex]);
        centres.push_back(mean(corners));
    }
    apart_.resize(centres.size());
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
            const double distance = length(difference(centres[a], centres[b])) / edge_;
            if (distance > kNear) continue;
            if (steps[b] < 0 || steps[b] > std::sqrt(3) * distance + 0.5)
                apart_[a].push_back(static_cast<Index>(b));
        }
        for (const Index cell : reached) steps[cell] = -1;
    }
}

void Fit::associate() {
    const std::vector<Point3> fine = surface_.fineVertices(positions_);
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
    associatePulls(centres, normals);
    associatePushes(centres, normals);
}

/// Finds out how far the hulls of each face of level 3 reach inwards of its centre, so that a face
/// is as near to the points as the proof allows: hardly apart where the boundary is flat.
void Fit::measureDepths(std::span<const Point3> fine, const std::vector<Point3>& centres,
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
void Fit::associatePulls(const std::vector<Point3>& centres, const std::vector<Point3>& normals) {
    const double unit = 1 / (edge_ * edge_);
    std::vector<Point3> coarseCentres(pull_.size(), {0, 0, 0}),
        coarseNormals(pull_.size(), {0, 0, 0});
    std::vector<double> coarseDepths(pull_.size(), 0);
    for (std::size_t f = 0; f < centres.size(); ++f) {
        const Index coarse = surface_.coarseFaceOf(static_cast<Index>(f));
        coarseNormals[coarse] = sum(coarseNormals[coarse], normals[f]);
        coarseDepths[coarse] += 0.25 * depths_[f];
        coarseCentres[coarse] = sum(coarseCentres[coarse], scaled(centres[f], 0.25));
    }
    const auto groups = groups_.groups();
    pulls_.assign(pull_.size(), {});
    parallelFor(std::ssize(pulls_), 64, [&](Offset first, Offset last) {
        for (Offset c = first; c < last; ++c) {
            PlaneTerm& term = pulls_[c];
            term.row = static_cast<Index>(c);
            const double size = length(coarseNormals[c]);
            if (!(size > 0)) continue;
            const Point3 normal = scaled(coarseNormals[c], 1 / size);
            const Index cell = surface_.cellOfCoarse(term.row);
            const Index nearest = groups_.nearest(
                coarseCentres[c], 24, [&](Index group) { return suits(group, cell, normal); });
            if (nearest < 0) continue;
            const auto& group = groups[nearest];
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
                          clearance_[nearest] + coarseDepths[c];
            if (isRaised_[nearest]) pull_[c] *= 0.8;
            term.outside = weights_.pull * unit / 16 * pull_[c];
            term.inside = 0;
            term.reach = 0.25 * edge_;
        }
    });
}

/// Returns the face of level 3 with the nearest centre, of those with accept(face); −1 if none is
/// within `rings` rings of cubes.
template <class Accept>
Index Fit::nearestFace(const Point3& point, Index rings, const std::vector<Point3>& centres,
                       Accept accept) const {
    const auto place = groups_.grid().coordinatesOf(point);
    double least = 0;
    Index best = -1;
    for (Index ring = 0; ring <= rings; ++ring) {
        const double reach = (ring - 1) * groups_.grid().size;
        if (best >= 0 && reach > 0 && reach * reach > least) break;
        groups_.grid().forEachInRing(place, ring, [&](Index cube) {
            for (Index f = firstOfCube_[cube]; f >= 0; f = nextOfFace_[f]) {
                const Point3 way = difference(centres[f], point);
                const double distance = dot(way, way);
                if (best >= 0 && (distance > least || (distance == least && f > best))) continue;
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
void Fit::associatePushes(const std::vector<Point3>& centres, const std::vector<Point3>& normals) {
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
    // Boxes around the faces of each cell.
    std::vector<Point3> low(apart_.size(), {1e99, 1e99, 1e99}),
        high(apart_.size(), {-1e99, -1e99, -1e99});
    for (Index f = 0; f < faceCount; ++f)
        for (int axis = 0; axis < 3; ++axis) {
            low[cells[f]][axis] = std::min(low[cells[f]][axis], centres[f][axis]);
            high[cells[f]][axis] = std::max(high[cells[f]][axis], centres[f][axis]);
        }
    const double reach = kPushRings * groups_.grid().size;
    const auto isNear = [&](Index group, Index cell) {
        for (int axis = 0; axis < 3; ++axis)
            if (low[cell][axis] > groups[group].high[axis] + reach ||
                high[cell][axis] < groups[group].low[axis] - reach)
                return false;
        return true;
    };
    std::vector<Index> own(groups.size(), -1), other(groups.size(), -1);
    parallelFor(std::ssize(groups), 256, [&](Offset first, Offset last) {
        for (Offset g = first; g < last; ++g) {
            const auto group = static_cast<Index>(g);
            if (groups[g].isInner) continue;
            own[g] = nearestFace(groups[g].centre, kPushRings, centres,
                                 [&](Index f) { return suits(group, cells[f], normals[f]); });
            if (groups[g].cell < 0) continue;
            const std::vector<Index>& apart = apart_[groups[g].cell];
            if (std::any_of(apart.begin(), apart.end(),
                            [&](Index cell) { return isNear(group, cell); }))
                other[g] = nearestFace(groups[g].centre, kPushRings, centres,
                                       [&](Index f) { return !belongs(group, cells[f]); });
        }
    });
    distance_.assign(groups.size(), 0);
    std::vector<double> leastOf(faceCount, 0.25 * edge_), leastOfOther = leastOf;
    std::vector<PlaneTerm> terms(faceCount), termsOfOther(faceCount);
    const auto pushOwn = [&](std::size_t g, Index f) {
        const Point3& normal = normals[f];
        const double offset =
            dot(normal, groups_.farthest(groups[g], normal)) + clearance_[g] + depths_[f];
        const double distance = dot(normal, centres[f]) - offset;
        distance_[g] = distance;
        if (distance < leastOf[f]) {
            leastOf[f] = distance;
            terms[f] = {f, normal, offset, weights_.push * pushOf_[g] * unit / 64, 0, 0.05 * edge_};
        }
    };
    for (std::size_t g = 0; g < groups.size(); ++g) {
        if (own[g] >= 0) pushOwn(g, own[g]);
        if (const Index f = other[g]; f >= 0) {
            const Point3 inwards = scaled(normals[f], -1);
            const double offset =
                dot(inwards, groups_.farthest(groups[g], inwards)) + distanceToOthers_[g];
            const double distance = dot(inwards, centres[f]) - offset;
            if (distance < leastOfOther[f]) {
                leastOfOther[f] = distance;
                termsOfOther[f] = {f, inwards, offset, weights_.push * unit / 64, 0, 0.05 * edge_};
            }
        }
    }
    pushes_.clear();
    for (const auto* list : {&terms, &termsOfOther})
        for (const PlaneTerm& term : *list)
            if (term.inside > 0) pushes_.push_back(term);
}

void Fit::optimise(int iterations) {
    const Energy energy = [&](std::span<const Point3> positions, std::span<Point3> gradient) {
        double total = shapes_.evaluate(positions, gradient) * weights_.shape;
        for (Point3& slope : gradient) slope = scaled(slope, weights_.shape);
        for (std::size_t i = 0; i < positions.size(); ++i) {
            const Point3 way = difference(positions[i], start_[i]);
            total += anchor_ * dot(way, way);
            gradient[i] = sum(gradient[i], scaled(way, 2 * anchor_));
        }
        total += evaluatePlanes(surface_.coarseCentres(), pulls_, positions, gradient);
        total += evaluatePlanes(surface_.fineCentres(), pushes_, positions, gradient);
        return total;
    };
    positions_ = minimise(energy, std::move(positions_), iterations, 0.1 * edge_);
}

void Fit::improve(int steps, int iterations) {
    for (int step = 0; step < steps; ++step) {
        associate();
        optimise(iterations);
    }
}

bool Fit::certify() {
    associate();
    bool isProved = true;
    const auto uncovered = findUncovered(surface_, positions_, groups_, options_.margin);
    double deepest = 0;
    raise_.assign(groups_.groups().size(), 0);
    for (const Uncovered& group : uncovered) {
        if (group.depth > deepest) {
            deepest = group.depth;
            failure_ = concat("the point ", textOf(groups_.points()[group.point]),
                              group.winding > 1 ? " is not proved to be inside only once"
                                                : " is not proved to be inside");
        }
        isProved = false;
        // A point that another part of the lattice covers, or nearly so.
        if (group.winding > 1 || (group.cell >= 0 && !belongs(group.group, group.cell))) {
            double& distance = distanceToOthers_[group.group];
            distance = std::min(distance + 0.01 * edge_, options_.margin + 0.25 * edge_);
            continue;
        }
        if (distance_[group.group] < -0.02 * edge_)
            pushOf_[group.group] = std::min(2 * pushOf_[group.group], 64.0);
        // A group that fails again rises further each time.
        const int times = ++failuresOf_[group.group];
        const double more = std::min(
            times * (std::min(1.1 * group.depth, 0.05 * edge_) + 0.003 * edge_), 0.06 * edge_);
        const auto place = groups_.grid().coordinatesOf(groups_.groups()[group.group].centre);
        for (Index ring = 0; ring <= 2; ++ring)
            groups_.grid().forEachInRing(place, ring, [&](Index cube) {
                groups_.forEachInCube(cube, [&](Index near) {
                    raise_[near] = std::max(raise_[near], more * (1 - 0.25 * ring));
                });
            });
    }
    // While many groups fail, all others rise a little too, so that points do not stick out in
    // turns.
    const double raiseOfAll =
        0.003 * edge_ * std::min(1.0, static_cast<double>(uncovered.size()) / kFewFailures);
    for (std::size_t g = 0; g < raise_.size(); ++g) {
        const double more = std::max(raise_[g], raiseOfAll);
        clearance_[g] = std::min(clearance_[g] + more, options_.margin + 0.25 * edge_);
        if (raise_[g] > 0) isRaised_[g] = 1;
    }
    const solve::ValidityCheck check(parts_, positions_);
    failureCount_ = uncovered.size() + check.badAtRest().size();
    std::vector<char> isBad(shapes_.cellCount(), 0);
    const far::CellComplex& complex = base_.level(0).complex;
    shapes_.examine(check.badAtRest());
    for (const Index cell : check.badAtRest()) {
        shapes_.scaleWeight(cell, 2);
        for (const Index vertex : complex.relation(3, 0)[cell])
            for (const Index near : complex.relation(0, 3)[vertex]) isBad[near] = 1;
        if (isProved) failure_ = concat("cell ", cell, " is not proved to be free of folds");
        isProved = false;
    }
    for (Index cell = 0; cell < shapes_.cellCount(); ++cell)
        if (isBad[cell]) shapes_.scaleWeight(cell, 1.5);
    for (std::size_t c = 0; c < pull_.size(); ++c)
        if (isBad[surface_.cellOfCoarse(static_cast<Index>(c))]) pull_[c] *= 0.5;
    return isProved;
}

/// Throws if a point is further than kMaxOutside edges from the box around the start.
void Fit::requireNear() const {
    BoundingBox bounds(surface_.fineVertices(start_));
    bounds.include(start_.front());
    for (const Point3& point : groups_.points())
        for (int axis = 0; axis < 3; ++axis) {
            const double away =
                std::max(bounds.min[axis] - point[axis], point[axis] - bounds.max[axis]);
            if (away > kMaxOutside * edge_)
                throw Error(concat("fitting a cage: the point ", textOf(point), " is ",
                                   textOf(away), " outside the start lattice; expected at most ",
                                   textOf(kMaxOutside * edge_)));
        }
}

/// Returns the volume inside the triangles of level 3.
double Fit::enclosedVolume() const {
    const std::vector<Point3> vertices = surface_.fineVertices(positions_);
    double volume = 0;
    for (const auto& face : surface_.fineFaces().loops) {
        const Point3& origin = vertices.front();
        const Point3 a = difference(vertices[face[0]], origin);
        const Point3 b = difference(vertices[face[1]], origin);
        const Point3 c = difference(vertices[face[2]], origin);
        const Point3 d = difference(vertices[face[3]], origin);
        volume += (dot(a, cross(b, c)) + dot(a, cross(c, d))) / 6;
    }
    return volume;
}

/// Improves the worst cells of a lattice that is proved.
void Fit::polish() {
    const far::CellComplex& complex = base_.level(0).complex;
    std::vector<double> shapes = shapes_.leastJacobians(positions_);
    double best = *std::min_element(shapes.begin(), shapes.end());
    std::vector<Point3> kept = positions_;
    const auto favourPoorCells = [&] {
        std::vector<Index> poor;
        for (Index cell = 0; cell < shapes_.cellCount(); ++cell) {
            if (shapes[cell] >= kGoodJacobian) continue;
            poor.push_back(cell);
            shapes_.scaleWeight(cell, 2);
            for (const Index face : complex.relation(3, 2)[cell])
                for (const Index near : complex.relation(2, 3)[face])
                    shapes_.scaleWeight(near, 1.2);
        }
        shapes_.examine(poor);
        for (std::size_t c = 0; c < pull_.size(); ++c)
            if (shapes[surface_.cellOfCoarse(static_cast<Index>(c))] < kGoodJacobian)
                pull_[c] *= 0.6;
    };
    bool isProved = true;
    for (int polishes = 0, repairs = 0; best < kGoodJacobian;) {
        if (isProved) {
            if (polishes++ == kPolishes) break;
            favourPoorCells();
        } else if (repairs++ == options_.maxRounds) {
            break;
        }
        improve(2, 15);
        isProved = certify();
        shapes = shapes_.leastJacobians(positions_);
        const double least = *std::min_element(shapes.begin(), shapes.end());
        if (isProved && least > best) {
            best = least;
            kept = positions_;
        }
    }
    positions_ = std::move(kept);
}

std::vector<Point3> Fit::run() {
    // Each attempt starts anew and pulls less. The last one only pushes.
    const double startVolume = enclosedVolume();
    requireNear();
    for (int attempt = 0; attempt < options_.maxAttempts; ++attempt) {
        begin(attempt);
        // Early steps are short, because faces then change their nearest points.
        improve(6, 8);
        improve(6, 20);
        std::vector<std::size_t> failures;
        for (int round = 0; round < options_.maxRounds; ++round) {
            if (!(enclosedVolume() <= kMaxGrowth * startVolume)) break;
            if (certify()) {
                polish();
                return std::move(positions_);
            }
            failures.push_back(failureCount_);
            if (isStuck(failures)) break;
            if (failureCount_ < kFewFailures)
                improve(2, 15);
            else
                improve(3, 25);
        }
    }
    throw FitError(
        concat("fitting a cage of ", base_.level(0).complex.count(0), " vertices: ", failure_));
}

}  // namespace

Lattice fitCage(Lattice start, std::span<const FitPoint> points, const FitOptions& options) {
    if (start.complex.dimension() != 3) throw Error("fitting a cage: the start is not a lattice");
    if (points.empty()) throw Error("fitting a cage: there are no points");
    if (!(options.margin >= 0 && options.margin <= 1e90))
        throw Error(concat("fitting a cage: the margin is ", textOf(options.margin),
                           "; expected a finite number, 0 or more"));
    if (std::ssize(start.positions) != start.complex.count(0))
        throw Error(concat("fitting a cage: got ", start.positions.size(), " positions for ",
                           start.complex.count(0), " vertices"));
    if (options.maxRounds < 1)
        throw Error(
            concat("fitting a cage: maxRounds is ", options.maxRounds, "; expected 1 or more"));
    if (options.maxAttempts < 1 || options.maxAttempts > kAttempts)
        throw Error(concat("fitting a cage: maxAttempts is ", options.maxAttempts,
                           "; expected 1 to ", kAttempts));
    if (refinerOptions(start).boundary == far::Boundary::Open)
        throw Error("fitting a cage: the start has an open boundary, which shrinks away");
    for (std::size_t i = 0; i < points.size(); ++i) {
        checkFinite(points[i].position, "point", i);
        if (points[i].cell < -1 || points[i].cell >= start.complex.count(3))
            throw Error(concat("fitting a cage: point ", i, " belongs to cell ", points[i].cell,
                               "; expected -1 to ", start.complex.count(3) - 1));
    }
    for (std::size_t i = 0; i < start.positions.size(); ++i)
        checkFinite(start.positions[i], "vertex", i);
    const auto isStart = [&](const Point3& p) { return p == start.positions.front(); };
    if (std::all_of(start.positions.begin(), start.positions.end(), isStart))
        throw Error("fitting a cage: all vertices of the start are at one place");
    Fit fit(start, points, options);
    start.positions = fit.run();
    return start;
}

}  // namespace espalier::cages

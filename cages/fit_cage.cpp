// SPDX-License-Identifier: Apache-2.0
#include "fit_cage.h"

#include <espalier/base/error.h>
#include <espalier/base/parallel.h>
#include <espalier/base/vector3.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/solve/validity.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstdio>
#include <chrono>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cage_energy.h"
#include "cage_surface.h"
#include "point_groups.h"

namespace espalier::cages {
namespace {

double env(const char*n,double d){const char*e=std::getenv(n);return e?std::atof(e):d;}
struct Weights {
    double shape = env("SHAPE", 0.04);   ///< of a cell
    double pull = env("PULL", 1);       ///< of the squared distance, in edges, of the surface from the points
    double push = env("PUSH", 1000);     ///< of the squared distance by which a point sticks out
};

struct Timer {
    std::chrono::steady_clock::time_point t = std::chrono::steady_clock::now();
    void lap(const char* name) {
        const auto now = std::chrono::steady_clock::now();
        if (std::getenv("FIT_TRACE"))
            std::fprintf(stderr, "  %-12s %.3f\n", name,
                         std::chrono::duration<double>(now - t).count());
        t = now;
    }
};

void checkFinite(std::span<const Point3> points, const char* name) {
    for (std::size_t i = 0; i < points.size(); ++i)
        for (const double coordinate : points[i])
            if (!(std::abs(coordinate) <= 1e90))
                throw Error(concat("fitting a cage: ", name, " ", i,
                                   std::isfinite(coordinate) ? " is too far from the origin"
                                                             : " is not finite"));
}

std::string textOf(const Point3& point) {
    return concat("(", point[0], ", ", point[1], ", ", point[2], ")");
}

/// The state of a fit.
class Fit {
public:
    Fit(const Lattice& start, std::span<const Point3> points, const FitOptions& options)
        : options_(options), base_(start.complex, refinerOptions(start)), refiner_(refinedOnce()),
          surface_(base_), positions_(start.positions), edge_(meanEdge(start)),
          groups_(points, gridAround(start, points, edge_)), shapes_(refiner_, 1),
          parts_(base_, options.levelOfParts),
          clearance_(groups_.groups().size(), options.margin + env("CLR",0.05) * edge_),
          pushOf_(clearance_.size(), 1.0), isRaised_(clearance_.size(), 0), pull_(surface_.coarseCentres().rowCount(), 1.0) {}

    std::vector<Point3> run();

private:
    far::TopologyRefiner refinedOnce() const {
        far::TopologyRefiner refiner(base_.level(0), base_.options());
        refiner.refineUniform(1);
        return refiner;
    }
    static double meanEdge(const Lattice& lattice) {
        double total = 0;
        const auto& ends = lattice.complex.relation(1, 0);
        for (Index edge = 0; edge < lattice.complex.count(1); ++edge)
            total += length(difference(lattice.positions[ends[edge][0]],
                                       lattice.positions[ends[edge][1]]));
        return total / lattice.complex.count(1);
    }
    static CubeGrid gridAround(const Lattice& lattice, std::span<const Point3> points,
                               double edge) {
        Point3 low = lattice.positions.front(), high = low;
        const auto include = [&](const Point3& point) {
            for (int axis = 0; axis < 3; ++axis) {
                low[axis] = std::min(low[axis], point[axis]);
                high[axis] = std::max(high[axis], point[axis]);
            }
        };
        for (const Point3& point : lattice.positions) include(point);
        for (const Point3& point : points) include(point);
        return {low, high, edge / 8};
    }

    void associate();
    void optimise(int iterations);
    bool certify(int round);

    const FitOptions& options_;
    far::TopologyRefiner base_, refiner_;
    CageSurface surface_;
    std::vector<Point3> positions_;
    double edge_;
    PointGroups groups_;
    CellShapes shapes_;
    limit::LimitParts parts_;
    std::vector<double> clearance_;  ///< of each group
    std::vector<double> pushOf_;     ///< factor of each group
    std::vector<double> distance_;   ///< of each group from its plane, when it was last associated
    std::vector<double> raise_;      ///< of the clearance of each group
    std::vector<char> isRaised_;
    std::vector<double> pull_;       ///< factor of each face of level 2
    std::vector<PlaneTerm> pulls_, pushes_;
    Weights weights_;
    std::string failure_;
};

void Fit::associate() {
    const double unit = 1 / (edge_ * edge_);
    const std::vector<Point3> fine = surface_.fineVertices(positions_);
    const std::span<const std::array<Index, 4>> faces = surface_.fineFaces().loops;
    const auto faceCount = static_cast<Index>(faces.size());
    std::vector<Point3> centres(faceCount), normals(faceCount);
    std::vector<Point3> coarseCentres(pull_.size(), {0, 0, 0}), coarseNormals(pull_.size(), {0, 0, 0});
    for (Index f = 0; f < faceCount; ++f) {
        const auto& face = faces[f];
        centres[f] = scaled(sum(sum(fine[face[0]], fine[face[1]]), sum(fine[face[2]], fine[face[3]])),
                            0.25);
        const Point3 normal = cross(difference(fine[face[2]], fine[face[0]]),
                                    difference(fine[face[3]], fine[face[1]]));
        const double size = length(normal);
        normals[f] = size > 0 ? scaled(normal, 1 / size) : Point3{0, 0, 0};
        const Index coarse = surface_.coarseFaceOf(f);
        coarseNormals[coarse] = sum(coarseNormals[coarse], normal);
        coarseCentres[coarse] = sum(coarseCentres[coarse], scaled(centres[f], 0.25));
    }
    const auto groups = groups_.groups();
    // Pulls: each face of level 2 towards the nearest points.
    pulls_.assign(pull_.size(), {});
    parallelFor(std::ssize(pulls_), 64, [&](Offset first, Offset last) {
        for (Offset c = first; c < last; ++c) {
            PlaneTerm& term = pulls_[c];
            term.row = static_cast<Index>(c);
            const double size = length(coarseNormals[c]);
            if (!(size > 0)) continue;
            const Point3 normal = scaled(coarseNormals[c], 1 / size);
            const Index nearest = groups_.nearest(coarseCentres[c], 24);
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
                          clearance_[nearest];
            if (isRaised_[nearest]) pull_[c] *= 0.9;
            term.outside = weights_.pull * unit / 16 * pull_[c];
            term.inside = 0;
            term.reach = 0.25 * edge_;
        }
    });
    // Pushes: each group of points against the nearest face of level 3. Of the points at the faces
    // that are one face of level 2, the one that sticks out most counts.
    std::vector<Index> firstOfCube(groups_.grid().cubeCount(), -1), nextOfFace(faceCount, -1);
    for (Index f = faceCount; f-- > 0;) {
        Index& first = firstOfCube[groups_.grid().cubeOf(centres[f])];
        nextOfFace[f] = first;
        first = f;
    }
    std::vector<Index> nearestFace(groups.size(), -1);
    parallelFor(std::ssize(groups), 256, [&](Offset first, Offset last) {
        for (Offset g = first; g < last; ++g) {
            const Point3& point = groups[g].centre;
            const auto place = groups_.grid().coordinatesOf(point);
            double least = 0;
            Index best = -1;
            for (Index ring = 0; ring <= 3; ++ring) {
                const double reach = (ring - 1) * groups_.grid().size;
                if (best >= 0 && reach > 0 && reach * reach > least) break;
                groups_.grid().forEachInRing(place, ring, [&](Index cube) {
                    for (Index f = firstOfCube[cube]; f >= 0; f = nextOfFace[f]) {
                        const Point3 way = difference(centres[f], point);
                        const double distance = dot(way, way);
                        if (best < 0 || distance < least || (distance == least && f < best)) {
                            best = f;
                            least = distance;
                        }
                    }
                });
            }
            nearestFace[g] = best;
        }
    });
    distance_.assign(groups.size(), 0);
    std::vector<double> leastOf(faceCount, 0.25 * edge_);
    std::vector<PlaneTerm> of(faceCount);
    for (std::size_t g = 0; g < groups.size(); ++g) {
        const Index f = nearestFace[g];
        if (f < 0) continue;
        const Point3& normal = normals[f];
        const double offset = dot(normal, groups_.farthest(groups[g], normal)) + clearance_[g];
        const double distance = dot(normal, centres[f]) - offset;
        distance_[g] = distance;
        if (distance < leastOf[f]) {
            leastOf[f] = distance;
            of[f] = {f, normal, offset, weights_.push * pushOf_[g] * unit / 64, 0, 0.05 * edge_};
        }
    }
    pushes_.clear();
    for (const PlaneTerm& term : of)
        if (term.inside > 0) pushes_.push_back(term);
}

void Fit::optimise(int iterations) {
    const Energy energy = [&](std::span<const Point3> positions, std::span<Point3> gradient) {
        double total = shapes_.evaluate(positions, gradient) * weights_.shape;
        for (Point3& slope : gradient) slope = scaled(slope, weights_.shape);
        total += evaluatePlanes(surface_.coarseCentres(), pulls_, positions, gradient);
        total += evaluatePlanes(surface_.fineCentres(), pushes_, positions, gradient);
        return total;
    };
    positions_ = minimise(energy, std::move(positions_), iterations, 0.1 * edge_);
}

bool Fit::certify(int round) {
    associate();
    bool isProved = true;
    const auto uncovered = findUncovered(surface_, positions_, groups_, options_.margin);
    double deepest = 0;
    raise_.assign(groups_.groups().size(), 0);
    for (const Uncovered& group : uncovered) {
        if (group.depth > deepest) {
            deepest = group.depth;
            failure_ = concat("the point ", textOf(groups_.points()[group.point]),
                              " is not proved to be inside");
        }
        if (distance_[group.group] < -0.02 * edge_)
            pushOf_[group.group] = std::min(2 * pushOf_[group.group], 64.0);
        const double more = std::min(1.1 * group.depth, 0.05 * edge_) + 0.003 * edge_;
        const auto place = groups_.grid().coordinatesOf(groups_.groups()[group.group].centre);
        for (Index ring = 0; ring <= 2; ++ring)
            groups_.grid().forEachInRing(place, ring, [&](Index cube) {
                if (const Index near = groups_.inCube(cube); near >= 0)
                    raise_[near] = std::max(raise_[near], more * (1 - 0.25 * ring));
            });
        isProved = false;
    }
    for (std::size_t g = 0; g < raise_.size(); ++g) {
        if (raise_[g] == 0) continue;
        clearance_[g] = std::min(clearance_[g] + raise_[g], options_.margin + 0.25 * edge_);
        isRaised_[g] = 1;
    }
    if (std::getenv("FIT_TRACE") && uncovered.size() < 6)
        for (auto& u : uncovered) { auto& p=groups_.points()[u.point]; std::fprintf(stderr, "   group %d face %d (%.3f %.3f %.3f) depth %.4f distance %.4f clearance %.4f\n", u.group, u.face, p[0],p[1],p[2], u.depth/edge_, distance_[u.group]/edge_, clearance_[u.group]/edge_);}
    const solve::ValidityCheck check(parts_, positions_);
    if (std::getenv("FIT_TRACE"))
        std::fprintf(stderr, "round %d: uncovered %zu of %zu (depth %.4f), bad cells %zu\n", round,
                     uncovered.size(), groups_.groups().size(), deepest / edge_,
                     check.badAtRest().size());
    std::vector<char> isBad(shapes_.cellCount(), 0);
    for (const Index cell : check.badAtRest()) {
        isBad[cell] = 1;
        shapes_.scaleWeight(cell, 3);
        if (isProved) failure_ = concat("cell ", cell, " is not proved to be free of folds");
        isProved = false;
    }
    for (std::size_t c = 0; c < pull_.size(); ++c)
        if (isBad[surface_.cellOf(surface_.baseFaceOf(static_cast<Index>(c)))]) pull_[c] *= 0.5;
    return isProved;
}

std::vector<Point3> Fit::run() {
    Timer timer;
    for (int step = 0; step < 20; ++step) {
        associate();
        timer.lap("associate");
        optimise(step < 10 ? 8 : 20);
        timer.lap("optimise");
        if (std::getenv("FIT_TRACE")) {
            std::vector<Point3> g(positions_.size(), {0, 0, 0});
            const double q = shapes_.evaluate(positions_, g);
            const double a = evaluatePlanes(surface_.coarseCentres(), pulls_, positions_, g);
            const double b = evaluatePlanes(surface_.fineCentres(), pushes_, positions_, g);
            std::fprintf(stderr, "   shape %.3f pull %.3f push %.4f (%zu)\n", q * weights_.shape, a, b, pushes_.size());
        }
    }
    for (int round = 0; round < options_.maxRounds; ++round) {
        const bool isProved = certify(round);
        timer.lap("certify");
        if (isProved || (std::getenv("FIT_ANY") && round == options_.maxRounds - 1)) return std::move(positions_);
        for (int step = 0; step < 3; ++step) {
            associate();
            optimise(25);
        }
        timer.lap("repair");
    }
    throw Error(concat("fitting a cage of ", base_.level(0).complex.count(0),
                       " vertices: ", failure_, " after ", options_.maxRounds,
                       " rounds; try more vertices or a larger margin"));
}

}  // namespace

Lattice fitCage(Lattice start, std::span<const Point3> points, const FitOptions& options) {
    if (start.complex.dimension() != 3) throw Error("fitting a cage: the start is not a lattice");
    if (points.empty()) throw Error("fitting a cage: there are no points");
    if (!(options.margin >= 0 && options.margin <= 1e90))
        throw Error(concat("fitting a cage: the margin is ", options.margin,
                           "; expected a finite number, 0 or more"));
    if (std::ssize(start.positions) != start.complex.count(0))
        throw Error(concat("fitting a cage: got ", start.positions.size(), " positions for ",
                           start.complex.count(0), " vertices"));
    checkFinite(points, "point");
    checkFinite(start.positions, "vertex");
    Timer timer;
    Fit fit(start, points, options);
    timer.lap("setup");
    start.positions = fit.run();
    return start;
}

}  // namespace espalier::cages

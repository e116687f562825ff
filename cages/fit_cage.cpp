// SPDX-License-Identifier: Apache-2.0
#include "fit_cage.h"

#include <espalier/base/bounding_box.h>
#include <espalier/base/error.h>
#include <espalier/base/number_text.h>
#include <espalier/base/progress.h>
#include <espalier/base/vector3.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/solve/validity.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "boundary_forces.h"
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

/// The last kImprovements of the first rounds give more weight to cells with a scaled Jacobian
/// below kGoodJacobian. If a cell is below kLeastJacobian after the first proof, at most kPolishes
/// more rounds do the same. Better cells move the boundary, so other rounds repair the proof.
constexpr int kImprovements = 3, kPolishes = 3;
constexpr double kGoodJacobian = 0.3, kLeastJacobian = 0.28;

/// An attempt is lost if more groups of points than this, for each face of the boundary, stick out
/// by more than kFarOut edges. A face has about 64 groups beside it. Of 459 attempts around 413
/// models, the 418 that were proved had at most 0.13 after four steps, 0.2 after six, 0.15 before
/// the worst cells were improved, and 0.2 after it. Of 41 others, 29 had more, 17 of them after
/// four steps.
constexpr double kMaxFarOut = 0.2, kFarOut = 0.1;

/// An attempt is given up if a round of repair leaves more than kLeftOver of the failures of the
/// best round before. A few failures, kLastFailures, may come and go before the last one is
/// repaired. The 113 attempts around 108 models that were proved met this, after at most 6 rounds.
constexpr double kLeftOver = 0.6, kLastFailures = 4;

/// A round of repair is short if there are fewer failures than this.
constexpr std::size_t kFewFailures = 16;

/// Weight of the squared way, in edges, of the vertices that a round of repair moves, and that a
/// round moves that improves the worst cells. Without it, vertices beside thin parts run away until
/// cells fold. With it, and with all other vertices at rest, 108 models took 30 % less work, and
/// their cages are 2.3 % tighter.
constexpr double kHold = 3, kHoldPoor = 0.3;

/// Weight of the shape of a cell.
constexpr double kShape = 0.03;

void checkFinite(const Point3& point, const char* name, std::size_t number) {
    for (const double coordinate : point)
        if (!(std::abs(coordinate) <= 1e90))
            throw Error(concat(
                "fitting a cage: ", name, " ", number,
                std::isfinite(coordinate) ? " is too far from the origin" : " is not finite"));
}

/// Returns true if more rounds of repair will hardly help.
/// \param failures of all rounds so far: groups of points and cells without proof
/// \param most more failures than this in the first round are too many
bool isStuck(std::span<const std::size_t> failures, std::size_t most) {
    if (failures.front() > most) return true;
    if (failures.size() < 2) return false;
    const auto least = static_cast<double>(*std::min_element(failures.begin(), failures.end() - 1));
    return static_cast<double>(failures.back()) > kLeftOver * least + kLastFailures;
}

/// The state of a fit.
class Fit {
public:
    Fit(const Lattice& start, std::span<const FitPoint> points, const FitOptions& options,
        Work& work)
        : options_(options),
          work_(work),
          base_(start.complex, refinerOptions(start)),
          refiner_(refined()),
          surface_(base_),
          start_(symmetric(start.positions)),
          positions_(start_),
          edge_(meanEdge(start)),
          groups_(points, gridAround(start, points, std::max(edge_ / 8, options.margin / 2))),
          forces_(surface_, groups_, start, edge_, options.margin),
          shapes_(refiner_),
          boundaryFaceCount_(surface_.fineFaces().loops.size() >> 2 * CageSurface::kLevel) {}

    std::vector<Point3> run();

private:
    /// The end of an attempt. LostSoon: many points stuck out after the first steps.
    enum class Outcome { Proved, Failed, LostSoon };

    far::TopologyRefiner refined() const {
        far::TopologyRefiner refiner(base_.level(0), base_.options());
        refiner.refineUniform(CellShapes::kLevel);
        return refiner;
    }
    std::vector<Point3> symmetric(std::vector<Point3> positions) const {
        makeSymmetric(options_.mirrors, positions);
        return positions;
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
        for (std::size_t i = 0; i < points.size(); ++i) {
            checkCancelledEvery(i, 16);
            bounds.include(points[i].position);
        }
        return {bounds.min, bounds.max, size};
    }

    Outcome attempt(int number);
    void begin(int attempt);
    void match();
    static void addAnchor(double weight, std::span<const Point3> places,
                          std::span<const Point3> positions, double& energy,
                          std::span<Point3> gradient);
    void optimise(int iterations);
    void moveOnlyNear(std::span<const Index> cells, double hold);
    void improve(int steps, int iterations);
    bool certify();
    std::vector<Index> unprovedCells();
    std::vector<Index> foldedCells();
    std::vector<Index> favourPoorCells();
    double leastJacobian();
    double polish();
    void requireNear() const;
    bool isLost();
    double enclosedVolume() const;

    const FitOptions& options_;
    Work& work_;
    far::TopologyRefiner base_, refiner_;
    CageSurface surface_;
    std::vector<Point3> start_, positions_;
    double edge_;
    PointGroups groups_;
    BoundaryForces forces_;
    CellShapes shapes_;
    std::size_t boundaryFaceCount_;  ///< of level 0
    double startVolume_ = enclosedVolume();
    std::optional<limit::LimitParts> parts_;  ///< made when no point is left outside
    double anchor_ = 0;             ///< weight of the squared way of a vertex from the start
    double hold_ = 0;               ///< weight of the squared way since the last match
    std::vector<char> isFixed_;     ///< per vertex; empty: all vertices move
    std::size_t failureCount_ = 0;  ///< groups and cells without proof at the last certify()
    std::string failure_;
};

void Fit::begin(int attempt) {
    const double pull = attempt + 1 < kAttempts ? std::pow(0.3, attempt) : 0;
    positions_ = start_;
    anchor_ = 0.001 * std::pow(4, attempt) / (edge_ * edge_);
    hold_ = 0;
    isFixed_.clear();
    shapes_.resetWeights();
    forces_.reset(pull);
    match();
}

void Fit::match() {
    work_.add(forces_.workOfMatch());
    forces_.match(positions_);
    work_.add(forces_.workOfPulls());
}

/// Adds the weighted squares of the ways of all vertices from some places.
void Fit::addAnchor(double weight, std::span<const Point3> places,
                    std::span<const Point3> positions, double& energy, std::span<Point3> gradient) {
    if (weight == 0) return;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const Point3 way = difference(positions[i], places[i]);
        energy += weight * dot(way, way);
        gradient[i] = sum(gradient[i], scaled(way, 2 * weight));
    }
}

void Fit::optimise(int iterations) {
    const std::vector<Point3> before = positions_;
    const double steps = shapes_.workOfEvaluation() + forces_.workOfEnergy();
    const Energy energy = [&](std::span<const Point3> positions, std::span<Point3> gradient) {
        work_.add(steps);
        double total = shapes_.evaluate(positions, gradient) * kShape;
        for (Point3& slope : gradient) slope = scaled(slope, kShape);
        addAnchor(anchor_, start_, positions, total, gradient);
        addAnchor(hold_, before, positions, total, gradient);
        forces_.addEnergy(positions, total, gradient);
        makeGradientSymmetric(options_.mirrors, gradient);
        for (std::size_t i = 0; i < isFixed_.size(); ++i)
            if (isFixed_[i] != 0) gradient[i] = {0, 0, 0};
        return total;
    };
    forces_.renew();
    positions_ = symmetric(minimise(energy, std::move(positions_), iterations, 0.1 * edge_));
}

/// Moves the vertices. The forces then match their new positions.
void Fit::improve(int steps, int iterations) {
    for (int step = 0; step < steps; ++step) {
        optimise(iterations);
        match();
    }
}

/// Tries to prove the lattice. Where that fails, makes room for points and gives more weight to
/// cells.
bool Fit::certify() {
    work_.add(workOfCoverage(surface_, groups_));
    const auto uncovered = findUncovered(surface_, positions_, groups_, options_.margin);
    double deepest = 0;
    for (const Uncovered& group : uncovered)
        if (group.depth > deepest) {
            deepest = group.depth;
            failure_ = concat("the point ", textOf(groups_.points()[group.point]),
                              group.winding > 1 ? " is not proved to be inside only once"
                                                : " is not proved to be inside");
        }
    forces_.strengthen(uncovered);
    const std::vector<Index> badCells = uncovered.empty() ? unprovedCells() : foldedCells();
    failureCount_ = uncovered.size() + badCells.size();
    if (uncovered.empty() && !badCells.empty())
        failure_ = concat("cell ", badCells.front(), " is not proved to be free of folds");
    shapes_.examine(badCells);
    std::vector<char> isNearBad(shapes_.cellCount(), 0);
    const far::CellComplex& complex = base_.level(0).complex;
    for (const Index cell : badCells) {
        shapes_.scaleWeight(cell, 2);
        for (const Index vertex : complex.relation(3, 0)[cell])
            for (const Index near : complex.relation(0, 3)[vertex]) isNearBad[near] = 1;
    }
    for (Index cell = 0; cell < shapes_.cellCount(); ++cell)
        if (isNearBad[cell]) shapes_.scaleWeight(cell, 1.5);
    forces_.weakenPulls(isNearBad, 0.5);
    std::vector<Index> failed = badCells;
    for (const Uncovered& group : uncovered) {
        if (group.cell) failed.push_back(*group.cell);
        if (const auto cell = forces_.pushedCell(group.group)) failed.push_back(*cell);
    }
    moveOnlyNear(failed, kHold);
    return failureCount_ == 0;
}

/// From now on, only the vertices of some cells and of their neighbours move, and their mirror
/// images: the limits of the faces of these cells depend on them.
/// \param hold weight of the squared way from where they are, in edges
void Fit::moveOnlyNear(std::span<const Index> cells, double hold) {
    const far::CellComplex& complex = base_.level(0).complex;
    hold_ = hold / (edge_ * edge_);
    isFixed_.assign(positions_.size(), 1);
    for (const Index cell : cells)
        for (const Index corner : complex.relation(3, 0)[cell])
            for (const Index near : complex.relation(0, 3)[corner])
                for (const Index vertex : complex.relation(3, 0)[near]) isFixed_[vertex] = 0;
    for (const VertexMirror& mirror : options_.mirrors)
        for (std::size_t vertex = 0; vertex < isFixed_.size(); ++vertex)
            if (isFixed_[mirror.images[vertex]] == 0) isFixed_[vertex] = 0;
}

/// Returns the cells that are not proved to be free of folds.
std::vector<Index> Fit::unprovedCells() {
    constexpr double kPerCell = 100e3;
    work_.add(kPerCell * shapes_.cellCount());
    if (!parts_) parts_.emplace(base_, options_.levelOfParts);
    return solve::ValidityCheck(*parts_, positions_).badAtRest();
}

/// Returns cells that are folded: some of the cells without proof, in much less time.
std::vector<Index> Fit::foldedCells() {
    std::vector<Index> folded;
    const std::vector<double> shapes = shapes_.leastJacobians(positions_);
    for (Index cell = 0; cell < shapes_.cellCount(); ++cell)
        if (!(shapes[cell] > 0)) folded.push_back(cell);
    return folded;
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

/// Gives more weight to poor cells, and less to the pulls on their faces. Returns these cells.
std::vector<Index> Fit::favourPoorCells() {
    const far::CellComplex& complex = base_.level(0).complex;
    const std::vector<double> shapes = shapes_.leastJacobians(positions_);
    std::vector<Index> poor;
    std::vector<char> isPoor(shapes.size(), 0);
    for (Index cell = 0; cell < shapes_.cellCount(); ++cell) {
        if (shapes[cell] >= kGoodJacobian) continue;
        poor.push_back(cell);
        isPoor[cell] = 1;
        shapes_.scaleWeight(cell, 2);
        for (const Index face : complex.relation(3, 2)[cell])
            for (const Index near : complex.relation(2, 3)[face]) shapes_.scaleWeight(near, 1.2);
    }
    shapes_.examine(poor);
    forces_.weakenPulls(isPoor, 0.6);
    return poor;
}

double Fit::leastJacobian() {
    const std::vector<double> shapes = shapes_.leastJacobians(positions_);
    return *std::min_element(shapes.begin(), shapes.end());
}

/// Improves the worst cells of a lattice that is proved. Returns the least scaled Jacobian.
double Fit::polish() {
    double best = leastJacobian();
    std::vector<Point3> kept = positions_;
    bool isProved = true;
    std::vector<std::size_t> failures;
    for (int polishes = 0, repairs = 0; best < kLeastJacobian;) {
        if (isProved) {
            if (polishes++ == kPolishes) break;
            moveOnlyNear(favourPoorCells(), kHoldPoor);
            failures.clear();
        } else {
            failures.push_back(failureCount_);
            if (repairs++ == options_.maxRounds || isStuck(failures, boundaryFaceCount_)) break;
        }
        try {
            improve(2, 7);
            isProved = certify();
        } catch (const WorkError&) {
            break;
        }
        const double least = leastJacobian();
        if (isProved && least > best) {
            best = least;
            kept = positions_;
        }
    }
    positions_ = std::move(kept);
    return best;
}

/// Returns true if too many points are outside the cage for a proof to succeed later.
bool Fit::isLost() {
    const Index count = forces_.countOutside(kFarOut * edge_);
    if (count <= kMaxFarOut * static_cast<double>(boundaryFaceCount_)) return false;
    failure_ = "many points stick out";
    return true;
}

/// Fits and proves the lattice, with less pull than the attempt before. The last one only pushes.
Fit::Outcome Fit::attempt(int number) {
    begin(number);
    // Steps are short: with more iterations between two matches, cells fold, and fewer lattices are
    // proved.
    improve(4, 6);
    if (isLost()) return Outcome::LostSoon;
    improve(2, 6);
    if (isLost()) return Outcome::LostSoon;
    improve(3, 8);
    if (isLost()) return Outcome::Failed;
    for (int round = 0; round < kImprovements; ++round) {
        favourPoorCells();
        improve(1, 10);
    }
    if (isLost()) return Outcome::Failed;
    std::vector<std::size_t> failures;
    for (int round = 0; round < options_.maxRounds; ++round) {
        if (!(enclosedVolume() <= kMaxGrowth * startVolume_)) {
            failure_ = concat("it grows to more than ", textOf(kMaxGrowth), " times its volume");
            return Outcome::Failed;
        }
        if (certify()) return Outcome::Proved;
        failures.push_back(failureCount_);
        if (isStuck(failures, boundaryFaceCount_)) return Outcome::Failed;
        improve(2, failureCount_ < kFewFailures ? 7 : 12);
    }
    return Outcome::Failed;
}

std::vector<Point3> Fit::run() {
    if (!(startVolume_ > 0)) throw Error("fitting a cage: the start lattice is inside out");
    requireNear();
    std::vector<Point3> kept;
    double best = -1;
    try {
        int last = options_.maxAttempts - 1;
        for (int number = 0; number <= last; ++number) {
            const Outcome outcome = attempt(number);
            // A little less pull does not help then. The last attempt does not pull.
            if (outcome == Outcome::LostSoon) number = std::max(number, kAttempts - 2);
            if (outcome != Outcome::Proved) continue;
            const double jacobian = polish();
            if (jacobian > best) {
                best = jacobian;
                kept = positions_;
            }
            if (best >= kLeastJacobian) break;
            // The next attempt may have better cells. Those after it pull too little.
            last = std::min(last, number + 1);
        }
    } catch (const WorkError&) {
        if (kept.empty()) throw;
    }
    if (!kept.empty()) return kept;
    throw FitError(
        concat("fitting a cage of ", base_.level(0).complex.count(0), " vertices: ", failure_));
}

}  // namespace

Lattice fitCage(Lattice start, std::vector<FitPoint> points, const FitOptions& options,
                Work& work) {
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
        checkCancelledEvery(i, 16);
        checkFinite(points[i].position, "point", i);
        const auto cell = points[i].cell;
        if (cell && (*cell < 0 || *cell >= start.complex.count(3)))
            throw Error(concat("fitting a cage: point ", i, " belongs to cell ", *cell,
                               "; expected 0 to ", start.complex.count(3) - 1));
    }
    for (std::size_t i = 0; i < start.positions.size(); ++i)
        checkFinite(start.positions[i], "vertex", i);
    const auto isStart = [&](const Point3& p) { return p == start.positions.front(); };
    if (std::all_of(start.positions.begin(), start.positions.end(), isStart))
        throw Error("fitting a cage: all vertices of the start are at one place");
    Fit fit(start, points, options, work);
    points = {};
    start.positions = fit.run();
    return start;
}

}  // namespace espalier::cages

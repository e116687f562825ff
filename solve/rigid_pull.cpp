// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/argument_error.h>
#include <espalier/base/bounding_box.h>
#include <espalier/base/parallel.h>
#include <espalier/base/vector3.h>
#include <espalier/shapes/cell_distances.h>
#include <espalier/solve/rigid_pull.h>

#include <Eigen/Dense>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "cancellable_ldlt.h"
#include "fold_barrier.h"
#include "quasi_newton.h"
#include "rotation_fit.h"

namespace espalier::solve {
namespace {

using Columns = Eigen::MatrixX3d;
using Matrix = Eigen::SparseMatrix<double>;
using Vector = Eigen::Vector3d;
using stencils::StencilTable;

constexpr double kMaxSize = 1e90;  // The cube is the largest number in E.

Vector vectorOf(const Point3& point) {
    return {point[0], point[1], point[2]};
}

/// A motion x → rotation · (x − from) + to.
struct Motion {
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    Vector from = Vector::Zero(), to = Vector::Zero();

    Vector operator()(const Vector& x) const { return rotation * (x - from) + to; }
};

/// Returns the smallest rotation that takes one unit vector to another.
Eigen::Matrix3d rotationBetween(const Vector& from, const Vector& to) {
    return Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
}

/// Returns the motion that moves points to targets best. If the points are on a line, it does not
/// turn about the line.
Motion fittingMotion(const std::vector<std::pair<Vector, Vector>>& handles) {
    Motion motion;
    for (const auto& [point, target] : handles) {
        motion.from += point;
        motion.to += target;
    }
    const auto count = static_cast<double>(handles.size());
    if (handles.empty()) return motion;
    motion.from /= count;
    motion.to /= count;
    Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
    for (const auto& [point, target] : handles)
        moments += (target - motion.to) * (point - motion.from).transpose();
    const Eigen::JacobiSVD<Eigen::Matrix3d> parts(moments,
                                                  Eigen::ComputeFullU | Eigen::ComputeFullV);
    constexpr double kFlat = 1e-9;  // Rounding of the moments.
    const Vector& sizes = parts.singularValues();
    if (sizes[1] > kFlat * sizes[0])
        motion.rotation = rotationBySingularValues(moments);
    else if (sizes[0] > 0)
        motion.rotation = rotationBetween(parts.matrixV().col(0), parts.matrixU().col(0));
    return motion;
}

/// Returns true for each index that is listed.
std::vector<char> marked(const std::string& field, std::span<const Index> indices, Index count,
                         const std::string& what) {
    std::vector<char> isMarked(count, 0);
    for (std::size_t i = 0; i < indices.size(); ++i) {
        if (indices[i] < 0 || indices[i] >= count)
            throw ArgumentError("", concat(field, "[", i, "]"), std::to_string(indices[i]),
                                concat(what, ", 0 to ", count - 1));
        isMarked[indices[i]] = 1;
    }
    return isMarked;
}

void check(const far::CellComplex& base, std::span<const Point3> rest,
           const StencilTable<double>& deformation, const RigidPullOptions& options) {
    if (base.dimension() != 3 || base.count(3) == 0)
        throw Error("expected a lattice: a complex with cells");
    if (std::ssize(rest) != base.count(0))
        throw Error(concat("got ", rest.size(), " positions for the ", base.count(0),
                           " vertices of the lattice"));
    for (std::size_t v = 0; v < rest.size(); ++v)
        for (const double coordinate : rest[v])
            if (!std::isfinite(coordinate))
                throw Error(concat("the position of vertex ", v, " is not finite"));
    if (!(BoundingBox(rest).diagonal() <= kMaxSize))
        throw Error("the vertices of the lattice are more than 1e90 apart");
    if (deformation.columnCount() != base.count(0))
        throw Error(concat("the points are bound to ", deformation.columnCount(),
                           " vertices; the lattice has ", base.count(0)));
    for (Index row = 0; row < deformation.rowCount(); ++row) {
        for (const double weight : deformation.weights(row))
            if (!std::isfinite(weight))
                throw Error(concat("point ", row, " has a weight that is not finite"));
        if (deformation.columns(row).empty())
            throw Error(concat("point ", row, " is pulled, but lies outside the lattice"));
    }
    if (!(options.reach >= 0 && options.reach <= 1))
        throw ArgumentError("", "reach", textOf(options.reach), "0 to 1");
    if (!(options.tolerance >= 0 && std::isfinite(options.tolerance)))
        throw ArgumentError("", "tolerance", textOf(options.tolerance),
                            "a finite number of 0 or more");
    if (options.maxIterations < 1)
        throw ArgumentError("", "maxIterations", std::to_string(options.maxIterations),
                            "1 or more");
}

}  // namespace

struct RigidPull::Data {
    RigidPullOptions options;
    double diagonal = 0;
    std::vector<Vector> rest;
    std::vector<Index> fixed;
    std::vector<Index> freeOf;  ///< the number of each vertex among the free ones; −1 if fixed
    Index freeCount = 0;

    // The cells: their vertices in CSR, and p − p̄ of each.
    std::vector<Index> starts = {0}, corners;
    std::vector<Vector> offsets;
    std::vector<double> weights;  ///< w_c

    StencilTable<double> deformation;
    std::vector<Vector> points;  ///< at rest
    double pullWeight = 0;       ///< part of s² that is in the factored matrix
    double softness = 0;         ///< 1 / (the rest of s²)
    CancellableLdlt factor;
    Eigen::MatrixXd responses;                ///< factor⁻¹ Dᵀ
    Eigen::LDLT<Eigen::MatrixXd> compliance;  ///< D factor⁻¹ Dᵀ + softness

    // The same for the pulls of poses at the barrier, which are softer.
    FoldBarrier barrier;
    double softPull = 0;
    double maxStep = 0;  ///< of a vertex, so that no cell jumps through a fold and out behind it
    Eigen::LDLT<Eigen::MatrixXd> softCompliance;

    Index cellCount() const { return static_cast<Index>(weights.size()); }

    void addCells(const far::CellComplex& base);
    void findFixed(const far::CellComplex& base, std::span<const Point3> positions);
    void factorMatrix();
    Columns startFrom(std::span<const Point3> misses) const;
    void rotate(const Columns& moved, std::vector<Eigen::Matrix3d>& rotations) const;
    Columns rightSide(const std::vector<Eigen::Matrix3d>& rotations, const Columns& misses) const;
    Columns solution(const Columns& right, const Columns& misses) const;
    Columns missesOf(const Columns& moved, const Columns& misses) const;
    double elastic(const Columns& moved, const std::vector<Eigen::Matrix3d>& rotations,
                   Columns* gradient = nullptr) const;
    Columns freeRows(const Columns& all) const;
    Columns allRows(const Columns& free) const;
    double softEnergy(const Columns& moved, const Columns& misses, Columns& gradient) const;
    Columns softSolution(const Columns& gradient) const;
    int unfold(Columns& moved, const Columns& begin, const Columns& misses) const;
};

void RigidPull::Data::addCells(const far::CellComplex& base) {
    double total = 0;
    for (Index cell = 0; cell < base.count(3); ++cell) {
        const auto vertices = base.relation(3, 0)[cell];
        Vector middle = Vector::Zero();
        // Relative to the first vertex, so that a lattice far from the origin loses no digits.
        for (const Index vertex : vertices) middle += rest[vertex] - rest[vertices[0]];
        middle /= static_cast<double>(vertices.size());
        double square = 0;
        for (const Index vertex : vertices) {
            corners.push_back(vertex);
            offsets.push_back(rest[vertex] - rest[vertices[0]] - middle);
            square += offsets.back().squaredNorm();
        }
        starts.push_back(static_cast<Index>(corners.size()));
        weights.push_back(std::sqrt(square / static_cast<double>(vertices.size())));
        total += weights.back();
    }
    if (!(total > 0)) throw Error("all vertices of the lattice are at one place");
    // A cell that is a point holds its vertices together.
    constexpr double kLeast = 1e-6;
    for (double& weight : weights)
        weight = std::max(weight, kLeast * total / static_cast<double>(weights.size()));
    maxStep = 0.5 * total / static_cast<double>(weights.size());
}

/// Finds the vertices that stay, from the options and the reach.
void RigidPull::Data::findFixed(const far::CellComplex& base, std::span<const Point3> positions) {
    auto isFixed = marked("frozen", options.frozen, base.count(0), "a vertex");
    const auto isPin = marked("pins", options.pins, deformation.rowCount(), "a row");
    std::vector<shapes::WayStart> ways;
    for (Index row = 0; row < deformation.rowCount(); ++row)
        for (const Index vertex : deformation.columns(row))
            if (isPin[row] == 0) ways.push_back({vertex, (rest[vertex] - points[row]).norm()});
    const auto distances = shapes::distancesAlongCells(base, positions, ways);
    double farthest = 0;
    for (const double distance : distances)
        if (std::isfinite(distance)) farthest = std::max(farthest, distance);
    std::vector<char> isNeeded(isFixed.size(), 0);
    constexpr double kNeeded = 0.25;
    for (Index row = 0; row < deformation.rowCount(); ++row) {
        const auto columns = deformation.columns(row);
        const auto values = deformation.weights(row);
        const double largest = *std::ranges::max_element(values);
        for (std::size_t a = 0; a < columns.size(); ++a)
            if (isPin[row] == 0 && values[a] >= kNeeded * largest) isNeeded[columns[a]] = 1;
    }
    for (std::size_t v = 0; v < distances.size(); ++v)
        if (!(distances[v] <= options.reach * farthest) && isNeeded[v] == 0) isFixed[v] = 1;
    freeOf.assign(isFixed.size(), -1);
    for (std::size_t v = 0; v < isFixed.size(); ++v)
        if (isFixed[v] != 0)
            fixed.push_back(static_cast<Index>(v));
        else
            freeOf[v] = freeCount++;
    for (Index row = 0; row < deformation.rowCount(); ++row) {
        const auto columns = deformation.columns(row);
        if (isPin[row] == 0 &&
            std::ranges::all_of(columns, [&](Index vertex) { return freeOf[vertex] < 0; }))
            throw Error(concat("point ", row,
                               " is pulled, but all vertices that move it are frozen, such as "
                               "vertex ",
                               columns[0]));
    }
}

void RigidPull::Data::factorMatrix() {
    if (freeCount == 0) return;
    std::vector<Eigen::Triplet<double>> entries;
    double diagonalSum = 0;
    for (Index cell = 0; cell < cellCount(); ++cell) {
        const auto count = static_cast<double>(starts[cell + 1] - starts[cell]);
        for (Index a = starts[cell]; a < starts[cell + 1]; ++a)
            for (Index b = starts[cell]; b < starts[cell + 1]; ++b) {
                const Index row = freeOf[corners[a]], column = freeOf[corners[b]];
                if (row < 0 || column < 0) continue;
                const double value = weights[cell] * ((a == b ? 1 : 0) - 1 / count);
                entries.emplace_back(row, column, value);
                if (a == b) diagonalSum += value;
            }
    }
    pullWeight = diagonalSum / freeCount;
    constexpr double kRest = 1e8;
    softness = 1 / (kRest * pullWeight);
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(freeCount, deformation.rowCount());
    for (Index row = 0; row < deformation.rowCount(); ++row) {
        const auto columns = deformation.columns(row);
        const auto values = deformation.weights(row);
        for (std::size_t a = 0; a < columns.size(); ++a) {
            if (freeOf[columns[a]] < 0) continue;
            rows(freeOf[columns[a]], row) += values[a];
            for (std::size_t b = 0; b < columns.size(); ++b)
                if (freeOf[columns[b]] >= 0)
                    entries.emplace_back(freeOf[columns[a]], freeOf[columns[b]],
                                         pullWeight * values[a] * values[b]);
        }
    }
    Matrix matrix(freeCount, freeCount);
    matrix.setFromTriplets(entries.begin(), entries.end());
    factor.compute(matrix);
    if (factor.info() != Eigen::Success) throw Error("the matrix of the pull cannot be factored");
    responses = factor.solve(rows);
    Eigen::MatrixXd small = rows.transpose() * responses;
    const Eigen::Index count = small.rows();
    const auto identity = Eigen::MatrixXd::Identity(count, count);
    compliance.compute(small + softness * identity);
    // Reaches targets up to about 1e-3 of an edge, without crushing cells where that cannot be had.
    constexpr double kSoft = 1e3;
    softPull = kSoft * pullWeight;
    softCompliance.compute(small + 1 / (softPull - pullWeight) * identity);
}

/// Returns the displacements where the iteration begins.
Columns RigidPull::Data::startFrom(std::span<const Point3> misses) const {
    Columns start = Columns::Zero(static_cast<Eigen::Index>(rest.size()), 3);
    std::vector<std::pair<Vector, Vector>> handles;
    for (const Index vertex : fixed) handles.emplace_back(rest[vertex], rest[vertex]);
    for (std::size_t k = 0; k < points.size(); ++k)
        handles.emplace_back(points[k], points[k] + vectorOf(misses[k]));
    const Motion motion = fittingMotion(handles);
    if (!fixed.empty()) {
        double miss = 0, way = 0;
        for (const auto& [point, target] : handles) {
            miss = std::max(miss, (motion(point) - target).norm());
            way = std::max(way, (point - target).norm());
        }
        constexpr double kRigid = 1e-9;  // Rounding of positions, of the size of the lattice.
        if (!(miss <= kRigid * std::max(way, diagonal))) return start;
    }
    for (std::size_t v = 0; v < rest.size(); ++v)
        if (freeOf[v] >= 0)
            start.row(static_cast<Eigen::Index>(v)) = (motion(rest[v]) - rest[v]).transpose();
    return start;
}

/// Finds the best rotations of the cells.
void RigidPull::Data::rotate(const Columns& moved, std::vector<Eigen::Matrix3d>& rotations) const {
    rotations.resize(cellCount());
    constexpr Offset kCells = 256;
    parallelFor(cellCount(), kCells, [&](Offset first, Offset last) {
        for (auto cell = static_cast<Index>(first); cell < last; ++cell) {
            Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
            // The mean of the displacements does not matter, because the offsets sum to 0.
            const Vector base = moved.row(corners[starts[cell]]);
            for (Index a = starts[cell]; a < starts[cell + 1]; ++a) {
                const Vector target = offsets[a] + moved.row(corners[a]).transpose() - base;
                moments += target * offsets[a].transpose();
            }
            rotations[cell] = nearestRotation(moments);
        }
    });
}

/// Returns the right side of the equations of the free vertices: the derivatives of E at d = 0,
/// with the opposite sign and halved.
Columns RigidPull::Data::rightSide(const std::vector<Eigen::Matrix3d>& rotations,
                                   const Columns& misses) const {
    Columns right = Columns::Zero(freeCount, 3);
    for (Index cell = 0; cell < cellCount(); ++cell)
        for (Index a = starts[cell]; a < starts[cell + 1]; ++a)
            if (const Index row = freeOf[corners[a]]; row >= 0)
                right.row(row) +=
                    (weights[cell] * (rotations[cell] * offsets[a] - offsets[a])).transpose();
    for (Index k = 0; k < deformation.rowCount(); ++k) {
        const auto columns = deformation.columns(k);
        for (std::size_t a = 0; a < columns.size(); ++a)
            if (const Index row = freeOf[columns[a]]; row >= 0)
                right.row(row) += pullWeight * deformation.weights(k)[a] * misses.row(k);
    }
    return right;
}

/// Returns D d − m.
Columns RigidPull::Data::missesOf(const Columns& moved, const Columns& misses) const {
    Columns left = -misses;
    for (Index k = 0; k < deformation.rowCount(); ++k) {
        const auto columns = deformation.columns(k);
        for (std::size_t a = 0; a < columns.size(); ++a)
            left.row(k) += deformation.weights(k)[a] * moved.row(columns[a]);
    }
    return left;
}

/// Returns the displacements of all vertices that minimise E for given rotations. The rest of s² is
/// a constraint with a small compliance, which keeps the digits that a large weight would cost.
Columns RigidPull::Data::solution(const Columns& right, const Columns& misses) const {
    const Columns free = factor.solve(right);
    if (deformation.rowCount() == 0) return allRows(free);
    const Columns forces = compliance.solve(Columns(-missesOf(allRows(free), misses)));
    return allRows(free + responses * forces);
}

/// Returns the rows of the free vertices.
Columns RigidPull::Data::freeRows(const Columns& all) const {
    Columns free(freeCount, 3);
    for (std::size_t v = 0; v < rest.size(); ++v)
        if (freeOf[v] >= 0) free.row(freeOf[v]) = all.row(static_cast<Eigen::Index>(v));
    return free;
}

/// Returns the rows of all vertices, of which the fixed ones are 0.
Columns RigidPull::Data::allRows(const Columns& free) const {
    Columns all = Columns::Zero(static_cast<Eigen::Index>(rest.size()), 3);
    for (std::size_t v = 0; v < rest.size(); ++v)
        if (freeOf[v] >= 0) all.row(static_cast<Eigen::Index>(v)) = free.row(freeOf[v]);
    return all;
}

/// Returns the first sum of E. Adds its derivatives by the vertices to `gradient`, if given. The
/// rotations are the best ones, so that derivatives by the rotations are 0.
double RigidPull::Data::elastic(const Columns& moved, const std::vector<Eigen::Matrix3d>& rotations,
                                Columns* gradient) const {
    double energy = 0;
    for (Index cell = 0; cell < cellCount(); ++cell) {
        const Vector base = moved.row(corners[starts[cell]]);
        Vector middle = Vector::Zero();
        for (Index a = starts[cell]; a < starts[cell + 1]; ++a)
            middle += moved.row(corners[a]).transpose() - base;
        middle /= static_cast<double>(starts[cell + 1] - starts[cell]);
        for (Index a = starts[cell]; a < starts[cell + 1]; ++a) {
            const Vector miss = offsets[a] + moved.row(corners[a]).transpose() - base - middle -
                                rotations[cell] * offsets[a];
            energy += weights[cell] * miss.squaredNorm();
            // The misses of a cell sum to 0, so that the mean of the vertices does not matter.
            if (gradient != nullptr)
                gradient->row(corners[a]) += (2 * weights[cell] * miss).transpose();
        }
    }
    return energy;
}

/// Returns E with the barrier and soft pulls. Sets its derivatives, unless it is infinite.
double RigidPull::Data::softEnergy(const Columns& moved, const Columns& misses,
                                   Columns& gradient) const {
    Columns all = Columns::Zero(moved.rows(), 3);
    double energy = barrier.energy(moved, &all);
    if (!std::isfinite(energy)) return energy;
    std::vector<Eigen::Matrix3d> rotations;
    rotate(moved, rotations);
    energy += elastic(moved, rotations, &all);
    const Columns left = missesOf(moved, misses);
    for (Index k = 0; k < deformation.rowCount(); ++k) {
        const auto columns = deformation.columns(k);
        for (std::size_t a = 0; a < columns.size(); ++a)
            all.row(columns[a]) += 2 * softPull * deformation.weights(k)[a] * left.row(k);
    }
    gradient = freeRows(all);
    return energy + softPull * left.squaredNorm();
}

/// Returns the displacements of the free vertices whose derivatives of E without the barrier, with
/// given rotations and soft pulls, differ by `gradient`.
Columns RigidPull::Data::softSolution(const Columns& gradient) const {
    const Columns free = factor.solve(Columns(0.5 * gradient));
    if (deformation.rowCount() == 0) return free;
    const Columns none = Columns::Zero(deformation.rowCount(), 3);
    return free + responses * softCompliance.solve(Columns(-missesOf(allRows(free), none)));
}

/// Takes a pose that may fold cells to a minimum of softEnergy(). Starts at `begin`, such as the
/// last frame of a drag, or if cells fold there, at the best of the poses on the way from rest.
/// \returns the number of iterations
int RigidPull::Data::unfold(Columns& moved, const Columns& begin, const Columns& misses) const {
    Columns best = begin;
    if (begin.isZero(0) || !std::isfinite(barrier.energy(begin))) {
        Columns unused;
        best.setZero();
        double least = softEnergy(best, misses, unused);
        // Only up to the first fold: behind it, cells may be inside out that the barrier does not
        // show.
        constexpr int kParts = 16;
        for (int part = 1; part <= kParts; ++part) {
            const Columns other = static_cast<double>(part) / kParts * moved;
            const double energy = softEnergy(other, misses, unused);
            if (!std::isfinite(energy)) break;
            if (energy < least) {
                least = energy;
                best = other;
            }
        }
    }
    Columns free = freeRows(best);
    const int iterations = minimise(
        free,
        [&](const Columns& x, Columns& gradient) {
            return softEnergy(allRows(x), misses, gradient);
        },
        [&](const Columns& gradient) { return softSolution(gradient); },
        {options.tolerance * diagonal, maxStep, options.maxIterations});
    moved = allRows(free);
    return iterations;
}

RigidPull::RigidPull(const far::CellComplex& base, std::span<const Point3> rest,
                     const StencilTable<double>& deformation, const RigidPullOptions& options) {
    check(base, rest, deformation, options);
    const auto data = std::make_shared<Data>();
    data->options = options;
    data->diagonal = BoundingBox(rest).diagonal();
    for (const Point3& position : rest) data->rest.push_back(vectorOf(position));
    data->deformation = deformation;
    for (Index row = 0; row < deformation.rowCount(); ++row) {
        const auto columns = deformation.columns(row);
        Vector point = Vector::Zero();
        for (std::size_t a = 0; a < columns.size(); ++a) {
            point +=
                deformation.weights(row)[a] * (data->rest[columns[a]] - data->rest[columns[0]]);
        }
        data->points.push_back(data->rest[columns[0]] + point);
    }
    data->addCells(base);
    data->findFixed(base, rest);
    data->factorMatrix();
    if (options.preventsFolds) {
        std::vector<char> isFixed;
        for (const Index free : data->freeOf) isFixed.push_back(static_cast<char>(free < 0));
        data->barrier = FoldBarrier(far::TopologyRefiner(base), rest, isFixed);
    }
    data_ = data;
}

const std::vector<Index>& RigidPull::fixedVertices() const {
    return data_->fixed;
}

RigidPose RigidPull::solve(std::span<const Point3> misses, std::span<const Point3> start) const {
    const Data& data = *data_;
    if (misses.size() != data.points.size())
        throw Error(concat("got ", misses.size(), " targets for ", data.points.size(), " points"));
    if (!start.empty() && start.size() != data.rest.size())
        throw Error(concat("got ", start.size(), " displacements to start from for ",
                           data.rest.size(), " vertices"));
    Columns wanted(static_cast<Eigen::Index>(misses.size()), 3);
    for (std::size_t k = 0; k < misses.size(); ++k) {
        if (!(length(misses[k]) <= kMaxSize))
            throw TargetError(
                static_cast<Index>(k),
                concat("the target of point ", k,
                       std::isfinite(length(misses[k])) ? " is more than 1e90 away from the point"
                                                        : " is not finite"));
        wanted.row(static_cast<Eigen::Index>(k)) = vectorOf(misses[k]).transpose();
    }
    RigidPose pose;
    pose.displacements.assign(data.rest.size(), Point3{});
    if ((start.empty() && wanted.isZero(0)) || data.freeCount == 0) return pose;
    Columns moved = Columns::Zero(static_cast<Eigen::Index>(data.rest.size()), 3);
    if (start.empty())
        moved = data.startFrom(misses);
    else
        for (std::size_t v = 0; v < start.size(); ++v) {
            if (!(length(start[v]) <= kMaxSize))
                throw Error(concat("the displacement of vertex ", v,
                                   " to start from is not finite or larger than 1e90"));
            if (data.freeOf[v] >= 0)
                moved.row(static_cast<Eigen::Index>(v)) = vectorOf(start[v]).transpose();
        }
    const Columns begin = moved;
    std::vector<Eigen::Matrix3d> rotations;
    while (pose.iterations < data.options.maxIterations) {
        checkCancelled();
        ++pose.iterations;
        data.rotate(moved, rotations);
        const Columns next = data.solution(data.rightSide(rotations, wanted), wanted);
        const double change = (next - moved).rowwise().norm().maxCoeff();
        moved = next;
        if (change <= data.options.tolerance * data.diagonal) break;
    }
    if (data.barrier.energy(moved) > 0) {
        pose.meetsBarrier = true;
        pose.iterations += data.unfold(moved, begin, wanted);
    }
    data.rotate(moved, rotations);
    const Eigen::VectorXd distances = data.missesOf(moved, wanted).rowwise().norm();
    if (distances.size() > 0) {
        pose.largestMiss = distances.maxCoeff();
        pose.rmsMiss = distances.norm() / std::sqrt(static_cast<double>(distances.size()));
    }
    pose.energy = data.elastic(moved, rotations) +
                  (data.pullWeight + 1 / data.softness) * distances.squaredNorm();
    for (std::size_t v = 0; v < pose.displacements.size(); ++v)
        for (std::size_t c = 0; c < 3; ++c)
            pose.displacements[v][c] =
                moved(static_cast<Eigen::Index>(v), static_cast<Eigen::Index>(c));
    return pose;
}

}  // namespace espalier::solve

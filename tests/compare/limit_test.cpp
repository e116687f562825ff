// SPDX-License-Identifier: Apache-2.0
#include <espalier/limit/limit_binding.h>
#include <espalier/limit/vertex_limits.h>
#include <espalier/limit/vertex_ring.h>
#include <opensubdiv/far/primvarRefiner.h>

#include <Eigen/Dense>

#include "compare/level_match.h"
#include "compare/open_subdiv_refiner.h"
#include "compare/shapes.h"
#include "support/named_polyhedra.h"
#include "support/tables.h"
#include "support/tangent_weights.h"
#include "support/test.h"

namespace espalier::compare {
namespace {

namespace Far = OpenSubdiv::Far;

/// The value that OpenSubdiv interpolates.
struct Value {
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    void Clear(void* = nullptr) { point.setZero(); }
    void AddWithWeight(const Value& other, double weight) { point += weight * other.point; }
};

/// OpenSubdiv's limits of the vertices of level 0, computed on level 2, where faces are
/// quadrilaterals.
struct Limits {
    std::vector<Value> points, first, second;
};

Limits limitsOf(const Far::TopologyRefiner& refiner, std::vector<Value> values) {
    const Far::PrimvarRefinerReal<double> primvar(refiner);
    std::vector<int> vertices;
    for (int v = 0; v < refiner.GetLevel(0).GetNumVertices(); ++v) vertices.push_back(v);
    for (int level = 1; level <= refiner.GetMaxLevel(); ++level) {
        std::vector<Value> next(refiner.GetLevel(level).GetNumVertices());
        primvar.Interpolate(level, values, next);
        values = std::move(next);
        for (int& v : vertices) v = refiner.GetLevel(level - 1).GetVertexChildVertex(v);
    }
    Limits all{values, values, values}, result;
    primvar.Limit(values, all.points, all.first, all.second);
    for (const int v : vertices) {
        result.points.push_back(all.points[v]);
        result.first.push_back(all.first[v]);
        result.second.push_back(all.second[v]);
    }
    return result;
}

/// Returns the points of a ring.
Eigen::MatrixXd firstRing(const limit::VertexRing& ring, const Positions& positions) {
    return ring.start * positions(ring.vertices, Eigen::all);
}

/// Returns the normal of the limit surface at a vertex, from the left eigenvectors of the second
/// and third eigenvalue of its ring on the surface.
Eigen::Vector3d normalAt(const far::Level& level, const limit::VertexRing& ring,
                         const Positions& positions) {
    std::vector<Eigen::Index> onSurface;
    for (std::size_t i = 0; i < ring.entities.size(); ++i)
        if (level.strata.smoothStratum(ring.entities[i]) == 2) onSurface.push_back(Eigen::Index(i));
    const Eigen::MatrixXd whole(ring.subdivision);
    const Eigen::MatrixXd first = firstRing(ring, positions)(onSurface, Eigen::all);
    const Eigen::MatrixXd tangents =
        tangentWeights(whole(onSurface, onSurface)).transpose() * first;
    return Eigen::Vector3d(tangents.row(0)).cross(Eigen::Vector3d(tangents.row(1))).normalized();
}

/// Returns the direction of a crease: its two points in the ring are on either side of the vertex,
/// and each level halves their distance.
Eigen::Vector3d creaseAt(const far::Level& level, const limit::VertexRing& ring,
                         const Positions& positions) {
    const Eigen::MatrixXd first = firstRing(ring, positions);
    std::vector<Eigen::Vector3d> ends;
    for (std::size_t i = 0; i < ring.entities.size(); ++i)
        if (ring.entities[i].dimension == 1 &&
            level.strata.inSubcomplex(ring.entities.front(), 1, ring.entities[i]))
            ends.push_back(first.row(Eigen::Index(i)).transpose());
    return ends.size() == 2 ? (ends[1] - ends[0]).normalized() : Eigen::Vector3d::Constant(1e9);
}

/// True if one sharp edge ends at a smooth vertex. OpenSubdiv computes the limit of such a vertex
/// as of a smooth one; this limit changes with the level.
bool isDart(const far::Level& level, Index vertex) {
    const auto edges = level.complex.relation(0, 1)[vertex];
    const auto sharp = std::count_if(edges.begin(), edges.end(), [&](Index edge) {
        return level.strata.smoothStratum({1, edge}) == 2 &&
               level.strata.sharpness({1, edge}) > far::kSmooth;
    });
    return level.strata.of({0, vertex}) == 2 && sharp == 1;
}

void expectSameLimits(const std::string& name, const Lattice& shape, int& smooth, int& creases) {
    const TopologyRefiner refiner = refined(shape, 2);
    const far::Level& level = refiner.level(0);
    const Surface surface = surfaceOf(level.complex);
    const auto openSubdiv = makeOpenSubdivRefiner(refiner, surface);
    const auto pose = shaken(shape.positions, 1);
    std::vector<Value> values;
    for (const Index vertex : surface.vertices)
        values.push_back({Eigen::Vector3d(pose[vertex].data())});
    const Limits limits = limitsOf(*openSubdiv.refiner, values);
    const auto ours = times(limit::buildVertexLimits(refiner, 0, surface.vertices), pose);
    const auto positions = asMatrix(pose);
    for (std::size_t i = 0; i < surface.vertices.size(); ++i) {
        const Index vertex = surface.vertices[i];
        const int stratum = level.strata.of({0, vertex});
        if (isDart(level, vertex)) continue;
        EXPECT_LT((ours.row(Eigen::Index(i)).transpose() - limits.points[i].point).norm(), 1e-12)
            << name << " vertex " << vertex;
        if (stratum == 0) continue;
        const auto ring = limit::ringOf(level, refiner.options(), vertex);
        if (stratum == 1) {
            // A crease has a plane on each side; along the crease there is one tangent.
            EXPECT_LT(creaseAt(level, ring, positions).cross(limits.first[i].point).norm(), 1e-12)
                << name << " vertex " << vertex;
        } else {
            const Eigen::Vector3d normal = normalAt(level, ring, positions);
            for (const Value& tangent : {limits.first[i], limits.second[i]})
                // Eigenvectors of up to 50 points, with eigenvalues that are 0.1 apart.
                EXPECT_LT(std::abs(normal.dot(tangent.point.normalized())), 1e-9)
                    << name << " vertex " << vertex;
        }
        ++(stratum == 2 ? smooth : creases);
    }
}

// Compares limits at all vertices, tangent planes at smooth vertices, and tangents of creases.
TEST(Limits, EqualOpenSubdivsLimits) {
    int smooth = 0, creases = 0;
    for (const auto& [name, lattice] : zoo()) expectSameLimits(name, lattice, smooth, creases);
    for (const auto& [name, mesh] : namedPolyhedra()) expectSameLimits(name, mesh, smooth, creases);
    expectSameLimits("grid", {gridMesh(3, 4), gridPositions({3, 4, 0}), {}, {}}, smooth, creases);
    EXPECT_GT(smooth, 150);
    EXPECT_GT(creases, 50);
}

/// Expects the gradients at smooth boundary vertices to carry OpenSubdiv's tangents at rest to its
/// tangents in a pose.
void expectCarriedTangents(const std::string& name, const Lattice& lattice, int& count) {
    const TopologyRefiner refiner = refined(lattice, 2);
    const far::Level& level = refiner.level(0);
    const Surface surface = surfaceOf(level.complex);
    const auto openSubdiv = makeOpenSubdivRefiner(refiner, surface);
    const auto pose = shaken(lattice.positions, 1);
    const auto limitsAt = [&](const std::vector<Point3>& positions) {
        std::vector<Value> values;
        for (const Index vertex : surface.vertices)
            values.push_back({Eigen::Vector3d(positions[vertex].data())});
        return limitsOf(*openSubdiv.refiner, values);
    };
    const Limits rest = limitsAt(lattice.positions), posed = limitsAt(pose);
    std::vector<Point3> points;
    for (const Value& limit : rest.points)
        points.push_back({limit.point[0], limit.point[1], limit.point[2]});
    const TopologyRefiner base(lattice.complex, refiner.options());
    const auto bound = limit::bindLimit({base, lattice.positions}, points, {.gradients = true});
    const auto tables =
        embed::gradientTables(*bound.gradients, lattice.positions, bound.table.rowCount());
    std::array<Positions, 3> columns;
    for (std::size_t axis = 0; axis < 3; ++axis) columns[axis] = times(tables[axis], pose);
    for (std::size_t i = 0; i < surface.vertices.size(); ++i) {
        const Entity vertex{0, surface.vertices[i]};
        const auto row = Index(i);
        if (level.strata.of(vertex) != 2 || isDart(level, vertex.index)) continue;
        if (tables[0].columns(row).empty()) continue;
        Eigen::Matrix3d f;
        for (std::size_t axis = 0; axis < 3; ++axis)
            f.col(Eigen::Index(axis)) = columns[axis].row(row).transpose();
        for (const auto& [before, after] : {std::pair(rest.first[i].point, posed.first[i].point),
                                            std::pair(rest.second[i].point, posed.second[i].point)})
            // Points are rounded to about 1e-16. Near a vertex F changes as a power of the
            // distance, which is less than 1/2 where eigenvalues are close to each other.
            EXPECT_LT((f * before - after).norm(), 1e-6 * (1 + after.norm()))
                << name << " vertex " << vertex.index;
        ++count;
    }
}

TEST(Limits, GradientsCarryOpenSubdivsTangents) {
    int count = 0;
    for (const auto& [name, lattice] : zoo())
        // Where the limit volume is folded, a place is in two cells at once.
        if (name != "tripod") expectCarriedTangents(name, lattice, count);
    EXPECT_GT(count, 50);
}

}  // namespace
}  // namespace espalier::compare

// SPDX-License-Identifier: Apache-2.0
//
// The code of docs/from-opensubdiv.md, both columns: OpenSubdiv
// and Espalier refine a mesh. The page shows parts of this
// file; docs_pages checks that.

#include <espalier/compare/open_subdiv_tables.h>
#include <espalier/far/complex_builder.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/osd/cpu_evaluator.h>
#include <espalier/stencils/composition.h>
#include <gtest/gtest.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/osd/cpuEvaluator.h>

#include <algorithm>
#include <memory>
#include <numeric>
#include <span>
#include <vector>

namespace {

namespace Far = OpenSubdiv::Far;
namespace Osd = OpenSubdiv::Osd;
namespace Sdc = OpenSubdiv::Sdc;
using namespace espalier;

const int level = 3;

// A house without a floor: four walls, and a roof of four
// triangles. One wall is a hole.
const std::vector<int> faceSizes = {4, 4, 4, 4, 3, 3, 3, 3};
const std::vector<int> faceVertices = {
    0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7,  //
    4, 5, 8, 5, 6, 8, 6, 7, 8, 7, 4, 8};
const std::vector<int> creasePairs = {0, 4, 4, 5, 5, 6};
const std::vector<float> creaseWeights = {10, 1.5F, 2.25F};
const std::vector<int> cornerVertices = {8};
const std::vector<float> cornerWeights = {1.25F};
const std::vector<int> holeFaces = {3};
const std::vector<float> positions = {
    0, 0,    0,   4, 0, 0, 4, 3, 0, 0, 3, 0,  // floor
    0, 0,    2,   4, 0, 2, 4, 3, 2, 0, 3, 2,  // eaves
    2, 1.5F, 3.5F};                           // top

// Weights and values in single precision, and sums of about a
// hundred of them; the unit is 6e-8.
constexpr float kRounding = 4e-6F;

std::unique_ptr<Far::TopologyRefiner> makeTheirs() {
    Far::TopologyDescriptor mesh;
    mesh.numVertices = 9;
    mesh.numFaces = 8;
    mesh.numVertsPerFace = faceSizes.data();
    mesh.vertIndicesPerFace = faceVertices.data();
    mesh.numCreases = 3;
    mesh.creaseVertexIndexPairs = creasePairs.data();
    mesh.creaseWeights = creaseWeights.data();
    mesh.numCorners = 1;
    mesh.cornerVertexIndices = cornerVertices.data();
    mesh.cornerWeights = cornerWeights.data();
    mesh.numHoles = 1;
    mesh.holeIndices = holeFaces.data();

    using Options = Sdc::Options;
    Options options;
    options.SetVtxBoundaryInterpolation(
        Options::VTX_BOUNDARY_EDGE_ONLY);
    options.SetCreasingMethod(Options::CREASE_CHAIKIN);
    options.SetTriangleSubdivision(Options::TRI_SUB_SMOOTH);

    using Factory =
        Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    std::unique_ptr<Far::TopologyRefiner> refiner(
        Factory::Create(
            mesh,
            Factory::Options(Sdc::SCHEME_CATMARK, options)));
    Far::TopologyRefiner::UniformOptions uniform(level);
    uniform.fullTopologyInLastLevel = true;
    refiner->RefineUniform(uniform);
    return refiner;
}

far::TopologyRefiner makeOurs() {
    far::ComplexBuilder builder(2, 9);
    const int* loop = faceVertices.data();
    for (const int size : faceSizes) {
        builder.addFace({loop, static_cast<size_t>(size)});
        loop += size;
    }
    const far::CellComplex mesh = builder.build();

    far::Marks marks;
    marks.edges = {{{0, 4}, far::kInfinitelySharp},
                   {{4, 5}, 1.5},
                   {{5, 6}, 2.25}};
    marks.vertices = {{8, 1.25}};
    marks.holes = {3};

    far::RefinerOptions options;
    options.boundary = far::Boundary::EdgeOnly;
    options.creasing = far::Creasing::Chaikin;
    options.triangles = far::TriangleSubdivision::Smooth;
    options.marks = marks;

    far::TopologyRefiner refiner(mesh, options);
    refiner.refineUniform(level);
    return refiner;
}

std::size_t at(int index) {
    return static_cast<std::size_t>(index);
}

/// OpenSubdiv's last-level vertex for each of ours.
std::vector<int> matchVertices(
    const Far::TopologyRefiner& theirs,
    const far::TopologyRefiner& ours) {
    std::vector<int> match(9);
    std::iota(match.begin(), match.end(), 0);
    for (int k = 1; k <= ours.maxLevel(); ++k) {
        const auto& parents = theirs.GetLevel(k - 1);
        const auto& complex = ours.level(k - 1).complex;
        std::vector<int> next;
        for (int v = 0; v < ours.level(k).complex.count(0);
             ++v) {
            const Entity of =
                ours.refinement(k).parentOf({0, v}).upper;
            std::vector<int> corners;
            for (const int vertex :
                 complex.relation(of.dimension, 0)[of.index])
                corners.push_back(match[at(vertex)]);
            if (of.dimension == 0)
                next.push_back(
                    parents.GetVertexChildVertex(corners[0]));
            else if (of.dimension == 1)
                next.push_back(parents.GetEdgeChildVertex(
                    parents.FindEdge(corners[0], corners[1])));
            else
                for (const int face :
                     parents.GetVertexFaces(corners[0])) {
                    const auto loop =
                        parents.GetFaceVertices(face);
                    if (std::is_permutation(
                            loop.begin(), loop.end(),
                            corners.begin(), corners.end()))
                        next.push_back(
                            parents.GetFaceChildVertex(face));
                }
        }
        match = next;
    }
    return match;
}

/// Properties of a level, on both sides.
struct Facts {
    int vertices = 0, borderEdges = 0, corners = 0, holes = 0;
    int ofFirstFace = 0;
    float sharpness = 0;
    friend bool operator==(const Facts&,
                           const Facts&) = default;
};

Facts askTheirs(const Far::TopologyRefiner& refiner, int k) {
    Facts facts;
    const Far::TopologyLevel& now = refiner.GetLevel(k);
    facts.vertices = now.GetNumVertices();
    for (int edge = 0; edge < now.GetNumEdges(); ++edge) {
        if (now.GetEdgeFaces(edge).size() == 1)
            ++facts.borderEdges;
        if (now.IsEdgeSemiSharp(edge))
            facts.sharpness += now.GetEdgeSharpness(edge);
    }
    for (int vertex = 0; vertex < facts.vertices; ++vertex)
        if (now.GetVertexRule(vertex) ==
            Sdc::Crease::RULE_CORNER)
            ++facts.corners;
    for (int face = 0; face < now.GetNumFaces(); ++face) {
        if (now.IsFaceHole(face)) ++facts.holes;
        if (k > 0 && now.GetFaceParentFace(face) == 0)
            ++facts.ofFirstFace;
    }
    return facts;
}

Facts askOurs(const far::TopologyRefiner& refiner, int k) {
    Facts facts;
    const auto& [complex, strata, holes] = refiner.level(k);
    facts.vertices = complex.count(0);
    for (int edge = 0; edge < complex.count(1); ++edge) {
        if (complex.relation(1, 2)[edge].size() == 1)
            ++facts.borderEdges;
        if (far::isSemiSharp(strata.sharpness({1, edge})))
            facts.sharpness += strata.sharpness({1, edge});
    }
    for (int vertex = 0; vertex < facts.vertices; ++vertex)
        if (strata.of({0, vertex}) == 0) ++facts.corners;
    facts.holes = static_cast<int>(holes.size());
    for (int face = 0; face < complex.count(2); ++face)
        if (k > 0 && refiner.refinement(k)
                             .parentOf({2, face})
                             .upper.index == 0)
            ++facts.ofFirstFace;
    return facts;
}

std::unique_ptr<const Far::StencilTable> makeTheirTable(
    const Far::TopologyRefiner& refiner) {
    using Factory = Far::StencilTableFactory;
    Factory::Options options;
    options.generateIntermediateLevels = false;
    options.generateOffsets = true;
    std::unique_ptr<const Far::StencilTable> table(
        Factory::Create(refiner, options));
    return table;
}

stencils::StencilTable<float> makeOurTable(
    const far::TopologyRefiner& refiner) {
    auto table = stencils::buildStencils<float>(
        refiner, refiner.maxLevel());
    return table;
}

/// Returns one row, from the arrays of the table.
std::vector<float> rowOfTheirs(const Far::StencilTable& table,
                               int row) {
    std::vector<float> dense(9);
    const int begin = table.GetOffsets()[at(row)];
    const int size = table.GetSizes()[at(row)];
    for (int i = begin; i < begin + size; ++i)
        dense[at(table.GetControlIndices()[at(i)])] +=
            table.GetWeights()[at(i)];
    return dense;
}

std::vector<float> rowOfOurs(
    const stencils::StencilTable<float>& table, int row) {
    std::vector<float> dense(9);
    const auto columns = table.columns(row);
    const auto weights = table.weights(row);
    for (std::size_t i = 0; i < columns.size(); ++i)
        dense[at(columns[i])] = weights[i];
    return dense;
}

std::vector<float> evaluateTheirs(
    const Far::StencilTable& table) {
    const int base = table.GetNumControlVertices();
    const int refined = table.GetNumStencils();
    std::vector<float> values(positions);
    values.resize(at(3 * (base + refined)));

    const Osd::BufferDescriptor from(0, 3, 3);
    const Osd::BufferDescriptor to(3 * base, 3, 3);
    Osd::CpuEvaluator::EvalStencils(
        values.data(), from, values.data(), to,
        table.GetSizes().data(), table.GetOffsets().data(),
        table.GetControlIndices().data(),
        table.GetWeights().data(), 0, refined);
    return values;
}

std::vector<float> evaluateOurs(
    const stencils::StencilTable<float>& table) {
    const int base = table.columnCount();
    const int refined = table.rowCount();
    std::vector<float> values(positions);
    values.resize(at(3 * (base + refined)));

    const std::span source =
        std::span(values).first(at(3 * base));
    const std::span result =
        std::span(values).subspan(at(3 * base));
    const auto xyz = osd::BufferDescriptor::packed(3);
    osd::CpuEvaluator::evaluate(table, source, xyz, result, xyz,
                                {0, refined});
    return values;
}

/// A value for PrimvarRefiner.
struct Point {
    float x = 0, y = 0, z = 0;
    void Clear() { *this = {}; }
    void AddWithWeight(const Point& from, float weight) {
        x += weight * from.x;
        y += weight * from.y;
        z += weight * from.z;
    }
};

std::vector<Point> refineTheirs(
    const Far::TopologyRefiner& refiner) {
    std::vector<Point> points;
    for (std::size_t i = 0; i < positions.size(); i += 3)
        points.push_back(
            {positions[i], positions[i + 1], positions[i + 2]});
    const Far::PrimvarRefiner primvar(refiner);
    for (int k = 1; k <= level; ++k) {
        const int count = refiner.GetLevel(k).GetNumVertices();
        std::vector<Point> next(at(count));
        primvar.Interpolate(k, points, next);
        points = next;
    }
    return points;
}

std::vector<double> refineOurs(
    const far::TopologyRefiner& refiner) {
    const std::vector<double> base(positions.begin(),
                                   positions.end());
    const auto points =
        stencils::refineValues(refiner, level, base, 3);
    return points;
}

/// Removes the base vertices.
std::vector<float> refinedPart(
    const std::vector<float>& values) {
    return {values.begin() + 27, values.end()};
}

class FromOpenSubdiv : public testing::Test {
protected:
    void expectNear(const std::vector<float>& theirValues,
                    const std::vector<float>& ourValues) const {
        ASSERT_EQ(theirValues.size(), 3 * match.size());
        ASSERT_EQ(ourValues.size(), 3 * match.size());
        for (std::size_t v = 0; v < match.size(); ++v)
            for (std::size_t c = 0; c < 3; ++c)
                EXPECT_NEAR(ourValues[3 * v + c],
                            theirValues[3 * at(match[v]) + c],
                            kRounding);
    }

    std::unique_ptr<Far::TopologyRefiner> theirs = makeTheirs();
    far::TopologyRefiner ours = makeOurs();
    std::vector<int> match = matchVertices(*theirs, ours);
};

TEST_F(FromOpenSubdiv, TheLevelsAreTheSame) {
    for (int k = 0; k <= level; ++k) {
        const Facts facts = askOurs(ours, k);
        EXPECT_EQ(facts, askTheirs(*theirs, k)) << k;
        EXPECT_GT(facts.borderEdges, 0);
        EXPECT_GT(facts.holes, 0);
    }
    EXPECT_GT(askOurs(ours, 1).sharpness, 0);
    EXPECT_GT(askOurs(ours, 1).corners, 0);
}

TEST_F(FromOpenSubdiv, VerticesComeInOtherOrders) {
    // OpenSubdiv's order: new points of vertices, of faces, of
    // edges. Ours: of vertices, of edges, of faces.
    const auto& base = theirs->GetLevel(0);
    EXPECT_EQ(base.GetVertexChildVertex(0), 0);
    EXPECT_EQ(base.GetFaceChildVertex(0), 9);
    EXPECT_EQ(base.GetEdgeChildVertex(0), 9 + 8);
    const far::Refinement& first = ours.refinement(1);
    const auto pointOf = [&](Entity entity) {
        return first.childOf({entity, entity})->index;
    };
    EXPECT_EQ(pointOf({0, 0}), 0);
    EXPECT_EQ(pointOf({1, 0}), 9);
    EXPECT_EQ(pointOf({2, 0}),
              9 + ours.level(0).complex.count(1));
}

TEST_F(FromOpenSubdiv, TheTablesAreTheSame) {
    const auto theirTable = makeTheirTable(*theirs);
    const auto ourTable = makeOurTable(ours);
    ASSERT_EQ(ourTable.rowCount(),
              theirTable->GetNumStencils());
    ASSERT_EQ(at(ourTable.rowCount()), match.size());
    for (int row = 0; row < ourTable.rowCount(); ++row) {
        const auto expected =
            rowOfTheirs(*theirTable, match[at(row)]);
        const auto weights = rowOfOurs(ourTable, row);
        for (std::size_t column = 0; column < 9; ++column)
            EXPECT_NEAR(weights[column], expected[column],
                        kRounding);
    }
    expectNear(refinedPart(evaluateTheirs(*theirTable)),
               refinedPart(evaluateOurs(ourTable)));
}

TEST_F(FromOpenSubdiv, RangesWriteInOtherPlaces) {
    const auto theirTable = makeTheirTable(*theirs);
    const Osd::BufferDescriptor layout(0, 3, 3);
    std::vector<float> theirRows(3 * match.size(), -1);
    Osd::CpuEvaluator::EvalStencils(
        positions.data(), layout, theirRows.data(), layout,
        theirTable->GetSizes().data(),
        theirTable->GetOffsets().data(),
        theirTable->GetControlIndices().data(),
        theirTable->GetWeights().data(), 5, 7);
    EXPECT_NE(theirRows[0], -1);  // row 5
    EXPECT_EQ(theirRows[3 * 5], -1);

    const auto ourTable = makeOurTable(ours);
    const auto xyz = osd::BufferDescriptor::packed(3);
    std::vector<float> ourRows(3 * match.size(), -1);
    osd::CpuEvaluator::evaluate(ourTable, positions, xyz,
                                ourRows, xyz, {5, 7});
    EXPECT_EQ(ourRows[0], -1);
    EXPECT_NE(ourRows[3 * 5], -1);  // row 5
}

TEST_F(FromOpenSubdiv, LevelByLevel) {
    std::vector<float> theirValues, ourValues;
    for (const Point& point : refineTheirs(*theirs))
        theirValues.insert(theirValues.end(),
                           {point.x, point.y, point.z});
    for (const double value : refineOurs(ours))
        ourValues.push_back(static_cast<float>(value));
    expectNear(theirValues, ourValues);
}

TEST_F(FromOpenSubdiv, CompiledTables) {
    const auto table = makeOurTable(ours);
    const int refined = table.rowCount();
    std::vector<float> result(at(3 * refined));

    const osd::CompiledTable<float> compiled(table);  // once
    const auto xyz = osd::BufferDescriptor::packed(3);
    compiled.evaluate(positions, xyz, result, xyz,
                      {0, refined});

    expectNear(
        refinedPart(evaluateTheirs(*makeTheirTable(*theirs))),
        result);
}

TEST_F(FromOpenSubdiv, OurTableInTheirEvaluator) {
    const auto ourTable = makeOurTable(ours);
    const compare::OpenSubdivTable<float> table(ourTable);
    const Osd::BufferDescriptor layout(0, 3, 3);
    std::vector<float> result(at(3 * table.GetNumStencils()));
    Osd::CpuEvaluator::EvalStencils(
        positions.data(), layout, result.data(), layout,
        table.GetSizes().data(), table.GetOffsets().data(),
        table.GetControlIndices().data(),
        table.GetWeights().data(), 0, table.GetNumStencils());

    expectNear(
        refinedPart(evaluateTheirs(*makeTheirTable(*theirs))),
        result);
}

TEST_F(FromOpenSubdiv, TheirTableInOurEvaluator) {
    const auto theirTable = makeTheirTable(*theirs);
    const auto table = compare::fromOpenSubdiv(
        *theirTable, 0, theirTable->GetNumStencils());

    const auto expected = evaluateTheirs(*theirTable);
    const auto values = evaluateOurs(table);
    ASSERT_EQ(values.size(), expected.size());
    for (std::size_t i = 0; i < values.size(); ++i)
        EXPECT_NEAR(values[i], expected[i], kRounding);
}

}  // namespace

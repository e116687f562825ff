// SPDX-License-Identifier: Apache-2.0
#include <espalier/compare/open_subdiv_tables.h>
#include <espalier/osd/cpu_evaluator.h>
#include <espalier/stencils/composition.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/osd/cpuEvaluator.h>
#include <opensubdiv/osd/cpuVertexBuffer.h>

#include "compare/open_subdiv_refiner.h"
#include "compare/shapes.h"
#include "support/test.h"

namespace espalier::compare {
namespace {

namespace Far = OpenSubdiv::Far;
namespace Osd = OpenSubdiv::Osd;

/// A creased mesh and OpenSubdiv's table of its level 2.
struct CreasedMesh {
    Lattice mesh = randomCreases(cubeSurface(), 7, far::Creasing::Uniform);
    TopologyRefiner refiner = refined(mesh, 2);
    OpenSubdivRefiner openSubdiv = makeOpenSubdivRefiner(refiner, surfaceOf(mesh.complex));

    template <class Real>
    std::unique_ptr<const Far::StencilTableReal<Real>> table() const {
        typename Far::StencilTableFactoryReal<Real>::Options options;
        options.generateIntermediateLevels = false;
        options.generateOffsets = true;
        return std::unique_ptr<const Far::StencilTableReal<Real>>(
            Far::StencilTableFactoryReal<Real>::Create(*openSubdiv.refiner, options));
    }
};

std::vector<float> basePositions(const Lattice& mesh) {
    std::vector<float> values;
    for (const Point3& position : mesh.positions)
        for (const double coordinate : position) values.push_back(float(coordinate));
    return values;
}

std::vector<float> evaluateWithEspalier(const stencils::StencilTable<float>& table,
                                        const std::vector<float>& source) {
    std::vector<float> result(3 * std::size_t(table.rowCount()));
    const auto layout = osd::BufferDescriptor::packed(3);
    osd::CpuEvaluator::evaluate<float>(table, source, layout, result, layout,
                                       {0, table.rowCount()});
    return result;
}

/// Evaluates with the template and buffers that OpenSubdiv's users use.
template <class Table>
std::vector<float> evaluateWithOpenSubdiv(const Table& table, const std::vector<float>& source) {
    const int count = table.GetNumStencils();
    const std::unique_ptr<Osd::CpuVertexBuffer> from(
        Osd::CpuVertexBuffer::Create(3, int(source.size() / 3)));
    const std::unique_ptr<Osd::CpuVertexBuffer> to(Osd::CpuVertexBuffer::Create(3, count));
    from->UpdateData(source.data(), 0, int(source.size() / 3));
    const Osd::BufferDescriptor layout(0, 3, 3);
    EXPECT_TRUE(Osd::CpuEvaluator::EvalStencils(from.get(), layout, to.get(), layout, &table));
    return {to->BindCpuBuffer(), to->BindCpuBuffer() + 3 * count};
}

/// Rows sum to 1, and coordinates are at most 1. Sums of the same products in a different order
/// differ by a few units of single precision, 6e-8.
void expectSame(const std::vector<float>& a, const std::vector<float>& b) {
    ASSERT_EQ(a.size(), b.size());
    ASSERT_FALSE(a.empty());
    for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 1e-6) << i;
}

TEST(OpenSubdivTables, OpenSubdivEvaluatesOurTable) {
    const CreasedMesh creased;
    const auto table = stencils::buildStencils<float>(creased.refiner, 2);
    const std::vector<float> source = basePositions(creased.mesh);
    expectSame(evaluateWithOpenSubdiv(OpenSubdivTable<float>(table), source),
               evaluateWithEspalier(table, source));
}

TEST(OpenSubdivTables, OurEvaluatorTakesOpenSubdivTables) {
    const CreasedMesh creased;
    const auto openSubdiv = creased.table<float>();
    const std::vector<float> source = basePositions(creased.mesh);
    const auto table = fromOpenSubdiv(*openSubdiv, 0, openSubdiv->GetNumStencils());
    const std::vector<float> expected =
        evaluateWithOpenSubdiv(static_cast<const Far::StencilTable&>(*openSubdiv), source);
    expectSame(evaluateWithEspalier(table, source), expected);
}

TEST(OpenSubdivTables, KeepWeightsAndShapes) {
    const auto table = stencils::buildStencils(CreasedMesh().refiner, 2);
    const OpenSubdivTable<double> exported(table);
    EXPECT_EQ(exported.GetNumStencils(), table.rowCount());
    EXPECT_EQ(exported.GetNumControlVertices(), table.columnCount());
    for (Index row = 0; row < table.rowCount(); ++row) {
        const auto i = std::size_t(row);
        ASSERT_EQ(exported.GetSizes()[i], int(table.columns(row).size()));
        for (std::size_t k = 0; k < table.columns(row).size(); ++k) {
            const std::size_t at = std::size_t(exported.GetOffsets()[i]) + k;
            ASSERT_EQ(exported.GetControlIndices()[at], table.columns(row)[k]);
            ASSERT_EQ(exported.GetWeights()[at], table.weights(row)[k]);
        }
    }
}

TEST(OpenSubdivTables, TakePartOfATable) {
    const CreasedMesh creased;
    const auto openSubdiv = creased.table<double>();
    const auto all = fromOpenSubdiv(*openSubdiv, 0, openSubdiv->GetNumStencils());
    const auto some = fromOpenSubdiv(*openSubdiv, 5, 3);
    ASSERT_EQ(some.rowCount(), 3);
    for (Index row = 0; row < 3; ++row) {
        EXPECT_TRUE(std::ranges::equal(some.columns(row), all.columns(row + 5)));
        EXPECT_TRUE(std::ranges::equal(some.weights(row), all.weights(row + 5)));
    }
    EXPECT_THROW(fromOpenSubdiv(*openSubdiv, openSubdiv->GetNumStencils() - 2, 3), Error);
    EXPECT_THROW(fromOpenSubdiv(*openSubdiv, -1, 1), Error);
}

}  // namespace
}  // namespace espalier::compare

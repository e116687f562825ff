// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <espalier/base/parallel.h>
#include <espalier/osd/compiled_table.h>
#include <libxsmm.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "workloads.h"

// Multiplies the table of the regular model by several poses with libxsmm_spmdm, which makes sparse
// blocks from a dense matrix. Benchmarks are named product/POSES/WHO.
namespace espalier {
namespace {

/// The table as sparse blocks of libxsmm. libxsmm reserves 6 bytes for each entry of the dense
/// matrix, so a million rows must have few columns.
class SparseBlocks {
public:
    SparseBlocks(const stencils::StencilTable<float>& table, int components)
        : table_(table), components_(components) {
        // One part of the rows after another is made dense.
        for (Index first = 0; first < table.rowCount(); first += kPartRows) {
            Part part{first, std::min(kPartRows, table.rowCount() - first), {}, nullptr};
            libxsmm_spmdm_init(part.rowCount, components, table.columnCount(), 1, &part.handle,
                               &part.blocks);
            const std::vector<float> rows = dense(part);
            const int count = libxsmm_spmdm_get_num_createSparseSlice_blocks(&part.handle);
            for (int block = 0; block < count; ++block)
                libxsmm_spmdm_createSparseSlice_fp32_thread(&part.handle, 'N', rows.data(),
                                                            part.blocks, block, 0, 1);
            parts_.push_back(part);
        }
    }
    SparseBlocks(const SparseBlocks&) = delete;
    SparseBlocks& operator=(const SparseBlocks&) = delete;
    ~SparseBlocks() {
        for (Part& part : parts_) libxsmm_spmdm_destroy(&part.handle);
    }

    void evaluate(const std::vector<float>& source, std::vector<float>& result) const {
        const float one = 1, zero = 0;
        for (const Part& part : parts_) {
            float* const rows = result.data() + Offset{part.first} * components_;
            const int count = libxsmm_spmdm_get_num_compute_blocks(&part.handle);
            for (int block = 0; block < count; ++block)
                libxsmm_spmdm_compute_fp32_thread(&part.handle, 'N', 'N', &one, part.blocks,
                                                  source.data(), 'N', &zero, rows, block, 0, 1);
        }
    }

private:
    /// 80 blocks of 512 rows.
    static constexpr Index kPartRows = 40'960;

    struct Part {
        Index first, rowCount;
        libxsmm_spmdm_handle handle;
        libxsmm_CSR_sparseslice* blocks;
    };

    std::vector<float> dense(const Part& part) const {
        const Offset columnCount = table_.columnCount();
        std::vector<float> result(part.rowCount * columnCount);
        for (Index row = 0; row < part.rowCount; ++row) {
            const auto columns = table_.columns(part.first + row);
            const auto weights = table_.weights(part.first + row);
            for (std::size_t k = 0; k < columns.size(); ++k)
                result[row * columnCount + columns[k]] = weights[k];
        }
        return result;
    }

    const stencils::StencilTable<float>& table_;
    int components_;
    std::vector<Part> parts_;
};

const stencils::StencilTable<float>& table() {
    static const auto made = bench::regularTable<float>(bench::kMillion);
    return made;
}

void multiplyByEspalier(benchmark::State& state, int components) {
    const ThreadLimit limit(1);
    const osd::CompiledTable<float> compiled(table());
    const auto layout = osd::BufferDescriptor::packed(components);
    const auto source = bench::randomValues(table(), components);
    std::vector<float> result(table().rowCount() * Offset{components});
    for (auto _ : state) {
        compiled.evaluate(source, layout, result, layout, {0, table().rowCount()});
        benchmark::ClobberMemory();
    }
}

void multiplyByLibxsmm(benchmark::State& state, int components) {
    const SparseBlocks blocks(table(), components);
    const auto source = bench::randomValues(table(), components);
    std::vector<float> result(table().rowCount() * Offset{components});
    for (auto _ : state) {
        blocks.evaluate(source, result);
        benchmark::ClobberMemory();
    }
    // Values are at most 1, and each row has 64 weights whose sum is 1.
    const auto layout = osd::BufferDescriptor::packed(components);
    std::vector<float> ours(result.size());
    osd::CompiledTable<float>(table()).evaluate(source, layout, ours, layout,
                                                {0, table().rowCount()});
    for (std::size_t i = 0; i < ours.size(); ++i)
        if (!(std::abs(ours[i] - result[i]) <= 64 * std::numeric_limits<float>::epsilon()))
            return state.SkipWithError("the result differs from the result of Espalier");
}

const bool kRegistered = [] {
    for (const int poses : {1, 12, 32}) {
        const auto add = [&](const std::string& who, auto work) {
            benchmark::RegisterBenchmark(("product/" + std::to_string(poses) + "/" + who).c_str(),
                                         [=](benchmark::State& state) { work(state, 3 * poses); })
                ->MeasureProcessCPUTime()
                ->Unit(benchmark::kMillisecond);
        };
        add("Espalier", multiplyByEspalier);
        add("libxsmm", multiplyByLibxsmm);
    }
    return true;
}();

}  // namespace
}  // namespace espalier

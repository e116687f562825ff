// SPDX-License-Identifier: Apache-2.0
#include <espalier/osd/compiled_adjoint.h>
#include <espalier/osd/compiled_chain.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/osd/cpu_evaluator.h>

#include <array>
#include <numeric>
#include <utility>

#include "evaluator_suite.h"
#include "host_device.h"

namespace espalier::osd {
namespace {

/// An evaluator that uses the table as it is.
template <class E>
struct Direct {
    template <class Real>
    class Of {
    public:
        explicit Of(const StencilTable<Real>& table) : table_(table) {}

        void evaluate(Values<Real> source, const BufferDescriptor& sourceLayout,
                      MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                      RowRange rows) const {
            E::evaluate(table_, source, sourceLayout, destination, destinationLayout, rows);
        }

    private:
        const StencilTable<Real>& table_;
    };
};

/// An evaluator that compiles the table. A processor without these instructions uses its best ones,
/// so the suite then runs on these twice.
template <Simd simd>
struct Compiled {
    template <class Real>
    class Of : public CompiledTable<Real> {
    public:
        explicit Of(const StencilTable<Real>& table)
            : CompiledTable<Real>(table, hasSimd(simd) ? simd : bestSimd()) {}
    };
};

/// Evaluates the adjoint of the transpose, which is the table again.
template <Simd simd>
struct Adjoint {
    template <class Real>
    class Of : public CompiledAdjoint<Real> {
    public:
        explicit Of(const StencilTable<Real>& table)
            : CompiledAdjoint<Real>(stencils::transposeTable(table),
                                    hasSimd(simd) ? simd : bestSimd()) {}
    };
};

template <class Real>
StencilTable<Real> identity(Index count) {
    Array<Offset> offsets(std::size_t(count) + 1);
    Array<Index> columns(count);
    std::iota(offsets.begin(), offsets.end(), Offset{0});
    std::iota(columns.begin(), columns.end(), Index{0});
    return {count, std::move(offsets), columns, Array<Real>(columns.size(), Real{1})};
}

/// A chain of the table and the identity.
struct Chained {
    template <class Real>
    class Of : public CompiledChain<Real> {
    public:
        explicit Of(const StencilTable<Real>& table)
            : CompiledChain<Real>(std::array{table, identity<Real>(table.rowCount())}) {}
    };
};

/// The adjoint of a chain of the identity and the transpose.
struct AdjointChained {
    template <class Real>
    class Of : public CompiledAdjointChain<Real> {
    public:
        explicit Of(const StencilTable<Real>& table)
            : CompiledAdjointChain<Real>(
                  std::array{identity<Real>(table.rowCount()), stencils::transposeTable(table)}) {}
    };
};

/// The kernels of GPUs, run on the host.
/// \tparam isGrouped true to group rows that share their columns
template <bool isGrouped>
struct OnHost {
    template <class Real>
    class Of : public HostDevice<Real> {
    public:
        explicit Of(const StencilTable<Real>& table) : HostDevice<Real>(table, isGrouped) {}
    };
};

template <bool isGrouped>
struct AdjointOnHost {
    template <class Real>
    class Of {
    public:
        explicit Of(const StencilTable<Real>& table)
            : device_(stencils::transposeTable(table), isGrouped) {}

        void evaluate(Values<Real> source, const BufferDescriptor& sourceLayout,
                      MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                      RowRange rows) const {
            device_.evaluateAdjoint(source, sourceLayout, destination, destinationLayout, rows);
        }

    private:
        HostDevice<Real> device_;
    };
};

using Cases = ::testing::Types<
    Case<Direct<ReferenceEvaluator>, float>, Case<Direct<ReferenceEvaluator>, double>,
    Case<Direct<CpuEvaluator>, float>, Case<Direct<CpuEvaluator>, double>,
    Case<Compiled<Simd::Baseline>, float>, Case<Compiled<Simd::Baseline>, double>,
    Case<Compiled<Simd::Avx2>, float>, Case<Compiled<Simd::Avx2>, double>,
    Case<Compiled<Simd::Avx512>, float>, Case<Compiled<Simd::Avx512>, double>, Case<Chained, float>,
    Case<Chained, double>, Case<Adjoint<Simd::Baseline>, float>,
    Case<Adjoint<Simd::Baseline>, double>, Case<Adjoint<Simd::Avx2>, float>,
    Case<Adjoint<Simd::Avx2>, double>, Case<Adjoint<Simd::Avx512>, float>,
    Case<Adjoint<Simd::Avx512>, double>, Case<AdjointChained, float>, Case<AdjointChained, double>,
    Case<OnHost<true>, float>, Case<OnHost<true>, double>, Case<OnHost<false>, float>,
    Case<OnHost<false>, double>, Case<AdjointOnHost<true>, float>,
    Case<AdjointOnHost<true>, double>, Case<AdjointOnHost<false>, float>,
    Case<AdjointOnHost<false>, double>>;

INSTANTIATE_TYPED_TEST_SUITE_P(Host, EvaluatorTest, Cases);

}  // namespace
}  // namespace espalier::osd

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/osd/evaluation.h>
#include <espalier/stencils/factored_table.h>

#include <span>
#include <string>
#include <vector>

namespace espalier::cli {

/// Returns the largest error of the sum over a row, in ulp of Σ |w · x|, for the number of entries
/// of the row.
using UlpBound = double (*)(double entries);

/// The bound for a sum in the order of the table: each product and each sum is rounded by half an
/// ulp.
double plainUlpBound(double entries);

/// The bound for osd::CompiledTable.
double compiledUlpBound(double entries);

/// Computes the expected results of an evaluator, and the largest error that each may have. Refers
/// to the tables that it is made from.
///
/// The expected results are D · x by osd's reference evaluator in double precision. The allowed
/// errors follow the tables that the evaluator applies one after the other: each table adds the
/// bound of its own sums, and multiplies the errors of the table before it. If the factors have
/// large weights of both signs, the allowed error follows their sums, Σ_k |W_ik| Σ_j |S_kj · x_j|,
/// even if the weights of D are small. The errors of the reference, and of rounding weights and
/// values to float, are added.
class ExpectedSums {
public:
    /// \param matrix D in double. The evaluator applies it, or it rounded to float
    /// \param bound the bound of the evaluator
    ExpectedSums(const stencils::StencilTable<double>& matrix, UlpBound bound);

    /// \param matrix D in double
    /// \param factors the product of these is D, to rounding. The evaluator applies them, or them
    ///        rounded to float
    /// \param bound the bound of the evaluator for each factor
    /// \throws Error if the product has other rows or columns than D
    ExpectedSums(const stencils::StencilTable<double>& matrix,
                 const stencils::FactoredTable<double>& factors, UlpBound bound);

    /// Numbers for each row and component.
    struct Numbers {
        std::vector<double> values;   ///< expected results
        std::vector<double> allowed;  ///< largest errors of the results
    };

    /// \tparam Real the precision of the results
    /// \param values of the columns in double, before rounding to Real
    /// \cost O(entries × components), in parallel
    template <class Real>
    Numbers of(std::span<const double> values, const osd::BufferDescriptor& layout) const;

private:
    using Table = stencils::StencilTable<double>;

    const Table* matrix_;
    std::vector<const Table*> applied_;  ///< the tables in the order in which they are applied

    /// The tables whose row sums cause the error of the reference: D and, if D is a product, the
    /// left factor, whose rows the weights of D were summed over.
    std::vector<const Table*> summed_;

    UlpBound bound_;
};

/// Compares results with the expected ones.
///
/// \param values of the columns in double, before rounding
/// \param results of the rows
/// \param layout of values and results: the components to compare
/// \param who the evaluator, for the message
/// \throws Error naming the first wrong result, and its error
/// \cost O(entries × components), in parallel
template <class Real>
void checkResults(const ExpectedSums& sums, std::span<const double> values,
                  std::span<const Real> results, const osd::BufferDescriptor& layout,
                  const std::string& who);

}  // namespace espalier::cli

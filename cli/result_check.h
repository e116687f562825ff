// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/osd/evaluation.h>
#include <espalier/stencils/factored_table.h>

#include <span>
#include <string>
#include <vector>

namespace espalier::cli {

/// How far a result may be off the exact sum of its row: so many ulp of Σ |w · x|, by the number of
/// entries of the row.
using UlpBound = double (*)(double entries);

/// Of sums in the order of the table: one rounding, half an ulp, a product and a sum.
double plainUlpBound(double entries);

/// Of osd::CompiledTable.
double compiledUlpBound(double entries);

/// What results should be, and how far each may be off, by the sums that it was made of. Refers to
/// the tables that it is made from.
///
/// What results should be is always D · x by osd's reference evaluator, in double precision. How
/// far they may be off goes by the tables that were applied, one after the other: the sums of each
/// are off by its bound, and the next one carries that on. So where factors have large weights of
/// both signs, the bound is that of their sums, Σ_k |W_ik| Σ_j |S_kj · x_j|, though D may have
/// small weights. The reference is not exact either, nor is the rounding of weights and values to
/// float: the bound is the larger by what these may be off.
class ExpectedSums {
public:
    /// \param matrix D, in double; what was applied is this, or this rounded to float
    /// \param bound of what applied it
    ExpectedSums(const stencils::StencilTable<double>& matrix, UlpBound bound);

    /// \param matrix D, in double
    /// \param factors whose product it is, but for rounding; what was applied is these, or these
    ///        rounded to float
    /// \param bound of what applied each
    /// \throws Error if the product has not the rows and columns of D
    ExpectedSums(const stencils::StencilTable<double>& matrix,
                 const stencils::FactoredTable<double>& factors, UlpBound bound);

    /// One number a row and component.
    struct Numbers {
        std::vector<double> values;   ///< what the results should be
        std::vector<double> allowed;  ///< how far they may be off
    };

    /// \tparam Real the precision of the results
    /// \param values of the columns, in double, before they were rounded
    /// \cost O(entries × components), in parallel
    template <class Real>
    Numbers of(std::span<const double> values, const osd::BufferDescriptor& layout) const;

private:
    using Table = stencils::StencilTable<double>;

    const Table* matrix_;
    std::vector<const Table*> applied_;  ///< one after the other

    /// Tables with the rows of D, which are the sums that the reference is made of: D, and where D
    /// is a product, also the left factor, by which its weights were summed up.
    std::vector<const Table*> summed_;

    UlpBound bound_;
};

/// Compares results with what they should be.
///
/// \param values of the columns, in double, before they were rounded
/// \param results of the rows
/// \param layout of both: which components of theirs are compared
/// \param who made the results, for the message
/// \throws Error naming the first point that is off, and by how much
/// \cost O(entries × components), in parallel
template <class Real>
void checkResults(const ExpectedSums& sums, std::span<const double> values,
                  std::span<const Real> results, const osd::BufferDescriptor& layout,
                  const std::string& who);

}  // namespace espalier::cli

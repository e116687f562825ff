// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/osd/evaluation.h>

#include <span>
#include <string>

namespace espalier::cli {

/// How far a result may be off the exact sum of its row: so many ulp of Σ |w · x|, by the number of
/// entries of the row.
using UlpBound = double (*)(double entries);

/// Of sums in the order of the table: one rounding, half an ulp, a product and a sum.
double plainUlpBound(double entries);

/// Of osd::CompiledTable.
double compiledUlpBound(double entries);

/// Compares results with those of osd's reference evaluator in double precision.
///
/// The reference is not exact either, nor is the rounding of weights and values to float: the bound
/// is the larger by what these may be off.
///
/// \param table in double; what was evaluated is this, or this rounded to float
/// \param values of its columns, in double, before they were rounded
/// \param results of its rows
/// \param layout of both: which components of theirs are compared
/// \param who made the results, for the message
/// \throws Error naming the first point that is off, and by how much
/// \cost O(entries × components), in parallel
template <class Real>
void checkResults(const stencils::StencilTable<double>& table, std::span<const double> values,
                  std::span<const Real> results, const osd::BufferDescriptor& layout,
                  UlpBound bound, const std::string& who);

}  // namespace espalier::cli

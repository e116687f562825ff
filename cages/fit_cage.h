// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>
#include <espalier/base/point.h>
#include <espalier/shapes/lattice.h>

#include <vector>

#include "point_groups.h"
#include "symmetry.h"
#include "work.h"

namespace espalier::cages {

/// Thrown by fitCage() if no lattice with the cells of the start is found.
class FitError : public Error {
public:
    using Error::Error;
};

struct FitOptions {
    /// Least distance between the points and the boundary of the limit volume, in units of the
    /// points: 0 or more.
    double margin = 0;

    /// Level to which limit::LimitParts refines irregular features for the proof of validity.
    int levelOfParts = 2;

    /// Largest number of proofs that may fail before fitting starts anew with less pull; and, while
    /// the worst cells are improved, before the last proved lattice is kept.
    int maxRounds = 12;

    /// Largest number of times that fitting starts, 1 to 4. The fourth time does not pull.
    int maxAttempts = 4;

    /// Planes about which the start is symmetric. The result is exactly symmetric, too.
    std::vector<VertexMirror> mirrors = {};
};

/// Moves the vertices of a lattice so that its boundary follows a model.
///
/// The result is proved:
/// - Every point is inside level 3 and inside the limit volume, `margin` away from the boundary;
///   the limit volume contains it only once.
/// - Every patch of the limit volume has a positive Jacobian (solve::ValidityCheck on
///   limit::LimitParts of `levelOfParts`).
///
/// Between the points, nothing holds the boundary. So give points that are at most an eighth of a
/// cell apart.
///
/// \param start cells around the model, with a boundary that is a manifold. Its cells must have
///        positive volumes. It may leave some points a little outside
/// \param points of the model; their order has no effect. They are freed when they are in groups
/// \param work counts the work of the fit, and may bound it
/// \throws Error if there are no points; for a number that is not finite or out of range; for an
///         open boundary or semi-sharp marks; for a point that is more than an edge outside the
///         box around the start; for a start that is inside out; FitError if no lattice with these
///         cells is found: it names a point or a cell without proof, or says that the lattice grew
///         too much; WorkError if the work ends before a lattice is proved. If it ends while the
///         worst cells of a proved lattice are improved, the best one that is proved is returned
/// \cost O(points) for each proof and each of the 12 times that faces and points are matched;
///       docs/cages.md has times of whole cages
Lattice fitCage(Lattice start, std::vector<FitPoint> points, const FitOptions& options, Work& work);

}  // namespace espalier::cages

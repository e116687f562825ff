// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/far/topology_refiner.h>

#include <array>
#include <string>
#include <vector>

// Results of a comparison with OpenSubdiv.
namespace espalier::compare {

/// Largest differences that count as agreement.
struct Bounds {
    /// Limit for positions, as a fraction of the side of the cube (2) that random positions fill.
    /// It allows the rounding of about a hundred operations on numbers of size 1.
    double position = 1e-13;
    /// Limit for weights of stencils, which are of size 1.
    double weight = 1e-14;
    /// Limit between two evaluators of the same table, as a fraction like `position`. OpenSubdiv's
    /// evaluators use single precision, with a unit of 6e-8, and the order of summation differs.
    double evaluator = 2e-6;
};

/// The agreement of one level of a surface with OpenSubdiv. Vertices, edges and faces are matched
/// by topology, through the parent and child maps of both sides, never by position.
struct ESPALIER_API LevelAgreement {
    int level = 0;
    std::array<Index, 3> counts = {};            ///< vertices, edges, faces
    std::array<Index, 3> openSubdivCounts = {};  ///< counts in OpenSubdiv
    /// Description of the first difference of topology, features or holes; empty if there is none.
    std::string topologyDifference = {};
    double positionDifference = 0;  ///< the largest, for random positions; see Bounds
    double weightDifference = 0;    ///< the largest between the two tables, row by row
    /// The largest, for random positions, between our evaluator and OpenSubdiv's, on both sides'
    /// tables.
    double evaluatorDifference = 0;

    bool isWithin(const Bounds& bounds) const;
};

/// A surface at one level in space, with the distances of OpenSubdiv's points from ours.
struct SurfaceError {
    int level = 0;
    std::vector<Point3> positions;
    std::vector<std::array<Index, 4>> faces;
    std::vector<double> errors;  ///< one for each position, as a fraction of the size of the shape
    /// For each position, the number of its vertex on our level; empty for 0, 1, 2, …
    std::vector<Index> vertices = {};
};

/// The agreement of one shape, level by level.
struct ESPALIER_API Agreement {
    std::vector<LevelAgreement> levels = {};
    /// Picture of a level with few enough faces to draw; empty if there is none.
    SurfaceError picture = {};
    std::string note = {};  ///< remark for the reader; mostly empty

    /// True if every level is within the bounds; false if there are no levels.
    bool isWithin(const Bounds& bounds) const;
};

/// The version of OpenSubdiv that this library is built with: "3.5.0".
ESPALIER_API std::string openSubdivVersion();

}  // namespace espalier::compare

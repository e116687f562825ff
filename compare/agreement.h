// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/far/topology_refiner.h>

#include <array>
#include <string>
#include <vector>

namespace espalier::compare {

/// What counts as agreement.
struct Bounds {
    /// Largest difference of a position, where random positions fill a cube of side 2, as a
    /// fraction of that side. Rounding: some hundred operations on numbers of size 1.
    double position = 1e-13;
    /// Largest difference of a stencil's weight. Weights are of size 1.
    double weight = 1e-14;
    /// Largest difference between two evaluators of the same table, as a fraction like that of
    /// `position`: OpenSubdiv's take single precision, whose unit is 6e-8, and each side adds up a
    /// row in an order of its own.
    double evaluator = 2e-6;
};

/// How one level of a surface agrees with OpenSubdiv's. Vertices, edges and faces are matched by
/// topology, through the parent and child maps of both sides, never by position.
struct ESPALIER_API LevelAgreement {
    int level = 0;
    std::array<Index, 3> counts = {};            ///< vertices, edges, faces
    std::array<Index, 3> openSubdivCounts = {};  ///< those of OpenSubdiv
    /// The first difference of topology, features or holes, in words; empty if there is none.
    std::string topologyDifference = {};
    double positionDifference = 0;  ///< the largest, for random positions; see Bounds
    double weightDifference = 0;    ///< the largest between the two tables, row by row
    /// The largest, for random positions, between our evaluator and OpenSubdiv's on our table, and
    /// on theirs.
    double evaluatorDifference = 0;

    bool isWithin(const Bounds& bounds) const;
};

/// A surface at one level, in space, with how far OpenSubdiv's points are from ours there.
struct SurfaceError {
    int level = 0;
    std::vector<Point3> positions;
    std::vector<std::array<Index, 4>> faces;
    std::vector<double> errors;  ///< one a position, as a fraction of the size of the shape
    /// Numbers of the vertices on our level, one a position; empty for 0, 1, 2 and so on.
    std::vector<Index> vertices = {};
};

/// The agreement of one shape, level by level.
struct ESPALIER_API Agreement {
    std::vector<LevelAgreement> levels = {};
    SurfaceError picture = {};  ///< of a level with few enough faces to be drawn, or of none
    std::string note = {};      ///< what a reader should know besides; mostly empty

    /// Whether every level is; false if there is none.
    bool isWithin(const Bounds& bounds) const;
};

/// The version of OpenSubdiv that is compared with: "3.5.0".
ESPALIER_API std::string openSubdivVersion();

}  // namespace espalier::compare

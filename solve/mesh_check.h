// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/base/word.h>
#include <espalier/far/simulation_mesh.h>
#include <espalier/solve/constraint_patches.h>
#include <espalier/solve/mesh_quality.h>
#include <espalier/solve/validity.h>

#include <functional>
#include <optional>
#include <span>
#include <vector>

// Judges poses of the mesh of a simulation: which cells a pose breaks, and how far it may go.
namespace espalier::solve {

/// The poses of a mesh that count as valid.
enum class Criterion {
    Exact,  ///< no cell is inverted anywhere (ValidityCheck), and all volumes are positive
    Solver  ///< volumes are positive, by OpenFOAM's formula; and in a mesh of OpenFOAM, checkMesh
            ///< finds no further error (MeshCheck::solverErrors())
};
inline constexpr Word<Criterion> kCriterionWords[] = {{"exact", Criterion::Exact},
                                                      {"solver", Criterion::Solver}};

struct MeshCheckOptions {
    /// True for a mesh of OpenFOAM: Criterion::Solver then counts as checkMesh does.
    bool isOpenFoam = false;

    /// Rounds points to the numbers that will be stored. Empty if they are stored as doubles.
    std::function<std::vector<Point3>(std::vector<Point3>)> stored = {};
};

/// The effect of a pose on the cells of a mesh.
struct MeshVerdict {
    PoseValidity validity;  ///< of the whole pose
    LargestStep step;       ///< up to which no cell is inverted

    /// The largest share of the pose that Criterion::Solver accepts, found by halving within 1e-3;
    /// smaller shares are not proved. 1 if it accepts the pose.
    double solverStep = 1;

    /// The constraint patches in the whole pose.
    std::vector<PatchDeviation> patches;

    MeshQuality whole;    ///< the quality of the whole pose
    MeshQuality quality;  ///< the quality of the points that are written
    double written = 1;   ///< the share of the pose that is written

    /// False if no share of the pose is valid: rounded to the numbers that are stored, cells are
    /// broken even at rest. Only where the largest step was asked for.
    bool isRestValid = true;
};

/// Checks the cells of a mesh: the cells of its volume, or if there are none, its faces.
///
/// Immutable; any number of threads may use one at once. Results do not depend on the number of
/// threads.
class ESPALIER_API MeshCheck {
public:
    /// \param rest positions of the points at rest; copied
    /// \throws Error as ValidityCheck
    /// \cost O(points of cells), in parallel
    MeshCheck(far::SimulationMesh mesh, std::span<const Point3> rest,
              MeshCheckOptions options = {});

    /// The mesh, all of whose cells are checked.
    const far::SimulationMesh& mesh() const { return mesh_; }

    const std::vector<Index>& badAtRest() const { return check_.badAtRest(); }
    const MeshQuality& qualityAtRest() const { return before_; }

    /// Measures the mesh at points: meshQuality() or surfaceQuality().
    MeshQuality qualityAt(std::span<const Point3> points) const;

    /// The check without the quality.
    const ValidityCheck& validity() const { return check_; }

    /// Number of errors of a quality that Criterion::Solver counts, without those at rest: cells
    /// whose volume is not positive; and for a mesh of OpenFOAM, pyramids with a negative volume,
    /// and faces whose angle is above 90 degrees.
    Index solverErrors(const MeshQuality& quality) const;

    /// Judges a pose.
    /// \param points the positions in the pose. They are rounded as they will be stored
    /// \throws Error as ValidityCheck::check()
    /// \cost ValidityCheck::check() and largestStep(), and a few times meshQuality(); ten times
    ///       meshQuality() more if the solver refuses the pose
    MeshVerdict check(std::span<const Point3> points) const;

    /// Judges a pose, and goes back towards rest until no cell is broken. Patches are left as they
    /// are: a share of a pose breaks a plane as the pose does.
    /// \param points the positions in the pose; then those at MeshVerdict::written
    MeshVerdict shorten(std::vector<Point3>& points, Criterion criterion) const;

    /// The patches that do not fulfil their constraint at rest, by number. They are not checked.
    const std::vector<std::size_t>& patchesBrokenAtRest() const {
        return constraints_.brokenAtRest();
    }

    /// The check of the patches alone.
    const ConstraintPatches& constraints() const { return constraints_; }

    /// Returns true if a criterion accepts the whole pose of a verdict, and no patch is broken.
    bool accepts(const MeshVerdict& verdict, Criterion criterion) const;

private:
    bool isSound(const PoseValidity& validity, const MeshQuality& quality) const;
    std::vector<Point3> stored(std::vector<Point3> points) const;
    double solverStep(std::span<const Point3> pose, double valid) const;

    far::SimulationMesh mesh_;
    MeshCheckOptions options_;
    std::vector<Point3> rest_;
    ValidityCheck check_;
    ConstraintPatches constraints_;
    std::vector<CoupledFace> coupled_;
    MeshQuality before_;
};

}  // namespace espalier::solve

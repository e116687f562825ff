// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/model.h>
#include <espalier/solve/mesh_check.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "run.h"
#include "run_report.h"

namespace espalier::cli {

/// The options of commands that deform the mesh of a simulation.
struct MeshOptions {
    bool noInverted = false;   ///< refuse to write a pose that inverts cells
    bool largestStep = false;  ///< go only as far towards the pose as no cell is inverted
    solve::Criterion criterion = solve::Criterion::Exact;

    bool isRequired() const { return noInverted || largestStep; }
};

/// Adds --no-inverted, --largest-step and --criterion to a command.
void addMeshOptions(CLI::App& command, MeshOptions& options);

/// Reads the cells of a model in the stage "reading".
/// \throws Error if the file of the model, or a file beside it, is broken
io::ModelCells readCells(const io::Model& model, Stages& stages);

/// Returns numbers above 0 as text: "12 tetrahedra, 3 wedges; 12 of second order".
std::string countsText(std::span<const io::ElementCount> counts, Index secondOrder);

/// Returns an object of the names and numbers.
OrderedJson toJson(std::span<const io::ElementCount> counts);

/// The cells of a model, and its points at rest.
class MeshCheck {
public:
    /// Measures the cells in the stage "checking cells".
    /// \param path of the model, for messages
    /// \param cells the cells of the model
    /// \param output the file that will hold the poses, in its own format or as an animation
    /// \param poseCount number of poses that are written
    /// \throws FileError if the coordinates are too large to check
    MeshCheck(const std::filesystem::path& path, const io::Model& model, io::ModelCells cells,
              const std::filesystem::path& output, std::size_t poseCount, Stages& stages);

    /// False if the model has no cells that can be checked.
    bool hasCells() const { return check_.has_value(); }

    /// The elements that are not checked.
    const std::vector<io::ElementCount>& unchecked() const { return unchecked_; }

    /// Checks a pose in the stage "checking cells". With --largest-step, moves `points` back
    /// towards rest until the pose is valid.
    ///
    /// \param points deformed points, one per point of the model. The check and the quality are
    ///        computed after the points are rounded to the precision of the output
    solve::MeshVerdict check(std::vector<Point3>& points, const std::string& pose,
                             const MeshOptions& options, Stages& stages) const;

    /// Throws a FailedCheck if the criterion refuses a pose.
    /// \param pose its path
    void requireValid(const solve::MeshVerdict& verdict, const std::string& pose,
                      const MeshOptions& options) const;

    /// Prints warnings to standard error if a pose inverts cells or breaks patches.
    void warn(const solve::MeshVerdict& verdict, const std::string& pose) const;

    /// Returns a report of several lines. Of a mesh without cells that can be checked, it tells
    /// only what is not checked.
    std::string text(const solve::MeshVerdict& verdict, const std::string& pose) const;

    /// Returns an object with these keys:
    ///
    ///     pose                its path
    ///     cells               {tetrahedra, pyramids, wedges, hexahedra, polyhedra, triangles,
    ///                         quadrilaterals}: their numbers
    ///     second_order        how many of these are of second order
    ///     not_checked         {name: number} of the elements that are not checked
    ///     patches             [{name, type, distance, point, broken}] of the constraint patches
    ///                         (solve::PatchDeviation), in the whole pose
    ///     patches_not_checked names of the patches that break their constraint at rest
    ///
    /// and if there are cells to check:
    ///
    ///     parts               [{name, first_cell}] of a decomposed mesh; left out for any other
    ///     bad_at_rest         {count, first}: cells that are flat or folded at rest; first is null
    ///                         if there are none
    ///     inverted            {count, first}: cells that the whole pose inverts
    ///     smallest_ratio      {cell, volume_ratio}: the smallest volume ratio of the pose; null if
    ///                         all cells are bad at rest
    ///     largest_step        {length, limiting_cell, is_tight}: as in check_command.cpp
    ///     solver              {errors, largest_step}: the errors that a solver would find in the
    ///                         whole pose, and the largest share that it accepts (MeshVerdict)
    ///     written             share of the pose that is written: 1 without --largest-step
    ///     quality             {before, after}: of the points at rest and of the points written,
    ///                         {scaled_jacobian, non_orthogonality, mean_non_orthogonality,
    ///                         severely_non_orthogonal, beyond_right_angle, skewness,
    ///                         smallest_volume, non_positive_volumes, negative_pyramids}
    ///                         (solve/mesh_quality.h); null where nothing has the measure
    OrderedJson toJson(const solve::MeshVerdict& verdict, const std::string& pose) const;

private:
    std::string cellName() const;

    /// Returns the number of a cell, with its place in the part that has it.
    std::string cellText(Index cell) const;

    std::string solverName() const;
    std::string patchText(const solve::PatchDeviation& deviation) const;

    std::filesystem::path path_;
    std::filesystem::path output_;
    bool isOpenFoam_ = false;
    std::vector<io::ElementCount> unchecked_;
    std::optional<solve::MeshCheck> check_;
};

}  // namespace espalier::cli

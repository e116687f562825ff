// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/model.h>
#include <espalier/solve/mesh_quality.h>
#include <espalier/solve/validity.h>

#include <CLI/CLI.hpp>
#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "run.h"
#include "run_report.h"

namespace espalier::cli {

/// The options of commands that deform the mesh of a volume.
struct MeshOptions {
    bool noInverted = false;   ///< refuse to write a pose that inverts cells
    bool largestStep = false;  ///< go only as far towards the pose as no cell is inverted
};

/// Adds --no-inverted and --largest-step to a command.
void addMeshOptions(CLI::App& command, MeshOptions& options);

/// The effect of a pose on the cells of a mesh.
struct MeshVerdict {
    solve::PoseValidity validity;
    solve::LargestStep step;
    solve::MeshQuality quality;  ///< the quality of the points that are written

    double written = 1;  ///< the share of the pose that is written
};

/// Reads the cells of a model in the stage "reading".
/// \throws Error if the file of the model, or a file beside it, is broken
io::ModelVolume readVolume(const io::Model& model, Stages& stages);

/// The cells of a model, and its points at rest.
class MeshCheck {
public:
    /// Measures the cells in the stage "checking cells".
    /// \param path of the model, for messages
    /// \param volume the cells of the model
    /// \param output the file that will hold the poses, in its own format or as an animation
    /// \param poseCount number of poses that are written
    /// \throws FileError if the coordinates are too large to check
    MeshCheck(const std::filesystem::path& path, const io::Model& model, io::ModelVolume volume,
              const std::filesystem::path& output, std::size_t poseCount, Stages& stages);

    /// False if the model has no cells that can be checked.
    bool hasCells() const { return volume_.mesh.cellCount() > 0; }

    /// Number of cells that are not checked, since their edges are curved.
    Index curvedCells() const { return volume_.curvedCells; }

    /// Number of elements that are not checked, since their types are not known.
    Index unknownElements() const { return volume_.unknownElements; }

    /// Checks a pose in the stage "checking cells". With --largest-step, moves `points` back
    /// towards rest until no cell is inverted.
    ///
    /// \param points deformed points, one per point of the model. The check and the quality are
    ///        computed after the points are rounded to the precision of the output
    MeshVerdict check(std::vector<Point3>& points, const std::string& pose,
                      const MeshOptions& options, Stages& stages) const;

    /// Throws a FailedCheck if cells are inverted at the points of a verdict, or have no positive
    /// volume.
    ///
    /// \param pose its path
    void requireValid(const MeshVerdict& verdict, const std::string& pose) const;

    /// Prints a warning to standard error if a pose inverts cells.
    void warn(const MeshVerdict& verdict, const std::string& pose) const;

    /// Returns a report of several lines. Of a mesh without cells that can be checked, it tells
    /// only what is not checked.
    std::string text(const MeshVerdict& verdict, const std::string& pose) const;

    /// Returns an object with these keys:
    ///
    ///     pose                its path
    ///     cells               {tetrahedra, pyramids, wedges, hexahedra, polyhedra}: their numbers
    ///     curved_cells        number of cells that are not checked, since their edges are curved
    ///     unknown_elements    number of elements of types that are not known here
    ///
    /// and if there are cells to check:
    ///
    ///     bad_at_rest         {count, first}: cells that are flat or folded at rest; first is null
    ///                         if there are none
    ///     inverted            {count, first}: cells that the whole pose inverts
    ///     smallest_ratio      {cell, volume_ratio}: the smallest volume ratio of the pose; null if
    ///                         all cells are bad at rest
    ///     largest_step        {length, limiting_cell, is_tight}: as in check_command.cpp
    ///     written             share of the pose that is written: 1 without --largest-step
    ///     quality             {before, after}: of the points at rest and of the points written,
    ///                         {scaled_jacobian, non_orthogonality, mean_non_orthogonality,
    ///                         severely_non_orthogonal, skewness, smallest_volume,
    ///                         non_positive_volumes, negative_pyramids} (solve/mesh_quality.h);
    ///                         null where nothing has the measure
    OrderedJson toJson(const MeshVerdict& verdict, const std::string& pose) const;

private:
    bool isSound(const solve::PoseValidity& validity, const solve::MeshQuality& quality) const;
    std::vector<Point3> stored(std::vector<Point3> points) const;
    std::string kindsText() const;

    std::filesystem::path path_;
    std::filesystem::path output_;
    bool isAnimation_;
    const io::Model& model_;
    io::ModelVolume volume_;
    std::array<Index, 5> kinds_ = {};  ///< numbers of the standard cells, and of polyhedra
    std::optional<solve::ValidityCheck> check_;
    solve::MeshQuality before_;
};

}  // namespace espalier::cli

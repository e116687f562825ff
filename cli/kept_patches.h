// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/bind/bind.h>
#include <espalier/io/model.h>
#include <espalier/shapes/lattice.h>
#include <espalier/solve/sliding_points.h>

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bind_model.h"
#include "run.h"
#include "run_report.h"

// --hold and --slide of `espalier deform` and `espalier apply`: patches whose points stay, or stay
// on their planes, cylinders and lines.

namespace espalier::cli {

/// Adds --slide to a command.
void addSlideOption(CLI::App& command, std::vector<std::string>& patches);

/// The patches that are held or slide, and by how much they would have moved otherwise.
class KeptPatches {
public:
    /// Finds the shapes of the patches that slide, in the stage "sliding".
    /// \param path of the model, for messages
    /// \param slides the names of these patches; may be empty
    /// \throws FileError naming a patch that cannot slide, or that the model does not have
    KeptPatches(const std::string& path, const io::Model& model,
                const std::vector<std::string>& slides, Stages& stages);

    /// Finds how far the points would move that options.part holds, if it holds some.
    void measureHeld(const BindOptions& options, const io::Model& model, const Lattice& lattice,
                     Stages& stages);

    bool slidesAny() const { return sliding_.has_value(); }

    /// True if keep() has something to do.
    bool needsPoints() const { return sliding_ || held_; }

    /// Slides the points in a pose, and remembers the largest correction.
    /// \param pose positions of the vertices of the lattice
    void keep(std::vector<Point3>& points, const std::vector<Point3>& pose);

    /// \throws FileError if a patch is curved, so that a share of a pose leaves it
    void requireStraight() const;

    /// Returns a line for each option that was given:
    ///
    ///     held              24 points of inlet; the pose would move them by up to 0.12 (point 7)
    ///     slid              48 points of walls (4 planes); the pose ...
    std::string text() const;

    /// Adds to a report, if the options were given:
    ///
    ///     held  {points, patches: [name], largest_move, point}
    ///     slid  {points, patches: [{name, shapes: ["plane"]}], largest_move, point}
    ///
    /// The largest moves are over all poses; the points are null if nothing would have moved.
    void addTo(OrderedJson& json) const;

private:
    std::string path_;
    std::vector<std::string> holds_;
    Index heldCount_ = 0;
    std::optional<bind::Binding> held_;
    std::optional<solve::SlidingPoints> sliding_;
    solve::SlidingPoints::Correction largestHeld_, largestSlid_;
};

}  // namespace espalier::cli

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/shapes/lattice.h>
#include <espalier/shapes/pose.h>
#include <espalier/shapes/selection.h>

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pose_selection.h"

namespace espalier::cli {

/// Applies the steps of `espalier pose` to a lattice, one after the other.
class Posing {
public:
    /// \param lattice must outlive this
    /// \param movesHeld true: held vertices (shapes/held.h) move, too
    explicit Posing(const Lattice& lattice, bool movesHeld = false)
        : lattice_(lattice), movesHeld_(movesHeld), positions_(lattice.positions) {}

    const std::vector<Point3>& positions() const { return positions_; }

    /// Selects the vertices of `selection`; all vertices without one. Clears falloff, centre,
    /// pivot, range and direction. \throws CLI::ValidationError if no vertex is selected
    void select(std::optional<Selection> selection);

    /// \throws CLI::ValidationError if the selection takes no falloff, or for a radius of 0 or less
    void setFalloff(const shapes::Falloff& falloff);

    /// Replaces the positions by operate(positions, options).
    template <class Operate>
    void operate(const Operate& operate) {
        const std::vector<double> selected = weights();
        shapes::pose::Options options{selected, center, range};
        if (pivot) {
            options.center = pivotPoint();
            options.startsAtCenter = !range;
        }
        positions_ = operate(std::span<const Point3>(positions_), options);
    }

    /// Moves each selected vertex by its displacement in a file.
    /// \throws io::FileError
    void displace(const std::string& path);

    /// Mirrors the selected vertices to the other side of a plane.
    void mirror(const MirrorPlane& at);

    const Lattice& lattice() const { return lattice_; }

    /// The lines that tell which parts of the lattice the selections found.
    const std::vector<std::string>& found() const { return found_; }

    /// The notes on selections of few vertices.
    const std::vector<std::string>& notes() const { return notes_; }

    std::optional<Point3> center, toward;
    std::optional<Pivot> pivot;
    std::optional<std::array<double, 2>> range;

private:
    /// Lets a selection select some vertices, with a falloff along the cells.
    static void selectVertices(Selection& selection, std::vector<Index> vertices);

    /// Returns the vertices that are selected without the falloff.
    std::vector<Index> selectedVertices() const;

    /// Refuses a selection without vertices, and notes one with few.
    void checkCount();

    /// Returns the place of the pivot in the pose so far.
    Point3 pivotPoint() const;

    /// Returns the weight of each vertex, 0 for held ones; no weights if all vertices are selected
    /// and none is held. Selections use the positions in the file: operations before them do not
    /// matter. \throws CLI::ValidationError if all weights are 0 because the vertices are held
    std::vector<double> weights() const;

    const Lattice& lattice_;
    bool movesHeld_ = false;
    std::vector<Point3> positions_;
    std::optional<Selection> selection_;  ///< none: all vertices
    shapes::Falloff falloff_;
    std::vector<std::string> found_, notes_;
};

}  // namespace espalier::cli

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/stencils/stencil_table.h>

#include <algorithm>
#include <array>
#include <functional>
#include <span>
#include <vector>

namespace espalier::cages {

/// Asks a point of the surface to be on the outer side of a plane, and near it:
/// direction · x − offset is 0 or a little more.
struct PlaneTerm {
    Index row = 0;  ///< the row of the table that gives the point x
    Point3 direction = {};
    double offset = 0;
    double inside = 0;   ///< weight of the squared distance where x is on the inner side
    double outside = 0;  ///< weight where x is on the outer side
    double reach = 0;    ///< the energy grows linearly where the distance is larger
};

/// The shape of the cells of a lattice, as a function of its vertices.
///
/// At each corner of a cell, with edges e₁, e₂, e₃ to the three neighbours and their determinant d,
/// it is a mean of the squares of two quotients: ((|e₁|² + |e₂|² + |e₃|²) / 3)^1.5 / d, which is
/// least for a cube, and |e₁| |e₂| |e₃| / d, which is least for any right angles. The value is 1
/// for a cube of any size, and grows to infinity where the corner becomes flat. Corners of the
/// cells of level 0 and of level 1 count.
class CellShapes {
public:
    static constexpr int kLevel = 2;

    /// \param refiner a lattice with levels up to kLevel; kept by reference
    explicit CellShapes(const far::TopologyRefiner& refiner);

    /// Sets all weights to 1, and examines no cell.
    void resetWeights();

    /// Counts the corners of level 2 in some base cells, too.
    void examine(std::span<const Index> baseCells);

    /// Multiplies the weight of a base cell, up to 30 times the first weight.
    void scaleWeight(Index baseCell, double factor) {
        weights_[baseCell] = std::min(weights_[baseCell] * factor, 30.0);
    }

    /// Returns the energy and adds its gradient.
    double evaluate(std::span<const Point3> positions, std::span<Point3> gradient) const;

    /// Returns the steps of evaluate(), as Work counts them.
    double workOfEvaluation() const;

    /// Returns the least scaled Jacobian of each base cell: the determinant of the directions of
    /// the three edges of a corner of level 0, 1 or 2.
    /// \cost O(cells). The first call of this function or of examine() also computes the limits of
    ///       level 2
    std::vector<double> leastJacobians(std::span<const Point3> positions);

    Index cellCount() const { return static_cast<Index>(weights_.size()); }

private:
    struct Cell {
        std::array<Index, 8> vertices;
        Index baseCell;
    };
    struct LevelCells {
        stencils::StencilTable<double>
            table;  ///< vertices of the level over the base; empty for level 0
        std::vector<Cell> cells;
        double weight = 1;
        std::vector<Index> activeCells = {}, activeRows = {};
    };
    void addLevel();
    void addAllLevels();
    void activate();
    double evaluateCells(const LevelCells& level, std::span<const Point3> positions,
                         std::span<Point3> gradient) const;

    const far::TopologyRefiner& refiner_;
    std::vector<LevelCells> levels_;  ///< level 0, level 1 and, when it is first needed, level 2
    std::vector<double> weights_;     ///< one per base cell
    std::vector<char> isExamined_;
};

/// Adds the weighted squares of the distances of PlaneTerms; returns their sum.
double evaluatePlanes(const stencils::StencilTable<double>& table, std::span<const PlaneTerm> terms,
                      std::span<const Point3> positions, std::span<Point3> gradient);

/// A function of positions that returns its value and sets its gradient.
using Energy = std::function<double(std::span<const Point3>, std::span<Point3>)>;

/// Reduces an energy by the limited-memory BFGS method.
/// \param longestStep no vertex moves further in one iteration
/// \return the positions after at most `iterations` iterations
std::vector<Point3> minimise(const Energy& energy, std::vector<Point3> positions, int iterations,
                             double longestStep);

}  // namespace espalier::cages

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/cell_solver.h>
#include <espalier/embed/embedding.h>
#include <espalier/embed/point_descent.h>
#include <espalier/embed/point_location.h>
#include <espalier/embed/table_form.h>

#include <memory>
#include <span>
#include <vector>

// Two ways to bind points that lie together, with the same result: in a part of the level that is
// refined for them, or in the whole level, which serves all groups.
namespace espalier::embed {

template <class Table>
class GroupBinder {
public:
    virtual ~GroupBinder() = default;

    /// Binds a group of points. Any number of threads may ask.
    /// \return all of the points; where a later part has some of them again, that counts, and the
    ///         earlier one has no entries for these
    virtual std::vector<BoundPart<Table>> bind(std::span<const Point3> points) const = 0;
};

/// In a part of the level, which is refined for the group.
template <class Table>
class PartBinder : public GroupBinder<Table> {
public:
    /// \param base, positions must outlive this
    PartBinder(const far::TopologyRefiner& base, std::span<const Point3> positions, int level,
               stencils::Rules rules, const EmbeddingOptions& options);

    std::vector<BoundPart<Table>> bind(std::span<const Point3> points) const override;

private:
    BoundPart<Table> bindInside(std::span<const Point3> points,
                                std::vector<Index>& unsettled) const;
    BoundPart<Table> bindBeside(std::span<const Point3> points) const;

    int level_;
    bool seekNearest_;
    CellSolver::Scale scale_;
    PointDescent descent_;
};

/// In the whole level.
template <class Table>
class WholeBinder : public GroupBinder<Table> {
public:
    /// \cost O(cells of the level)
    WholeBinder(const far::TopologyRefiner& base, std::span<const Point3> positions, int level,
                stencils::Rules rules, const EmbeddingOptions& options);

    std::vector<BoundPart<Table>> bind(std::span<const Point3> points) const override;

private:
    far::CellComplex complex_;
    bool seekNearest_;
    std::unique_ptr<const PointLocator> locator_;
    stencils::StencilTable<double> stencils_;  ///< S of the level
    std::vector<Index> baseCells_;             ///< that each cell lies in
    Index baseCellCount_;
};

}  // namespace espalier::embed

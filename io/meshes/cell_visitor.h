// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/far/standard_cells.h>

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace espalier::io {

/// Returns the name of a group that has only a number in the file: "line 3", "surface 3" or
/// "volume 3".
std::string nameOfGroup(int dimension, std::string_view number);

/// Receives the cells of a file, in their order.
class CellVisitor {
public:
    virtual ~CellVisitor() = default;

    /// Returns true if the visitor needs beginGroups().
    virtual bool wantsGroups() const { return false; }

    /// The elements from here on belong to these groups, until the next call. At the beginning,
    /// elements belong to none.
    virtual void beginGroups(std::span<const std::string>) {}

    /// Points of these groups that the file names without elements.
    /// \param dimension of the elements that they are points of; 0 for a set of nodes
    virtual void groupPoints([[maybe_unused]] int dimension, std::span<const Index>) {}

    /// A side of a cell that is in these groups, and no element: an edge or a face.
    /// \param dimension 1 or 2
    /// \param corners in the order around the face
    /// \param points the corners and, in a cell of second order, the points between them
    virtual void groupSide([[maybe_unused]] int dimension,
                           [[maybe_unused]] std::span<const Index> corners,
                           [[maybe_unused]] std::span<const Index> points) {}

    /// A tetrahedron, pyramid, wedge or hexahedron.
    /// \param points in VTK's order
    virtual void cell(far::StandardCell kind, std::span<const Index> points) = 0;

    /// \param loops the faces; each anticlockwise seen from outside, unless the format does not say
    virtual void polyhedron(std::span<const std::vector<Index>> loops) = 0;

    /// A face of a surface, in the order around it.
    virtual void face(std::span<const Index> points) = 0;

    /// A face of a cell on the boundary, from a format that lists the faces of its cells.
    virtual void boundaryFace(std::span<const Index>) {}

    /// The points of a group are periodic images of the points of another group, or of the same
    /// one. Comes after the elements. \param images points of the group, each with its image
    virtual void periodic([[maybe_unused]] const std::string& group,
                          [[maybe_unused]] const std::string& partner,
                          std::span<const std::array<Index, 2>>) {}

    /// A vertex (dimension 0) or a straight line (dimension 1).
    virtual void smallCell(int dimension, std::span<const Index> points) = 0;

    /// A cell whose edges are curved, such as a quadratic one. It has the vertices of a straight
    /// one, and more.
    /// \param dimension 1 to 3
    /// \param points of a cell of second order, in the order of far::cellPoints(); of a face of
    ///        second order, in the order of far::SurfaceMesh::addFace(); of a line of any order,
    ///        its two ends first. Empty for all others
    virtual void curvedCell(int dimension, std::span<const Index> points) = 0;

    /// An element of a type that the reader does not know.
    /// \param line, cause the place of the element and a message, for a visitor that needs all
    virtual void unknownElement(std::size_t line, const std::string& cause) = 0;
};

}  // namespace espalier::io

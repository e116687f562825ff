// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/error.h>
#include <espalier/base/index.h>

#include <string>

namespace espalier::far {

/// The cause for rejecting a topology.
enum class TopologyCause {
    EmptyComplex,      ///< no cell (lattice), no face (mesh) or no edge (curve)
    VertexOutOfRange,  ///< a loop, an edge or a mark names a vertex that does not exist
    EntityOutOfRange,  ///< a cell names a face, or a face an edge, that does not exist
    UnusedEntity,      ///< a vertex, edge or face bounds nothing
    TooFewVertices,    ///< a face has fewer than three vertices
    RepeatedVertex,    ///< a face or an edge names a vertex twice
    OpenCell,          ///< an edge of a cell is in only one face of that cell
    CrowdedEdge,       ///< an edge is in more than two faces of one cell
    CrowdedFace,       ///< a face bounds more than two cells
    RepeatedFace,      ///< a cell contains a face twice
    RepeatedCell,      ///< two cells have the same faces
    PinchedCell,       ///< the faces of a cell at one of its vertices form more than one fan
    NotASphere,        ///< the surface of a cell is in pieces, or has a handle
    NotOrientable,     ///< the cells (or the faces of one cell) cannot be oriented coherently
    WrongDimension,    ///< a cell for a mesh, or a face for a lattice or a curve
    NotABox,           ///< a lattice is not a box of hexahedra, as required
    BadMark,           ///< a marked edge does not exist, or a mark's value has no meaning
    TooManyEntities    ///< there are more entities than an Index can count
};

/// Thrown for a topology that cannot be built or refined.
class ESPALIER_API TopologyError : public Error {
public:
    TopologyError(TopologyCause cause, Entity entity, const std::string& what)
        : Error(what), cause_(cause), entity_(entity) {}

    TopologyCause cause() const { return cause_; }

    /// Returns the offender; for EmptyComplex, its dimension is the dimension of the missing
    /// entities.
    Entity entity() const { return entity_; }

private:
    TopologyCause cause_;
    Entity entity_;
};

}  // namespace espalier::far

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/error.h>
#include <espalier/base/index.h>

#include <string>

namespace espalier::far {

/// Why a topology is refused.
enum class TopologyCause {
    EmptyComplex,      ///< no cell (lattice), no face (mesh) or no edge (curve)
    VertexOutOfRange,  ///< a loop, an edge or a mark names a vertex that does not exist
    EntityOutOfRange,  ///< a cell names a face, or a face an edge, that does not exist
    UnusedEntity,      ///< a vertex, edge or face that bounds nothing
    TooFewVertices,    ///< a face of fewer than three vertices
    RepeatedVertex,    ///< a face or an edge that names a vertex twice
    OpenCell,          ///< an edge of a cell with only one face of that cell
    CrowdedEdge,       ///< an edge with more than two faces of one cell
    CrowdedFace,       ///< a face of more than two cells
    RepeatedFace,      ///< a face twice in one cell
    RepeatedCell,      ///< two cells with the same faces
    PinchedCell,       ///< the faces of a cell at one of its vertices form more than one fan
    NotASphere,        ///< the surface of a cell is in pieces, or has a handle
    NotOrientable,     ///< the cells (or the faces of one cell) cannot be oriented coherently
    WrongDimension,    ///< a cell for a mesh, a face for a lattice or a curve
    NotABox,           ///< a lattice that is not a box of hexahedra, where it should be
    BadMark,           ///< a mark on an edge that does not exist, or of a value without meaning
    TooManyEntities    ///< more entities than an Index counts
};

/// A topology that cannot be built or refined.
class ESPALIER_API TopologyError : public Error {
public:
    TopologyError(TopologyCause cause, Entity entity, const std::string& what)
        : Error(what), cause_(cause), entity_(entity) {}

    TopologyCause cause() const { return cause_; }

    /// The offender; for EmptyComplex, dimension is that of the missing entities.
    Entity entity() const { return entity_; }

private:
    TopologyCause cause_;
    Entity entity_;
};

}  // namespace espalier::far

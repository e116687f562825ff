// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "find_parts.h"
#include "model_voxels.h"

namespace espalier::cages {

/// The parts of a model in the cubes of a grid, and their contacts.
///
/// At first, each connected part of the model in a cube is a part of its own, and two parts have a
/// contact where the model passes through the face between their cubes. The functions below leave
/// out, join and add parts. GridCells calls them until each part can be a cell.
///
/// If the parts are symmetric about planes, each part has a mirror image, perhaps itself, and the
/// functions do the same to all images of a part at once.
class CubeParts {
public:
    using Cube = Cubes::Cube;
    using Part = CubePart;
    using Contact = CubePart::Contact;
    static constexpr Index kDirections = cages::kDirections;

    /// \param voxels is kept by reference
    /// \param perEdge voxels along the edge of a cube
    /// \param offset voxels of the first cube outside the grid
    /// \param joinDistance parts in one cube, or in two neighbours, that are at most this far
    ///        apart are one part, or in contact; in voxels
    /// \param mirrorAxes bit i: the voxels are symmetric about the middle of the grid along axis i.
    ///        This is in the middle of a cube, or between two
    CubeParts(const ModelVoxels& voxels, Index perEdge, const Cube& offset, double joinDistance,
              unsigned mirrorAxes);

    std::span<const Part> all() const { return parts_; }
    const Part& operator[](Index part) const { return parts_[part]; }
    Index count() const { return static_cast<Index>(parts_.size()); }

    /// Returns the number of a cube. Numbers ascend by layers.
    Index numberOf(const Cube& cube) const { return cubes_.numberOf(cube); }
    /// Returns the lowest corner of a cube.
    Point3 cornerOf(const Cube& cube) const;
    /// Returns the part that holds a point of the model.
    std::optional<Index> partAt(const Point3& point) const;

    /// Returns the part behind a face, unless there is none or there are several.
    std::optional<Index> neighbour(Index part, Index direction) const;
    /// Returns true if several parts are behind a face.
    bool hasSeveral(Index part, Index direction) const;
    /// Returns the faces with a part behind them, as bits.
    unsigned sharedFaces(Index part) const;
    /// Returns true if the topology stays the same without a part.
    bool isRemovable(Index part) const;
    /// Returns true if no voxel of a part is further than `most` from the shared faces, in voxels.
    /// The answer no, which is the most frequent one, does not take all voxels.
    /// \param depth becomes the largest of the distances, if the answer is yes
    bool isShallow(Index part, double most, double& depth) const;

    /// Returns the mirror image of a part across an axis that has a plane.
    Index imageOf(Index part, int axis) const;

    /// Returns a part and all its mirror images, each once.
    std::vector<Index> orbitOf(Index part) const;

    /// Leaves out a part, if it is removable and shallow. Its voxels go to the neighbours.
    /// \return false if the part stays
    bool leaveOut(Index part, double most);
    /// Joins a part to another one in the same cube.
    /// \param joins number of parts in a row that were joined for the same reason
    void join(Index kept, Index other, int joins);
    /// Adds a contact, on both sides, to what the two parts share already.
    void addContact(Index part, const Contact& contact);
    /// Adds a part in one of the eight cubes from `low` on, beside the parts around a vertex.
    void add(const Cube& low, std::span<const Index> members);

    /// A place where two parts of the model run side by side for more than one cube and are joined
    /// all the same.
    const std::optional<Point3>& joined() const { return joined_; }

private:
    void findImages();
    Cube mirrored(Cube cube, unsigned axes) const;
    Index imageOf(Index part, unsigned axes) const;
    Index alive(Index part) const;
    template <class Visit>
    void forEachMirror(Visit visit) const;
    bool areShallow(const Part& part, unsigned faces, double most, double& depth) const;
    bool areApart(std::span<const Index> orbit) const;
    bool detachAll(std::span<const Index> orbit);
    void detach(Index part);
    void giveVoxels(Index part, const std::array<std::optional<Index>, kDirections>& neighbours);
    void joinPair(Index kept, Index other, int joins);
    void addOneContact(Index part, const Contact& contact);
    bool isClosedAround(Index part, Index first, Index second) const;
    double squareToFace(const Cube& cube, Index direction, const std::array<Index, 3>& place) const;

    const ModelVoxels& voxels_;
    Cubes cubes_;
    unsigned mirrorAxes_;
    std::vector<Part> parts_;
    std::vector<std::array<Index, 3>> images_;  ///< of each part, across each axis with a plane
    std::vector<Index> joinedTo_;  ///< the part that each part was joined to, or itself
    std::vector<Index> partOf_;    ///< the part of each voxel of the model, by its rank
    std::optional<Point3> joined_;
};

/// Returns the direction from the other side of a face.
inline Index opposite(Index direction) {
    return direction ^ 1;
}

/// Returns true if a corner of a cube is on a face. Bit i of a corner is set on the higher side of
/// axis i.
inline bool isOnFace(unsigned corner, Index direction) {
    return (corner >> (direction / 2) & 1) == static_cast<unsigned>(direction & 1);
}

}  // namespace espalier::cages

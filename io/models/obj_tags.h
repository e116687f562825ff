// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/cell_complex.h>
#include <espalier/far/marks.h>
#include <espalier/shapes/lattice.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>
#include <vector>

#include "obj_statements.h"

namespace espalier::io {

/// The tags of an OBJ (obj_mesh.h): gathered while it is read, and checked when its mesh is known,
/// as they may come before the faces that they name.
class ObjTags {
public:
    explicit ObjTags(std::filesystem::path path) : path_(std::move(path)) {}

    /// Takes in a `t` statement. One with a name that is not known is passed over.
    /// \param words those after the `t`
    /// \throws FileError if its counts do not fit its name or its words, or a word is malformed
    void add(ObjWords& words, std::size_t line);

    const RefinementTags& refinement() const { return refinement_; }

    /// The marks, canonical (lattice_parts.h) and without those of sharpness 0. The corner of a
    /// dropped vertex goes with it.
    /// \param dropped the vertices of the file that the mesh lacks, ascending
    /// \throws FileError with the line of a tag that names what the mesh does not have
    far::Marks marks(const far::CellComplex& mesh, std::span<const Index> dropped) const;

private:
    struct Tag;
    struct Kind;

    /// The vertices of a crease or a corner, or the face of a hole, as the file gives them.
    template <std::size_t count>
    struct Mark {
        std::size_t line;
        std::array<std::int64_t, count> numbers;
        double sharpness;
    };

    Tag parse(const Kind& kind, ObjWords& words, std::size_t line) const;
    void addCreases(const Tag& tag);
    void addCorners(const Tag& tag);
    void addHoles(const Tag& tag);
    void setBoundary(const Tag& tag);
    void setCreasing(const Tag& tag);
    void setTriangles(const Tag& tag);

    Index checkedNumber(std::int64_t number, Index count, const char* what, std::size_t line) const;

    std::filesystem::path path_;
    std::vector<Mark<2>> creases_;
    std::vector<Mark<1>> corners_;
    std::vector<Mark<1>> holes_;
    RefinementTags refinement_;
};

}  // namespace espalier::io

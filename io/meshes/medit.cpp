// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include "mesh_format.h"

// Reads meshes of Medit in ASCII (.mesh), of two or three dimensions, as Gmsh, MMG and FreeFEM
// write them.
//
// The points are the Vertices. Tetrahedra, Pyramids, Prisms and Hexahedra are cells; Triangles and
// Quadrilaterals are faces. All other sections are skipped.
//
// A mesh of two dimensions has no z, so new positions must have z = 0.

namespace espalier::io {
namespace {

/// A section of elements. Each element is the numbers of its vertices, from 1, and a reference.
struct ElementSection {
    std::string_view keyword;
    int dimension;
    std::size_t nodes;
    std::optional<far::StandardCell> kind = {};
    bool isCurved = false;
    bool hasKnownOrder = false;  ///< of a curved element: the order of far::cellPoints()
};

constexpr ElementSection kElementSections[] = {
    {"Corners", 0, 1},
    {"Edges", 1, 2},
    {"Triangles", 2, 3},
    {"Quadrilaterals", 2, 4},
    {"Tetrahedra", 3, 4, far::StandardCell::Tetrahedron},
    {"Pyramids", 3, 5, far::StandardCell::Pyramid},
    {"Prisms", 3, 6, far::StandardCell::Wedge},
    {"Hexahedra", 3, 8, far::StandardCell::Hexahedron},
    {"EdgesP2", 1, 3, {}, true, true},
    {"TrianglesP2", 2, 6, {}, true, true},
    {"QuadrilateralsQ2", 2, 9, {}, true, true},
    {"TetrahedraP2", 3, 10, {}, true, true},
    {"HexahedraQ2", 3, 27, {}, true},
};

class MeditReader {
public:
    MeditReader(const std::filesystem::path& path, std::string_view bytes)
        : path_(path), bytes_(bytes), text_(path, bytes) {
        text_.skipComments('#');
        if (text_.token("MeshVersionFormatted") != "MeshVersionFormatted")
            text_.fail(
                "the file does not begin with MeshVersionFormatted; the binary format "
                "(.meshb) cannot be read");
        text_.number<std::int64_t>("the version of the format");
    }

    FileNumbers readPoints() {
        FileNumbers numbers;
        while (const auto keyword = nextKeyword()) {
            if (*keyword != "Vertices") continue;
            numbers.dimension = dimension();
            const std::size_t count =
                text_.count("the number of vertices", 2 * (numbers.dimension + 1));
            numbers.points.reserveMore(count);
            for (std::size_t i = 0; i < count; ++i) {
                Point3& position = numbers.points.values.emplace_back(Point3{0, 0, 0});
                CoordinateOffsets& offsets = numbers.points.offsets.emplace_back();
                for (std::size_t axis = 0; axis < numbers.dimension; ++axis) {
                    const std::string_view word = text_.token("a coordinate");
                    position[axis] =
                        parseCoordinate(word, axis, Precision::Double, path_, text_.line());
                    offsets[axis] = word.data() - bytes_.data();
                }
                text_.token("the reference of a vertex");
            }
            readSection_ = *keyword;
            nextKeyword();  // Refuses further rows.
            return numbers;
        }
        text_.fail("the file ends; expected Vertices");
    }

    void readCells(Index pointCount, CellVisitor& visitor) {
        while (const auto keyword = nextKeyword())
            for (const ElementSection& section : kElementSections)
                if (section.keyword == *keyword) {
                    readElements(section, pointCount, visitor);
                    readSection_ = *keyword;
                }
    }

private:
    std::size_t dimension() const {
        if (dimension_ == 0) text_.fail("Vertices come before Dimension");
        return dimension_;
    }

    /// Returns the next keyword; nothing at the end of the file. Skips the numbers of sections that
    /// are not read.
    /// \throws FileError if numbers follow a section that has been read
    std::optional<std::string_view> nextKeyword() {
        while (!text_.atEnd()) {
            const std::string_view word = text_.token("a keyword");
            const char first = word[0];
            const bool isLetter = (first >= 'A' && first <= 'Z') || (first >= 'a' && first <= 'z');
            if (!isLetter && !readSection_.empty())
                text_.fail(
                    concat("more rows follow than the number after ", readSection_, " says"));
            if (!isLetter) continue;
            readSection_ = {};
            if (word == "End") return std::nullopt;
            if (word != "Dimension") return word;
            dimension_ = text_.number<std::uint8_t>("the dimension");
            if (dimension_ != 2 && dimension_ != 3)
                text_.fail(concat("the dimension is ", dimension_, "; expected 2 or 3"));
        }
        return std::nullopt;
    }

    void readElements(const ElementSection& section, Index pointCount, CellVisitor& visitor) {
        const std::size_t count = text_.count("the number of elements", 2 * section.nodes);
        std::vector<Index> nodes(section.nodes);
        const bool hasReference = section.dimension > 0;
        std::string_view last;  // the last reference
        for (std::size_t i = 0; i < count; ++i) {
            for (Index& node : nodes) {
                const auto number = text_.number<std::int64_t>("a vertex of an element");
                if (number < 1 || number > pointCount)
                    text_.fail(concat("an element names vertex ", number, "; there are ",
                                      pointCount, ", counted from 1"));
                node = static_cast<Index>(number - 1);
            }
            if (hasReference) {
                const std::string_view reference = text_.token("the reference of an element");
                if (visitor.wantsGroups() && section.dimension >= 1 &&
                    (i == 0 || reference != last)) {
                    last = reference;
                    const std::string name = nameOfGroup(section.dimension, reference);
                    visitor.beginGroups(std::span(&name, 1));
                }
            }
            if (section.isCurved)
                visitor.curvedCell(section.dimension, section.hasKnownOrder && !hasOrderings_
                                                          ? nodes
                                                          : std::vector<Index>{});
            else if (section.kind)
                visitor.cell(*section.kind, nodes);
            else if (section.dimension == 2)
                visitor.face(nodes);
            else
                visitor.smallCell(section.dimension, nodes);
        }
    }

    const std::filesystem::path& path_;
    std::string_view bytes_;
    TextReader text_;
    std::size_t dimension_ = 0;

    /// True if the file lists orders of the nodes of curved elements (TetrahedraP2Ordering). They
    /// are not read, and so these elements are not checked.
    bool hasOrderings_ = bytes_.find("Ordering") != std::string_view::npos;
    std::string_view readSection_;  ///< keyword of the section that was read last, until the next
};

constexpr MeshFormat kMeditMesh = {
    [](const std::filesystem::path& path, std::string_view bytes) {
        return MeditReader(path, bytes).readPoints();
    },
    [](const std::filesystem::path& path, std::string_view bytes, Index pointCount,
       CellVisitor& visitor) { MeditReader(path, bytes).readCells(pointCount, visitor); }};

}  // namespace

const Format kMeditFormat = {.extensions = {".mesh"},
                             .isMesh = true,
                             .readModel = readMeshModel<kMeditMesh>,
                             .readLattice = readMeshLattice<kMeditMesh>};

}  // namespace espalier::io

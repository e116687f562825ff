// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <tuple>
#include <utility>

#include "../files/bytes.h"
#include "../files/number_types.h"
#include "gmsh_elements.h"
#include "mesh_format.h"
#include "node_numbers.h"

// Reads meshes of Gmsh (.msh) of the versions 2 to 2.2 and 4.1, ASCII and binary.
//
// The points are the nodes, in the order of the file; the tags of nodes may be any numbers. The
// elements of the types 4 (tetrahedron), 5 (hexahedron), 6 (prism) and 7 (pyramid) are cells; the
// types 2 (triangle) and 3 (quadrangle) are faces. Elements of second order (8 to 14 and 16 to 19)
// are curved, with all of their nodes; of those of higher order, only the number is read. In ASCII,
// elements of types that are not known here are counted; in binary they are refused, since their
// length is not known. Version 2.2 may have $ParametricNodes instead of $Nodes.
//
// Elements of a volume that are curved cannot be cells of a lattice.

namespace espalier::io {
namespace {

/// Reads the sections of a file in order.
class GmshReader {
public:
    GmshReader(const std::filesystem::path& path, std::string_view bytes)
        : path_(path), bytes_(bytes), text_(path, bytes) {
        std::string_view first = bytes.substr(0, bytes.find('\n'));
        if (const std::string_view word = takeWord(first); word == "$NOD")
            throw FileError(path, 1,
                            "the file is of the version 1 of Gmsh's format; write the mesh with "
                            "gmsh FILE -save -format msh41");
        seek("MeshFormat");
        const std::string_view version = text_.token("the version of the format");
        // The versions 2 to 2.2 differ in sections that are not read.
        constexpr std::string_view kVersions[] = {"2", "2.0", "2.1", "2.2", "4.1"};
        if (std::ranges::count(kVersions, version) == 0)
            text_.fail("the version of the format is " + inQuotes(version) +
                       "; expected 2.2 or 4.1: write the mesh with gmsh FILE -save -format msh41");
        isVersion4_ = version == "4.1";
        isBinary_ = text_.number<std::int64_t>("the type of the file, 0 or 1") == 1;
        const auto size = text_.number<std::int64_t>("the size of a number");
        if (size != 8) text_.fail(concat("the size of a number is ", size, " bytes; expected 8"));
        if (isBinary_) readByteOrder();
        expectEnd("$EndMeshFormat");
    }

    FileNumbers readPoints() {
        FileNumbers numbers;
        if (order_) numbers.setBinary(*order_, Precision::Double);
        readNodes([&](std::int64_t) {
            Point3& position = numbers.points.values.emplace_back();
            CoordinateOffsets& offsets = numbers.points.offsets.emplace_back();
            for (std::size_t axis = 0; axis < 3; ++axis)
                std::tie(position[axis], offsets[axis]) = coordinate(axis);
        });
        return numbers;
    }

    void readCells(CellVisitor& visitor) {
        Index next = 0;
        readNodes([&](std::int64_t tag) {
            tags_.add(tag, next++);
            for (std::size_t axis = 0; axis < 3; ++axis) coordinate(axis);
        });
        if (const auto twice = tags_.sort()) text_.fail(concat("two nodes have the tag ", *twice));
        if (visitor.wantsGroups()) readGroups();
        if (isVersion4_)
            readElements4(visitor);
        else
            readElements2(visitor);
        if (visitor.wantsGroups()) readPeriodic(visitor);
    }

private:
    void readByteOrder() {
        text_.restOfLine();
        const std::string_view one = text_.bytes(sizeof(std::int32_t), "the number 1");
        for (const std::endian order : {std::endian::little, std::endian::big})
            if (loadNumber<std::int32_t>(one.data(), order) == 1) order_ = order;
        if (!order_) text_.fail("the binary number after the version is not 1");
    }

    /// Goes to the line after $name, or after $other if that comes first. Skips other sections.
    /// Returns the section that was found, "$name".
    std::string seek(const std::string& name, const std::string& other = {}) {
        const std::string wanted = "$" + name;
        while (true) {
            if (text_.atEnd()) text_.fail("the file ends; expected " + wanted);
            const std::string_view keyword = text_.token("a section, such as $Nodes");
            if (!keyword.starts_with('$'))
                text_.fail("expected a section such as $Nodes, got " + inQuotes(keyword));
            if (keyword == wanted || (!other.empty() && keyword == "$" + other)) {
                text_.restOfLine();
                return std::string(keyword);
            }
            const std::string end = "$End" + std::string(keyword.substr(1));
            text_.restOfLine();
            const std::size_t at = bytes_.find(end, text_.position());
            if (at == std::string_view::npos)
                text_.fail("the section " + inQuotes(keyword) + " does not end");
            skipTo(at + end.size());
        }
    }

    /// Skips to an offset, and counts the lines before it.
    void skipTo(std::size_t offset) {
        while (text_.position() < offset) {
            const std::size_t end = bytes_.find('\n', text_.position());
            if (end >= offset) {
                text_.bytes(offset - text_.position(), "the end of a section");
                break;
            }
            text_.restOfLine();
        }
    }

    /// Ends a section.
    void expectEnd(const std::string& name) {
        const std::string_view keyword = text_.token(name.c_str());
        if (keyword != name) text_.fail(concat("expected ", name, ", got ", inQuotes(keyword)));
        text_.restOfLine();
    }

    /// Reads an integer: binary as the Stored type, or as text.
    template <class Stored>
    std::int64_t integer(const char* what) {
        if (!isBinary_) return text_.number<std::int64_t>(what);
        const auto number = loadNumber<Stored>(text_.bytes(sizeof(Stored), what).data(), *order_);
        if (!std::in_range<std::int64_t>(number))
            text_.fail(concat(what, " is ", number, ", which is out of range"));
        return static_cast<std::int64_t>(number);
    }

    /// Reads a number of items of at least `minBytes` bytes each.
    template <class Stored>
    std::size_t count(const char* what, std::size_t minBytes) {
        const std::int64_t number = integer<Stored>(what);
        if (number < 0) text_.fail(concat(what, " is ", number));
        text_.checkRoom(number, minBytes, what);
        return number;
    }

    /// Reads a coordinate, and tells its offset.
    std::pair<double, std::size_t> coordinate(std::size_t axis) {
        if (!isBinary_) {
            const std::string_view word = text_.token("a coordinate");
            return {parseCoordinate(word, axis, Precision::Double, path_, text_.line()),
                    word.data() - bytes_.data()};
        }
        const std::size_t offset = text_.position();
        text_.bytes(sizeof(double), "a coordinate");
        return {loadReal(bytes_, offset, Precision::Double, *order_), offset};
    }

    /// Reads $Nodes. Calls readCoordinates(tag) for each node, which must read three coordinates.
    template <class ReadCoordinates>
    void readNodes(ReadCoordinates readCoordinates) {
        const std::string section = isVersion4_ ? seek("Nodes") : seek("Nodes", "ParametricNodes");
        if (isVersion4_)
            readNodes4(readCoordinates);
        else
            readNodes2(readCoordinates, section == "$ParametricNodes");
        expectEnd("$End" + section.substr(1));
    }

    template <class ReadCoordinates>
    void readNodes2(ReadCoordinates readCoordinates, bool isParametric) {
        const std::size_t nodeCount = text_.count("the number of nodes", isBinary_ ? 28 : 8);
        if (isBinary_) text_.restOfLine();
        for (std::size_t i = 0; i < nodeCount; ++i) {
            readCoordinates(integer<std::int32_t>("the number of a node"));
            if (!isParametric) continue;
            // The entity that the node lies on, and one parameter on a curve or two on a surface.
            const std::int64_t dimension = integer<std::int32_t>("the dimension of an entity");
            integer<std::int32_t>("the tag of an entity");
            for (std::int64_t axis = 0; dimension <= 2 && axis < dimension; ++axis) skipParameter();
        }
    }

    template <class ReadCoordinates>
    void readNodes4(ReadCoordinates readCoordinates) {
        const std::size_t blockCount =
            count<std::uint64_t>("the number of blocks of nodes", isBinary_ ? 20 : 8);
        const std::size_t nodeCount =
            count<std::uint64_t>("the number of nodes", isBinary_ ? 32 : 8);
        integer<std::uint64_t>("the smallest tag of a node");
        integer<std::uint64_t>("the largest tag of a node");
        std::vector<std::int64_t> tags;
        std::size_t total = 0;
        for (std::size_t block = 0; block < blockCount; ++block) {
            const std::int64_t dimension = integer<std::int32_t>("the dimension of an entity");
            integer<std::int32_t>("the tag of an entity");
            const bool isParametric =
                integer<std::int32_t>("whether nodes have parameters, 0 or 1") != 0;
            if (dimension < 0 || dimension > 3)
                text_.fail(concat("an entity has the dimension ", dimension, "; expected 0 to 3"));
            const std::size_t inBlock =
                count<std::uint64_t>("the number of nodes of a block", isBinary_ ? 32 : 8);
            tags.clear();
            for (std::size_t i = 0; i < inBlock; ++i)
                tags.push_back(integer<std::uint64_t>("the tag of a node"));
            for (const std::int64_t tag : tags) {
                readCoordinates(tag);
                for (std::int64_t i = 0; isParametric && i < dimension; ++i) skipParameter();
            }
            total += inBlock;
        }
        if (total != nodeCount)
            text_.fail(concat("the blocks have ", total, " nodes, but $Nodes claims ", nodeCount));
    }

    void skipParameter() {
        if (isBinary_)
            text_.bytes(sizeof(double), "a parameter of a node");
        else
            text_.token("a parameter of a node");
    }

    Index indexOf(std::int64_t tag) const {
        if (const auto node = tags_.find(tag)) return *node;
        text_.fail(concat("an element names node ", tag, ", which does not exist"));
    }

    /// Returns a type; nothing if its number of nodes is not known.
    /// \throws FileError if it is not known in a binary file, where nothing can be skipped
    std::optional<GmshElementType> typeOf(std::int64_t number) const {
        if (const auto type = gmshElementType(number)) return type;
        if (isBinary_) text_.fail(unknownType(number));
        return std::nullopt;
    }

    static std::string unknownType(std::int64_t number) {
        return concat("an element has the type ", number, ", which is not known here");
    }

    /// Passes an element of an unknown type to a visitor, and skips the rest of its line.
    void visitUnknown(std::int64_t number, CellVisitor& visitor) {
        visitor.unknownElement(text_.line(), unknownType(number));
        text_.restOfLine();
    }

    void visit(const GmshElementType& type, CellVisitor& visitor) {
        if (type.isCurved && type.kind) {
            visitor.curvedCell(type.dimension, gmshCellInVtkOrder(*type.kind, nodes_));
        } else if (type.kind) {
            // The first triangle of a prism is anticlockwise seen from the other one, unlike VTK's.
            if (type.kind == far::StandardCell::Wedge) {
                std::swap(nodes_[1], nodes_[2]);
                std::swap(nodes_[4], nodes_[5]);
            }
            visitor.cell(*type.kind, nodes_);
        } else if (type.isCurved) {
            visitor.curvedCell(type.dimension, type.isSecondOrderFace || type.dimension == 1
                                                   ? nodes_
                                                   : std::vector<Index>{});
        } else if (type.dimension == 2) {
            visitor.face(nodes_);
        } else {
            visitor.smallCell(type.dimension, nodes_);
        }
    }

    /// Returns the name of a physical group.
    std::string groupName(std::int64_t dimension, std::int64_t tag) const {
        const auto found = groupNames_.find({dimension, tag});
        if (found != groupNames_.end()) return found->second;
        return nameOfGroup(static_cast<int>(dimension), concat(tag));
    }

    /// The nodes of an entity, and their images on another one.
    struct Periodic {
        std::int64_t dimension, entity, master;
        std::vector<std::array<Index, 2>> images;
    };

    /// Returns true if the file has a section with this name.
    bool hasSection(const char* name) const {
        return bytes_.find(concat("$", name, "\n")) != std::string_view::npos ||
               bytes_.find(concat("$", name, "\r\n")) != std::string_view::npos;
    }

    /// Reads which groups are periodic: those of the entities of the largest dimension. Entities in
    /// no group, or in several, are left out.
    void readPeriodic(CellVisitor& visitor) {
        if (!hasSection("Periodic")) return;
        GmshReader reader(path_, bytes_);
        reader.seek("Periodic");
        std::vector<Periodic> all = reader.readImages(*this);
        std::int64_t dimension = 1;
        for (const Periodic& each : all) dimension = std::max(dimension, each.dimension);
        for (Periodic& each : all) {
            const auto& groups = groupsOfEntities_[{each.dimension, each.entity}];
            const auto& partners = groupsOfEntities_[{each.dimension, each.master}];
            if (each.dimension != dimension || groups.size() != 1 || partners.size() != 1) continue;
            visitor.periodic(groups[0], partners[0], each.images);
            if (groups[0] == partners[0]) continue;
            for (auto& [point, image] : each.images) std::swap(point, image);
            visitor.periodic(partners[0], groups[0], each.images);
        }
    }

    /// Reads the section of periodic entities, which is text in binary files of version 2.
    /// \param nodes the reader that knows the nodes
    std::vector<Periodic> readImages(const GmshReader& nodes) {
        if (!isVersion4_) isBinary_ = false;
        const std::size_t entityCount = count<std::uint64_t>("the number of periodic entities", 8);
        std::vector<Periodic> all;
        for (std::size_t i = 0; i < entityCount; ++i) {
            Periodic& each = all.emplace_back();
            each.dimension = integer<std::int32_t>("the dimension of an entity");
            each.entity = integer<std::int32_t>("the tag of an entity");
            each.master = integer<std::int32_t>("the tag of an entity");
            std::size_t nodeCount = 0;
            if (isVersion4_) {
                const std::size_t affine = count<std::uint64_t>("the size of a matrix", 2);
                for (std::size_t number = 0; number < affine; ++number) skipParameter();
                nodeCount = count<std::uint64_t>("the number of periodic nodes", 4);
            } else {
                std::string_view word = text_.token("the number of periodic nodes");
                if (word == "Affine") {
                    text_.restOfLine();
                    word = text_.token("the number of periodic nodes");
                }
                if (!parseNumber(word, nodeCount))
                    text_.fail(inQuotes(word) + " is not the number of periodic nodes");
                text_.checkRoom(nodeCount, 4, "the number of periodic nodes");
            }
            for (std::size_t node = 0; node < nodeCount; ++node) {
                const std::int64_t own = integer<std::uint64_t>("the tag of a node");
                const std::int64_t image = integer<std::uint64_t>("the tag of a node");
                each.images.push_back({nodes.indexOf(own), nodes.indexOf(image)});
            }
        }
        expectEnd("$EndPeriodic");
        return all;
    }

    /// Remembers the group of an entity of version 2.
    void addEntity(std::int64_t dimension, std::int64_t entity) {
        if (currentGroup_.second == 0 || DimensionAndTag(dimension, entity) == currentEntity_)
            return;
        currentEntity_ = {dimension, entity};
        auto& groups = groupsOfEntities_[currentEntity_];
        const std::string name = groupName(dimension, currentGroup_.second);
        if (std::ranges::count(groups, name) == 0) groups.push_back(name);
    }

    /// Begins the group of the next elements of version 2, unless it is the current one. An element
    /// has one group; 0 is none.
    void beginGroup(std::int64_t dimension, std::int64_t tag, CellVisitor& visitor) {
        const DimensionAndTag group(dimension, dimension < 1 ? 0 : tag);
        if (group == currentGroup_) return;
        currentGroup_ = group;
        if (group.second == 0) return visitor.beginGroups({});
        const std::string name = groupName(dimension, tag);
        visitor.beginGroups(std::span(&name, 1));
    }

    /// Reads the names of the physical groups; of version 4 the groups of the entities, too. Both
    /// sections come before the nodes.
    void readGroups() {
        for (const bool areEntities : {false, true}) {
            const char* name = areEntities ? "Entities" : "PhysicalNames";
            if (areEntities && !isVersion4_) continue;
            if (!hasSection(name)) continue;
            GmshReader reader(path_, bytes_);
            reader.seek(name);
            if (areEntities)
                reader.readEntities(*this);
            else
                reader.readNames(*this);
        }
    }

    /// Reads the names, which are text in binary files, too.
    void readNames(GmshReader& into) {
        const std::size_t nameCount = text_.count("the number of physical names", 8);
        for (std::size_t i = 0; i < nameCount; ++i) {
            const auto dimension = text_.number<std::int64_t>("the dimension of a physical group");
            const auto tag = text_.number<std::int64_t>("the tag of a physical group");
            const std::string_view rest = text_.restOfLine();
            const std::size_t begin = rest.find('"'), end = rest.rfind('"');
            if (begin == std::string_view::npos || end <= begin + 1) continue;
            into.groupNames_[{dimension, tag}] = rest.substr(begin + 1, end - begin - 1);
        }
    }

    void readEntities(GmshReader& into) {
        constexpr std::size_t kMaxGroups = 100;
        constexpr std::int64_t kMaxTag = std::numeric_limits<std::int32_t>::max();
        std::array<std::size_t, 4> counts{};
        for (std::size_t& number : counts)
            number = count<std::uint64_t>("the number of entities", isBinary_ ? 28 : 8);
        for (std::int64_t dimension = 0; dimension < 4; ++dimension)
            for (std::size_t i = 0; i < counts[dimension]; ++i) {
                const std::int64_t entity = integer<std::int32_t>("the tag of an entity");
                // A point, or the two corners of a box around the entity.
                for (int number = 0; number < (dimension == 0 ? 3 : 6); ++number) skipParameter();
                const std::size_t groups = count<std::uint64_t>("the number of physical groups", 4);
                // Each element of the entity is added to each of its groups.
                if (groups > kMaxGroups)
                    text_.fail(concat("an entity has ", groups, " physical groups; at most ",
                                      kMaxGroups, " can be read"));
                for (std::size_t group = 0; group < groups; ++group) {
                    const std::int64_t tag = integer<std::int32_t>("the tag of a physical group");
                    if (tag < -kMaxTag || tag > kMaxTag)
                        text_.fail(concat("the tag of a physical group is ", tag,
                                          "; expected up to ", kMaxTag));
                    if (dimension >= 1)
                        into.groupsOfEntities_[{dimension, entity}].push_back(
                            into.groupName(dimension, std::abs(tag)));
                }
                if (dimension == 0) continue;
                const std::size_t bounding = count<std::uint64_t>("the number of entities", 4);
                for (std::size_t other = 0; other < bounding; ++other)
                    integer<std::int32_t>("the tag of an entity");
            }
    }

    template <class Stored>
    void readElementNodes(const GmshElementType& type) {
        nodes_.clear();
        for (std::size_t i = 0; i < type.nodes; ++i)
            nodes_.push_back(indexOf(integer<Stored>("a node of an element")));
    }

    void readElements2(CellVisitor& visitor) {
        seek("Elements");
        const std::size_t elementCount = text_.count("the number of elements", 8);
        if (isBinary_) text_.restOfLine();
        for (std::size_t read = 0; read < elementCount;) {
            // In binary, elements of one type follow a common header.
            std::size_t inBlock = 1;
            if (!isBinary_) integer<std::int32_t>("the number of an element");
            const std::int64_t number = integer<std::int32_t>("the type of an element");
            const std::optional<GmshElementType> type = typeOf(number);
            if (!type) {
                visitUnknown(number, visitor);
                ++read;
                continue;
            }
            if (isBinary_) inBlock = count<std::int32_t>("the number of elements of a block", 8);
            const std::size_t tagCount =
                count<std::int32_t>("the number of tags of an element", isBinary_ ? 4 : 2);
            if (inBlock == 0 || inBlock > elementCount - read)
                text_.fail(concat("a block has ", inBlock, " elements, but ", elementCount - read,
                                  " are left"));
            for (std::size_t i = 0; i < inBlock; ++i) {
                if (isBinary_) integer<std::int32_t>("the number of an element");
                if (tagCount == 0 && visitor.wantsGroups()) beginGroup(type->dimension, 0, visitor);
                for (std::size_t tag = 0; tag < tagCount; ++tag) {
                    const std::int64_t value = integer<std::int32_t>("a tag of an element");
                    if (tag == 0 && visitor.wantsGroups())
                        beginGroup(type->dimension, value, visitor);
                    if (tag == 1 && visitor.wantsGroups()) addEntity(type->dimension, value);
                }
                readElementNodes<std::int32_t>(*type);
                visit(*type, visitor);
            }
            read += inBlock;
        }
        expectEnd("$EndElements");
    }

    void readElements4(CellVisitor& visitor) {
        seek("Elements");
        const std::size_t blockCount = count<std::uint64_t>("the number of blocks of elements", 8);
        const std::size_t elementCount = count<std::uint64_t>("the number of elements", 4);
        integer<std::uint64_t>("the smallest tag of an element");
        integer<std::uint64_t>("the largest tag of an element");
        std::size_t total = 0;
        for (std::size_t block = 0; block < blockCount; ++block) {
            const std::int64_t dimension = integer<std::int32_t>("the dimension of an entity");
            const std::int64_t entity = integer<std::int32_t>("the tag of an entity");
            if (visitor.wantsGroups()) visitor.beginGroups(groupsOfEntities_[{dimension, entity}]);
            const std::int64_t number = integer<std::int32_t>("the type of an element");
            const std::optional<GmshElementType> type = typeOf(number);
            const std::size_t inBlock =
                count<std::uint64_t>("the number of elements of a block", 4);
            for (std::size_t i = 0; i < inBlock; ++i) {
                integer<std::uint64_t>("the tag of an element");
                if (!type) {
                    visitUnknown(number, visitor);
                    continue;
                }
                readElementNodes<std::uint64_t>(*type);
                visit(*type, visitor);
            }
            total += inBlock;
        }
        if (total != elementCount)
            text_.fail(concat("the blocks have ", total, " elements, but $Elements claims ",
                              elementCount));
        expectEnd("$EndElements");
    }

    const std::filesystem::path& path_;
    std::string_view bytes_;
    TextReader text_;
    bool isVersion4_ = false;
    bool isBinary_ = false;
    std::optional<std::endian> order_;  ///< the byte order of a binary file
    NodeNumbers tags_;                  ///< of all nodes

    using DimensionAndTag = std::pair<std::int64_t, std::int64_t>;
    DimensionAndTag currentGroup_ = {};
    DimensionAndTag currentEntity_ = {};
    std::map<DimensionAndTag, std::string> groupNames_;  ///< of physical groups
    std::map<DimensionAndTag, std::vector<std::string>> groupsOfEntities_;
    std::vector<Index> nodes_;  ///< the nodes of the current element
};

constexpr MeshFormat kGmshMesh = {
    [](const std::filesystem::path& path, std::string_view bytes) {
        return GmshReader(path, bytes).readPoints();
    },
    [](const std::filesystem::path& path, std::string_view bytes, Index, CellVisitor& visitor) {
        GmshReader(path, bytes).readCells(visitor);
    }};

}  // namespace

const Format kGmshFormat = {.extensions = {".msh"},
                            .isMesh = true,
                            .readModel = readMeshModel<kGmshMesh>,
                            .readLattice = readMeshLattice<kGmshMesh>};

}  // namespace espalier::io

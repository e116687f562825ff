// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "mesh_format.h"

// Reads meshes of SU2 (.su2), of two or three dimensions, with one zone or several.
//
// The points are the lines of NPOIN=, zone after zone. The elements of NELEM= of the types 10
// (tetrahedron), 12 (hexahedron), 13 (wedge) and 14 (pyramid) are cells; triangles (5) and
// quadrilaterals (9) of NELEM= and of the markers are faces. Elements of other types are counted.
//
// A mesh of two dimensions has no z, so new positions must have z = 0. Points of different zones
// are not welded.

namespace espalier::io {
namespace {

/// Reads a file line by line. A percent sign begins a comment.
class Su2Reader {
public:
    Su2Reader(const std::filesystem::path& path, std::string_view bytes)
        : path_(path), bytes_(bytes), text_(path, bytes) {}

    FileNumbers readPoints() {
        FileNumbers numbers;
        bool isFound = false;
        forEachSection([&](std::string_view keyword, std::string_view value) {
            if (keyword != "NPOIN") return false;
            isFound = true;
            const std::size_t pointCount = countOf(value, "NPOIN", 2 * dimension());
            numbers.points.reserveMore(pointCount);
            for (std::size_t i = 0; i < pointCount; ++i) {
                std::string_view line = nextLine("a point");
                Point3& position = numbers.points.values.emplace_back(Point3{0, 0, 0});
                CoordinateOffsets& offsets = numbers.points.offsets.emplace_back();
                for (std::size_t axis = 0; axis < dimension(); ++axis) {
                    const std::string_view word = takeWord(line);
                    position[axis] =
                        parseCoordinate(word, axis, Precision::Double, path_, text_.line());
                    offsets[axis] = word.data() - bytes_.data();
                }
            }
            return true;
        });
        if (!isFound) text_.fail("the file ends; expected NPOIN=");
        numbers.dimension = dimension();
        return numbers;
    }

    void readCells(Index pointCount, CellVisitor& visitor) {
        forEachSection([&](std::string_view keyword, std::string_view value) {
            if (keyword == "NPOIN") {
                const std::size_t inZone = countOf(value, "NPOIN", 2 * dimension());
                for (std::size_t i = 0; i < inZone; ++i) nextLine("a point");
                zoneEnd_ += static_cast<Index>(inZone);
                return true;
            }
            if (keyword == "MARKER_TAG") {
                marker_ = takeWord(value);
                return false;
            }
            if (keyword == "NELEM" || keyword == "MARKER_ELEMS") {
                if (visitor.wantsGroups()) {
                    if (keyword == "NELEM") marker_.clear();
                    visitor.beginGroups(std::span(&marker_, marker_.empty() ? 0 : 1));
                }
                const std::size_t elementCount = countOf(value, std::string(keyword).c_str(), 4);
                for (std::size_t i = 0; i < elementCount; ++i) readElement(pointCount, visitor);
                marker_.clear();
                return true;
            }
            return false;
        });
        checkZone();
    }

private:
    std::size_t dimension() const {
        if (dimension_ == 0) text_.fail("the points come before NDIME=");
        return dimension_;
    }

    /// Calls visit(keyword, value) for each line with a keyword, "KEYWORD= value". It returns
    /// true if it has read the rows of the section. A further row is then an error.
    template <class Visit>
    void forEachSection(Visit visit) {
        std::string_view readSection;
        while (!text_.atEnd()) {
            const std::string_view line = withoutComment(text_.restOfLine());
            const std::size_t equals = line.find('=');
            if (equals == std::string_view::npos) {
                std::string_view rest = line;
                double number = 0;
                if (!readSection.empty() && parseNumber(takeWord(rest), number))
                    text_.fail(concat("more rows follow than ", readSection, "= says"));
                continue;
            }
            std::string_view before = line.substr(0, equals), value = line.substr(equals + 1);
            const std::string_view keyword = takeWord(before);
            if (keyword == "NDIME") {
                const std::size_t number = countOf(value, "NDIME", 0);
                if (number != 2 && number != 3)
                    text_.fail(concat("NDIME is ", number, "; expected 2 or 3"));
                if (dimension_ != 0 && number != dimension_)
                    text_.fail(concat("NDIME is ", number, "; it was ", dimension_, " before"));
                dimension_ = number;
            } else if (keyword == "IZONE") {
                checkZone();
                zoneBegin_ = zoneEnd_;
            }
            readSection = visit(keyword, value) ? keyword : std::string_view();
        }
    }

    /// Ends a zone, whose elements may come before its number of points.
    void checkZone() {
        if (lastNode_ && *lastNode_ >= zoneEnd_)
            throw FileError(path_, lastNodeLine_,
                            concat("an element names point ", *lastNode_ - zoneBegin_,
                                   "; there are ", zoneEnd_ - zoneBegin_, " in its zone"));
        lastNode_.reset();
    }

    static std::string_view withoutComment(std::string_view line) {
        return line.substr(0, line.find('%'));
    }

    /// Returns the next line that is not empty without its comment.
    std::string_view nextLine(const char* what) {
        while (!text_.atEnd()) {
            std::string_view line = withoutComment(text_.restOfLine());
            std::string_view rest = line;
            if (!takeWord(rest).empty()) return line;
        }
        text_.fail(concat("the file ends; expected ", what));
    }

    /// Returns the number after a keyword, as the number of lines of at least `minBytes` bytes.
    std::size_t countOf(std::string_view value, const char* keyword, std::size_t minBytes) const {
        const std::string_view word = takeWord(value);
        std::uint64_t number = 0;
        if (!parseNumber(word, number))
            text_.fail(concat(inQuotes(word), " after ", keyword, "= is not a number"));
        if (minBytes > 0) text_.checkRoom(number, minBytes, keyword);
        return number;
    }

    void readElement(Index pointCount, CellVisitor& visitor) {
        std::string_view line = nextLine("an element");
        std::string_view word = takeWord(line);
        if (word.starts_with("SEND_RECV") || word.starts_with("SEND_TO")) {
            // An older mesh of one process: the marker of the points that it shares with another.
            line = nextLine("an element");
            word = takeWord(line);
        }
        std::int64_t type = 0;
        if (!parseNumber(word, type)) text_.fail(inQuotes(word) + " is not the type of an element");
        const std::size_t nodeCount = nodeCountOf(type);
        if (nodeCount == 0)
            return visitor.unknownElement(text_.line(),
                                          concat("an element has the type ", type,
                                                 "; expected 1, 3, 5, 9, 10, 12, 13 or 14"));
        nodes_.clear();
        for (std::size_t i = 0; i < nodeCount; ++i) {
            word = takeWord(line);
            std::int64_t node = 0;
            if (!parseNumber(word, node))
                text_.fail(word.empty() ? concat("the line ends; an element of the type ", type,
                                                 " has ", nodeCount, " points")
                                        : inQuotes(word) + " is not the number of a point");
            if (node < 0 || node >= pointCount - zoneBegin_)
                text_.fail(concat("an element names point ", node, "; there are ",
                                  pointCount - zoneBegin_));
            nodes_.push_back(zoneBegin_ + static_cast<Index>(node));
            if (!lastNode_ || nodes_.back() > *lastNode_) {
                lastNode_ = nodes_.back();
                lastNodeLine_ = text_.line();
            }
        }
        switch (type) {
            case 1:
                return visitor.smallCell(0, nodes_);
            case 3:
                return visitor.smallCell(1, nodes_);
            case 5:
            case 9:
                return visitor.face(nodes_);
            case 10:
                return visitor.cell(far::StandardCell::Tetrahedron, nodes_);
            case 12:
                return visitor.cell(far::StandardCell::Hexahedron, nodes_);
            case 13:
                return visitor.cell(far::StandardCell::Wedge, nodes_);
            default:
                return visitor.cell(far::StandardCell::Pyramid, nodes_);
        }
    }

    /// Returns the number of points of an element; 0 for an unknown type.
    static std::size_t nodeCountOf(std::int64_t type) {
        switch (type) {
            case 1:
                return 1;
            case 3:
                return 2;
            case 5:
                return 3;
            case 9:
            case 10:
                return 4;
            case 12:
                return 8;
            case 13:
                return 6;
            case 14:
                return 5;
            default:
                return 0;
        }
    }

    const std::filesystem::path& path_;
    std::string_view bytes_;
    TextReader text_;
    std::size_t dimension_ = 0;
    Index zoneBegin_ = 0,
          zoneEnd_ = 0;              ///< the points of the current zone, as far as they are read
    std::optional<Index> lastNode_;  ///< the largest that an element of the zone names
    std::size_t lastNodeLine_ = 0;
    std::vector<Index> nodes_;  ///< the nodes of the current element
    std::string marker_;        ///< the name of the current marker; empty for the volume
};

constexpr MeshFormat kSu2Mesh = {
    [](const std::filesystem::path& path, std::string_view bytes) {
        return Su2Reader(path, bytes).readPoints();
    },
    [](const std::filesystem::path& path, std::string_view bytes, Index pointCount,
       CellVisitor& visitor) { Su2Reader(path, bytes).readCells(pointCount, visitor); }};

}  // namespace

const Format kSu2Format = {.extensions = {".su2"},
                           .isMesh = true,
                           .readModel = readMeshModel<kSu2Mesh>,
                           .readLattice = readMeshLattice<kSu2Mesh>};

}  // namespace espalier::io

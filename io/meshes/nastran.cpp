// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/far/second_order_cells.h>
#include <espalier/io/files/file.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <ostream>
#include <utility>

#include "../files/text_output.h"
#include "mesh_format.h"
#include "nastran_card.h"
#include "nastran_names.h"
#include "node_numbers.h"

// Reads the bulk data of Nastran (.bdf, .nas) and of OptiStruct (.fem): free fields, and fields of
// 8 and of 16 characters.
//
// The points are the entries GRID, in the order of the file. CTETRA, CPYRAM, CPENTA and CHEXA are
// cells, CTRIA3, CTRIA6, CQUAD4, CQUAD8 and their relatives are faces, of first or second order. An
// element that lacks some of its points between corners is counted, and so are elements of other
// types. Lines, points of mass and rigid elements need no check. The groups are the elements of one
// property, with the name that a comment gives (nastran_names.h).
//
// A new coordinate gets the digits that fit into its field: in 8 characters 6, or 7 if it is
// positive; in 16 characters 14 or 15. The file is not written in larger fields, since programs may
// rely on its lines. Model::checkTarget() tells the largest rounding. All other characters stay. If
// the file has no field for the coordinate, because a line ends before it, the line grows.
//
// Points in another coordinate system than the basic one are refused, with their number. A note
// names the files of INCLUDE, which are not read.

namespace espalier::io {
namespace {

/// A type of elements.
struct NastranElement {
    std::string_view name;
    int dimension;
    std::size_t corners = 0;
    std::size_t nodes = 0;  ///< of second order; as `corners` if there is none. 0 if not known
};

constexpr NastranElement kNastranElements[] = {
    {"CTETRA", 3, 4, 10}, {"CPYRAM", 3, 5, 13}, {"CPYRA", 3, 5, 13},  {"CPENTA", 3, 6, 15},
    {"CHEXA", 3, 8, 20},  {"CTRIA3", 2, 3, 3},  {"CTRIAR", 2, 3, 3},  {"CTRIA6", 2, 3, 6},
    {"CQUAD4", 2, 4, 4},  {"CQUADR", 2, 4, 4},  {"CQUAD8", 2, 4, 8},  {"CSHEAR", 2, 4, 4},
    {"CPLSTN3", 2, 3, 3}, {"CPLSTN4", 2, 4, 4}, {"CPLSTN6", 2, 3, 6}, {"CPLSTN8", 2, 4, 8},
    {"CPLSTS3", 2, 3, 3}, {"CPLSTS4", 2, 4, 4}, {"CPLSTS6", 2, 3, 6}, {"CPLSTS8", 2, 4, 8},
    {"CBAR", 1, 2, 2},    {"CBEAM", 1, 2, 2},   {"CBEND", 1, 2, 2},   {"CROD", 1, 2, 2},
    {"CONROD", 1},        {"CTUBE", 1, 2, 2},   {"PLOTEL", 1},        {"CBUSH", 1},
    {"CGAP", 1},          {"CONM1", 0},         {"CONM2", 0},         {"CQUAD", 2},
    {"CQUADX", 2},        {"CQUADX4", 2},       {"CQUADX8", 2},       {"CTRIAX", 2},
    {"CTRIAX6", 2},       {"CTRAX3", 2},        {"CTRAX6", 2},        {"CIHEX1", 3},
    {"CIHEX2", 3},        {"CIHEX3", 3},        {"CHEXA1", 3},        {"CHEXA2", 3},
    {"CWEDGE", 3},        {"CTWEDG", 3},        {"CIFHEX", 3},        {"CIFPENT", 3},
    {"CHEXCZ", 3},        {"CPENTCZ", 3},       {"CTRIA1", 2},        {"CTRIA2", 2},
    {"CQUAD1", 2},        {"CQUAD2", 2}};

/// Nastran has the points between corners of a solid in another order than VTK where it has
/// quadrilaterals at its sides: first the edges of one end, then those between the ends, then those
/// of the other end.
constexpr std::array<std::size_t, 20> kNastranHexahedron = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,
                                                            10, 11, 16, 17, 18, 19, 12, 13, 14, 15};
constexpr std::array<std::size_t, 15> kNastranWedge = {0, 1,  2,  3,  4, 5,  6, 7,
                                                       8, 12, 13, 14, 9, 10, 11};

constexpr std::size_t kNoLine = std::numeric_limits<std::size_t>::max();

/// Where a file has a point. It is kept in place of the offsets of the coordinates, since a file
/// may have no characters for a coordinate: {firstLine, lineOfZ, widths}.
struct PointPlace {
    std::size_t firstLine;              ///< offset of the line with x and y
    std::size_t lineOfZ;                ///< offset of the line with z; kNoLine if the file has none
    std::array<std::size_t, 3> widths;  ///< the widths of the fields; 0 for any

    explicit PointPlace(const CoordinateOffsets& offsets)
        : firstLine(offsets[0]),
          lineOfZ(offsets[1]),
          widths{offsets[2] / 32, offsets[2] / 32, offsets[2] % 32} {}

    static CoordinateOffsets offsets(const NastranReader& reader, std::string_view bytes) {
        const auto& lines = reader.lines();
        const NastranLine& first = lines.front();
        // The fields of the second line of 16 characters begin with z.
        const bool isInSecond = lines.size() > 1 && first.isLarge && lines[1].isLarge;
        const NastranLine& last = isInSecond ? lines[1] : first;
        const auto offsetOf = [&](const NastranLine& line) {
            return static_cast<std::size_t>(line.text.data() - bytes.data());
        };
        return {offsetOf(first), first.isLarge && !isInSecond ? kNoLine : offsetOf(last),
                first.width() * 32 + last.width()};
    }
};

/// The fields of an entry GRID.
enum GridField : std::size_t { kNumber = 0, kSystem = 1, kX = 2 };

FileNumbers readGrids(const std::filesystem::path& path, std::string_view bytes) {
    FileNumbers numbers;
    std::vector<std::string> included;
    std::size_t otherSystems = 0, firstLine = 0;
    std::int64_t firstSystem = 0;
    NastranReader reader(path, bytes);
    while (reader.next()) {
        if (reader.name() == "INCLUDE") {
            std::string_view file = trimmed(reader.lines().front().text.substr(7));
            if (file.size() > 1 && (file.front() == '\'' || file.front() == '"'))
                file = file.substr(1, file.find(file.front(), 1) - 1);
            included.emplace_back(file);
        }
        const bool isGrid = reader.name() == "GRID";
        if (!isGrid && reader.name() != "GRDSET") continue;
        if (const auto system = reader.integer(kSystem, "a coordinate system").value_or(0);
            system != 0) {
            if (!isGrid)
                reader.fail(concat("GRDSET puts points in the coordinate system ", system,
                                   "; write the mesh in the basic system (0) first"));
            if (otherSystems++ == 0) {
                firstLine = reader.line();
                firstSystem = system;
            }
        }
        if (!isGrid) continue;
        Point3& position = numbers.points.values.emplace_back();
        for (std::size_t axis = 0; axis < 3; ++axis)
            position[axis] = reader.coordinate(kX + axis, axis);
        numbers.points.offsets.push_back(PointPlace::offsets(reader, bytes));
    }
    if (numbers.points.values.empty()) {
        if (included.empty()) throw FileError(path, "has no entry GRID");
        throw FileError(path, "has no entry GRID of its own; INCLUDE names " +
                                  listedFiles(included) + ": name the file that has the points");
    }
    if (otherSystems > 0)
        throw FileError(
            path, firstLine,
            concat("a GRID is in the coordinate system ", firstSystem, ", and ", otherSystems,
                   " of ", numbers.points.values.size(),
                   " are not in the basic one; write the mesh in the basic system (0) first"));
    if (!included.empty())
        numbers.notes.push_back("did not read the files that INCLUDE names: " +
                                listedFiles(included));
    return numbers;
}

/// Reads the elements.
class NastranElements {
public:
    NastranElements(const std::filesystem::path& path, std::string_view bytes)
        : bytes_(bytes), reader_(path, bytes) {
        NastranReader grids(path, bytes);
        Index next = 0;
        while (grids.next()) {
            if (grids.name() != "GRID") continue;
            const auto number = grids.integer(kNumber, "the number of a GRID");
            if (!number) grids.fail("a GRID has no number");
            numbers_.add(*number, next++);
        }
        if (const auto twice = numbers_.sort())
            throw FileError(path, concat("two entries GRID have the number ", *twice));
    }

    void readAll(CellVisitor& visitor) {
        if (visitor.wantsGroups()) names_ = nastranPropertyNames(bytes_);
        while (reader_.next()) {
            const auto type =
                std::ranges::find(kNastranElements, reader_.name(), &NastranElement::name);
            if (type == std::end(kNastranElements)) continue;
            if (visitor.wantsGroups() && type->nodes > 0) beginGroup(*type, visitor);
            if (type->nodes > 0)
                read(*type, visitor);
            else if (type->dimension < 2)
                visitor.smallCell(type->dimension, {});
            else
                visitor.unknownElement(
                    reader_.line(),
                    concat("an element has the type ", type->name, ", which is not known here"));
        }
    }

private:
    /// Begins the group of a property, unless it is the current one. 0 is none.
    void beginGroup(const NastranElement& type, CellVisitor& visitor) {
        const std::string_view word = reader_.field(1);
        std::int64_t property = 0;
        if (!parseNumber(word, property)) property = 0;
        const std::pair group(property == 0 ? 0 : type.dimension, property);
        if (group == currentGroup_) return;
        currentGroup_ = group;
        if (property == 0) return visitor.beginGroups({});
        const auto found = names_.find(property);
        const std::string name = found == names_.end()
                                     ? nameOfGroup(type.dimension, std::to_string(property))
                                     : found->second;
        visitor.beginGroups(std::span(&name, 1));
    }

    /// Reads a line, which is no cell. Its points may be in another file.
    void readLine(const NastranElement& type, CellVisitor& visitor) {
        nodes_.clear();
        for (std::size_t i = 0; i < type.nodes; ++i) {
            std::int64_t number = 0;
            if (!parseNumber(reader_.field(2 + i), number)) continue;
            if (const auto node = numbers_.find(number)) nodes_.push_back(*node);
        }
        visitor.smallCell(1, nodes_);
    }

    void read(const NastranElement& type, CellVisitor& visitor) {
        if (type.dimension == 1) return readLine(type, visitor);
        nodes_.clear();
        for (std::size_t i = 0; i < type.nodes; ++i) {
            const std::size_t field = 2 + i;  // after the numbers of the element and its property
            const bool isCorner = i < type.corners;
            const std::string_view word = reader_.field(field);
            // Words, such as CORDM, follow the points.
            const bool isWord = !word.empty() && (word.front() > '9' || word.front() < '+');
            if (!isCorner && isWord) break;
            const auto number = reader_.integer(field, "a point of an element");
            if (!number && isCorner)
                reader_.fail(
                    concat("a ", type.name, " has ", i, " points; expected ", type.corners));
            // An element may lack points between corners.
            if (!isCorner && number.value_or(0) == 0) continue;
            const auto node = numbers_.find(*number);
            if (!node)
                reader_.fail(
                    concat("a ", type.name, " names GRID ", *number, ", which does not exist"));
            nodes_.push_back(*node);
        }
        if (nodes_.size() == type.corners && type.dimension == 2)
            visitor.face(nodes_);
        else if (nodes_.size() == type.corners)
            visitor.cell(*far::kindOfCell(type.corners), nodes_);
        else if (nodes_.size() < type.nodes)
            visitor.curvedCell(type.dimension, {});
        else
            visitor.curvedCell(type.dimension, inOrderOfVtk());
    }

    std::span<const Index> inOrderOfVtk() {
        std::span<const std::size_t> order;
        if (nodes_.size() == kNastranHexahedron.size()) order = kNastranHexahedron;
        if (nodes_.size() == kNastranWedge.size()) order = kNastranWedge;
        if (order.empty()) return nodes_;
        ordered_.clear();
        for (const std::size_t node : order) ordered_.push_back(nodes_[node]);
        return ordered_;
    }

    std::string_view bytes_;
    NastranReader reader_;
    NodeNumbers numbers_;
    std::map<std::int64_t, std::string> names_;       ///< of properties
    std::pair<int, std::int64_t> currentGroup_ = {};  ///< the dimension and the property
    std::vector<Index> nodes_, ordered_;              ///< the points of the current element
};

void writeGrids(std::ostream& out, const FileView& file, std::span<const Point3> moved,
                std::span<const DeformationGradient>) {
    const FileVectors& points = file.numbers.points;
    TextPatch patch(out, file.bytes);
    for (std::size_t point = 0; point < moved.size(); ++point) {
        const Point3 &before = points.values[point], &now = moved[point];
        if (now == before) continue;
        const PointPlace place(points.offsets[point]);
        NastranLine line = nastranLineAt(file.bytes, place.firstLine);
        const std::string_view old = line.text;
        std::string text(old);
        const auto replace = [&](std::size_t field, std::size_t axis) {
            if (now[axis] == before[axis]) return;
            line.text = text;
            text = line.withField(field, nastranText(now[axis], place.widths[axis]));
        };
        replace(kX, 0);
        replace(kX + 1, 1);
        if (place.lineOfZ == place.firstLine) replace(kX + 2, 2);
        patch.replace(old, std::string_view(text));
        if (place.lineOfZ == place.firstLine || now[2] == before[2]) continue;
        if (place.lineOfZ != kNoLine) {
            line = nastranLineAt(file.bytes, place.lineOfZ);
            patch.replace(line.text, std::string_view(
                                         line.withField(0, nastranText(now[2], place.widths[2]))));
            continue;
        }
        // A new line with z, after the comment at the end of the first one.
        const std::size_t begin = place.firstLine + old.size();
        std::size_t end = std::min(file.bytes.find('\n', begin), file.bytes.size());
        const bool hasReturn = end > begin && file.bytes[end - 1] == '\r';
        if (hasReturn) --end;
        line.text = line.isFree ? "*" : "*       ";
        patch.insert(end, (hasReturn ? "\r\n" : "\n") +
                              line.withField(0, nastranText(now[2], place.widths[2])));
    }
    patch.finish();
}

std::vector<Point3> storedGrids(const FileView& file, std::vector<Point3> moved) {
    const FileVectors& points = file.numbers.points;
    for (std::size_t point = 0; point < moved.size(); ++point) {
        const PointPlace place(points.offsets[point]);
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (moved[point][axis] != points.values[point][axis])
                moved[point][axis] = roundedToField(moved[point][axis], place.widths[axis]);
    }
    return moved;
}

std::string lossesOfFields(const FileView& file) {
    const FileVectors& points = file.numbers.points;
    std::string text;
    for (const std::size_t width : {8, 16}) {
        std::size_t count = 0;
        double largest = 0;
        for (std::size_t point = 0; point < points.values.size(); ++point) {
            if (PointPlace(points.offsets[point]).widths[0] != width) continue;
            ++count;
            for (const double coordinate : points.values[point])
                if (std::isfinite(coordinate)) largest = std::max(largest, std::abs(coordinate));
        }
        if (count > 0)
            text += concat(text.empty() ? "" : "; ", count, count == 1 ? " point" : " points",
                           " in fields of ", width, " characters: a coordinate that moves keeps ",
                           width - 2, " digits, or ", width - 1,
                           " if it is positive, which rounds it by at most ",
                           formatNumber(largestRounding(largest, width)), " up to a size of ",
                           formatNumber(largest));
    }
    return text;
}

constexpr MeshFormat kNastranMesh = {
    .readPoints = readGrids,
    .readCells = [](const std::filesystem::path& path, std::string_view bytes, Index,
                    CellVisitor& visitor) { NastranElements(path, bytes).readAll(visitor); },
    .write = writeGrids,
    .stored = storedGrids,
    .losses = lossesOfFields};

}  // namespace

const Format kNastranFormat = {.extensions = {".bdf", ".nas", ".fem"},
                               .isMesh = true,
                               .readModel = readMeshModel<kNastranMesh>,
                               .readLattice = readMeshLattice<kNastranMesh>};

}  // namespace espalier::io

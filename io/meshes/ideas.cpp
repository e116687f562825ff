// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/cancellable_sort.h>
#include <espalier/base/error.h>
#include <espalier/far/second_order_cells.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <ostream>
#include <utility>

#include "../files/text_output.h"
#include "decimal_digits.h"
#include "ideas_elements.h"
#include "mesh_format.h"
#include "node_numbers.h"

// Reads meshes in the universal files of I-deas (.unv), as Salome, Gmsh and Cubit write them.
//
// A file consists of datasets: a line -1, the number of the dataset, its lines, and a line -1. The
// points are the nodes of the datasets 2411 and 781 (double precision) and 15 (single precision),
// in the order of the file. The elements are those of the datasets 2412 and 780; ideas_elements.h
// lists their types. The groups are those of the datasets 2429, 2430, 2432, 2435, 2452, 2467 and
// 2477: of elements, and of nodes. All other datasets are kept.
//
// Programs read the coordinates by their columns: three of 25 characters, in the dataset 15 three
// of 13. A new coordinate is written into its columns, with 17 digits or with 6 (7 if it is
// positive); in the dataset 15, Model::checkTarget() tells so.
//
// A note counts nodes in a coordinate system of their own (dataset 2420): their coordinates are
// taken as they are.

namespace espalier::io {
namespace {

/// The lines of a file, dataset by dataset.
class IdeasFile {
public:
    IdeasFile(const std::filesystem::path& path, std::string_view bytes)
        : bytes_(bytes), text_(path, bytes) {}

    /// Goes to the next dataset. The rest of the last one is skipped.
    /// \return false at the end of the file
    bool next() {
        if (isOpen_)
            while (nextLine()) {
            }
        while (!text_.atEnd()) {
            if (trimmed(text_.restOfLine()) != "-1") continue;
            std::string_view line = text_.restOfLine();
            const std::string_view word = takeWord(line);
            if (!parseNumber(word, number_)) number_ = 0;  // "58b" is binary, and is skipped
            isOpen_ = true;
            return true;
        }
        return false;
    }

    std::int64_t number() const { return number_; }

    /// Returns the next line of the dataset; nothing at its end.
    std::optional<std::string_view> nextLine() {
        if (!isOpen_) return std::nullopt;
        if (text_.remaining() == 0) {
            isOpen_ = false;
            return std::nullopt;
        }
        const std::string_view line = text_.restOfLine();
        if (trimmed(line) != "-1") return line;
        isOpen_ = false;
        return std::nullopt;
    }

    std::string_view requireLine(const char* what) {
        const auto line = nextLine();
        if (!line) fail(concat("the dataset ", number_, " ends; expected ", what));
        return *line;
    }

    std::int64_t integer(std::string_view& line, const char* what) const {
        const std::string_view word = takeWord(line);
        std::int64_t number = 0;
        if (!parseNumber(word, number))
            fail(word.empty() ? concat("the line ends; expected ", what)
                              : concat(inQuotes(word), " is not a number; expected ", what));
        return number;
    }

    std::size_t offsetOf(std::string_view word) const { return word.data() - bytes_.data(); }
    std::size_t line() const { return text_.line(); }
    [[noreturn]] void fail(const std::string& cause) const { text_.fail(cause); }

private:
    std::string_view bytes_;
    TextReader text_;
    bool isOpen_ = false;
    std::int64_t number_ = 0;
};

bool isOneOf(std::int64_t number, std::initializer_list<std::int64_t> numbers) {
    return std::ranges::count(numbers, number) > 0;
}

bool isNodes(std::int64_t dataset) {
    return isOneOf(dataset, {2411, 781, 15});
}

/// Visits the nodes of a dataset: visit(number, system, line with the coordinates).
template <class Visit>
void forEachNode(IdeasFile& file, Visit visit) {
    while (auto line = file.nextLine()) {
        if (trimmed(*line).empty()) continue;
        std::string_view rest = *line;
        const std::int64_t number = file.integer(rest, "the number of a node");
        const std::int64_t system = file.integer(rest, "the coordinate system of a node");
        if (file.number() == 15) {
            for (const char* what : {"the displacement system of a node", "the colour of a node"})
                file.integer(rest, what);
            visit(number, system, rest);
        } else {
            visit(number, system, file.requireLine("the coordinates of a node"));
        }
    }
}

/// Reads the numbers of the coordinate systems that are not the global one (dataset 2420).
void readSystems(const std::filesystem::path& path, IdeasFile& file,
                 std::vector<std::int64_t>& systems) {
    file.nextLine();  // the number and the name of the part
    file.nextLine();
    while (auto line = file.nextLine()) {
        if (trimmed(*line).empty()) continue;
        const std::int64_t number = file.integer(*line, "the number of a coordinate system");
        bool isGlobal = file.integer(*line, "the type of a coordinate system") == 0;
        file.nextLine();  // the name
        for (std::size_t row = 0; row < 4; ++row) {
            auto values = file.nextLine();
            for (std::size_t column = 0; values && column < 3; ++column) {
                const double entry =
                    parseFortranCoordinate(takeWord(*values), column, path, file.line());
                isGlobal = isGlobal && entry == (row == column ? 1 : 0);
            }
        }
        if (!isGlobal) systems.push_back(number);
    }
}

double readFiniteFortran(std::string_view word, std::size_t axis, const std::filesystem::path& path,
                         std::size_t line) {
    const double number = parseFortranCoordinate(word, axis, path, line);
    if (!std::isfinite(number)) refuseNotFinite(word, axis, path, line);
    return number;
}

FileNumbers readIdeasPoints(const std::filesystem::path& path, std::string_view bytes) {
    FileNumbers numbers;
    std::vector<std::int64_t> systems;
    std::map<std::int64_t, std::size_t> nodesOfSystems;
    IdeasFile file(path, bytes);
    bool hasDataset = false;
    while (file.next()) {
        hasDataset = true;
        if (file.number() == 2420) readSystems(path, file, systems);
        if (!isNodes(file.number())) continue;
        forEachNode(file, [&](std::int64_t, std::int64_t system, std::string_view line) {
            ++nodesOfSystems[system];
            Point3& position = numbers.points.values.emplace_back();
            CoordinateOffsets& offsets = numbers.points.offsets.emplace_back();
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const std::string_view word = takeWord(line);
                position[axis] = readFiniteFortran(word, axis, path, file.line());
                offsets[axis] = file.offsetOf(word);
            }
        });
    }
    if (!hasDataset)
        throw FileError(path, "has no dataset; expected a line -1 and the number of a dataset");
    if (numbers.points.values.empty())
        throw FileError(path, "has no nodes; expected a dataset 2411, 781 or 15");
    std::size_t others = 0;
    for (const std::int64_t system : systems)
        if (const auto found = nodesOfSystems.find(system); found != nodesOfSystems.end())
            others += std::exchange(found->second, 0);
    if (others > 0)
        numbers.notes.push_back(concat("took the coordinates of ", others,
                                       others == 1 ? " node" : " nodes",
                                       " as they are, though the dataset 2420 gives ",
                                       others == 1 ? "it" : "them", " a coordinate system"));
    return numbers;
}

/// Reads the elements and the groups.
class IdeasCells {
public:
    IdeasCells(const std::filesystem::path& path, std::string_view bytes)
        : path_(path), bytes_(bytes) {
        IdeasFile file(path, bytes);
        Index next = 0;
        while (file.next())
            if (isNodes(file.number()))
                forEachNode(file, [&](std::int64_t number, std::int64_t, std::string_view) {
                    nodes_.add(number, next++);
                });
        if (const auto twice = nodes_.sort())
            throw FileError(path, concat("two nodes have the number ", *twice));
    }

    void read(CellVisitor& visitor) {
        if (visitor.wantsGroups()) readGroups();
        IdeasFile file(path_, bytes_);
        std::vector<std::string> names;
        while (file.next()) {
            if (!isOneOf(file.number(), {2412, 780})) continue;
            while (auto line = file.nextLine()) {
                if (trimmed(*line).empty()) continue;
                const std::int64_t number = file.integer(*line, "the number of an element");
                if (visitor.wantsGroups() && setGroups(number, names)) visitor.beginGroups(names);
                readElement(file, *line, visitor);
            }
        }
        for (const Group& group : groups_) {
            visitor.beginGroups(std::span(&group.name, 1));
            std::vector<Index> points;
            for (const std::int64_t number : group.nodes)
                if (const auto node = nodes_.find(number)) points.push_back(*node);
            visitor.groupPoints(0, points);
        }
        if (visitor.wantsGroups()) visitor.beginGroups({});
    }

private:
    struct Group {
        std::string name;
        std::vector<std::int64_t> nodes = {};
    };

    void readGroups() {
        IdeasFile file(path_, bytes_);
        while (file.next()) {
            const bool isLong = isOneOf(file.number(), {2452, 2467, 2477});
            if (!isLong && !isOneOf(file.number(), {2429, 2430, 2432, 2435})) continue;
            while (auto line = file.nextLine()) {
                if (trimmed(*line).empty()) continue;
                const std::int64_t number = file.integer(*line, "the number of a group");
                std::int64_t count = 0;
                for (int i = 0; i < 7; ++i)
                    count = file.integer(*line, "the number of entities of a group");
                const std::string_view name = trimmed(file.nextLine().value_or(std::string_view()));
                groups_.push_back({name.empty() ? concat("group ", number) : std::string(name)});
                readEntities(file, count, isLong);
            }
        }
        sortCancellably(ofElements_.begin(), ofElements_.end());
        ofElements_.erase(std::unique(ofElements_.begin(), ofElements_.end()), ofElements_.end());
    }

    /// Reads the entities of the last group. Each has two numbers, or four in long datasets.
    void readEntities(IdeasFile& file, std::int64_t count, bool isLong) {
        constexpr std::int64_t kNode = 7, kElement = 8;
        while (count > 0) {
            auto line = file.nextLine();
            if (!line)
                file.fail(concat("the dataset ends, but a group has ", count, " more entities"));
            while (count > 0 && !trimmed(*line).empty()) {
                const std::int64_t type = file.integer(*line, "the type of an entity");
                const std::int64_t entity = file.integer(*line, "the number of an entity");
                if (isLong) {
                    takeWord(*line);
                    takeWord(*line);
                }
                if (type == kNode) groups_.back().nodes.push_back(entity);
                if (type == kElement) ofElements_.emplace_back(entity, groups_.size() - 1);
                --count;
            }
        }
    }

    /// Sets the names of the groups of an element. Returns false if they have not changed.
    bool setGroups(std::int64_t element, std::vector<std::string>& names) {
        current_.clear();
        for (auto at = std::lower_bound(ofElements_.begin(), ofElements_.end(),
                                        std::pair(element, std::size_t{0}));
             at != ofElements_.end() && at->first == element; ++at)
            current_.push_back(at->second);
        if (current_ == last_) return false;
        last_ = current_;
        names.clear();
        for (const std::size_t group : current_) names.push_back(groups_[group].name);
        return true;
    }

    void readElement(IdeasFile& file, std::string_view line, CellVisitor& visitor) {
        const std::size_t atLine = file.line();
        const std::int64_t descriptor = file.integer(line, "the descriptor of an element");
        // The numbers of the property, of the material and of the colour.
        for (int i = 0; i < (file.number() == 780 ? 5 : 3); ++i)
            file.integer(line, "a number of an element");
        const std::int64_t count = file.integer(line, "the number of nodes of an element");
        const auto type = ideasElement(descriptor);
        if (type && type->isBeam) file.requireLine("the orientation of a beam");
        if (type && type->nodes > 0 && !std::cmp_equal(count, type->nodes))
            file.fail(concat("an element of the descriptor ", descriptor, " has ", count,
                             " nodes; expected ", type->nodes));
        const bool areNeeded = type && (type->nodes > 0 || type->isBeam);
        points_.clear();
        std::string_view words;
        for (std::int64_t i = 0; i < count; ++i) {
            while (trimmed(words).empty()) words = file.requireLine("a node of an element");
            const std::int64_t number = file.integer(words, "a node of an element");
            if (!areNeeded) continue;
            const auto node = nodes_.find(number);
            if (!node)
                file.fail(concat("an element names node ", number, ", which does not exist"));
            points_.push_back(*node);
        }
        if (!type)
            visitor.unknownElement(atLine, concat("an element has the descriptor ", descriptor,
                                                  ", which is not known here"));
        else if (type->isBeam)
            visitor.smallCell(1, std::span(points_));
        else if (type->nodes == 0 && type->dimension > 1)
            visitor.curvedCell(type->dimension, {});
        else if (type->nodes == 0)
            visitor.smallCell(type->dimension, {});
        else if (type->isCurved)
            visitor.curvedCell(type->dimension, ideasNodesInVtkOrder(type->dimension, points_));
        else if (type->dimension == 2)
            visitor.face(points_);
        else
            visitor.cell(*far::kindOfCell(points_.size()), points_);
    }

    const std::filesystem::path& path_;
    std::string_view bytes_;
    NodeNumbers nodes_;
    std::vector<Group> groups_;
    std::vector<std::pair<std::int64_t, std::size_t>> ofElements_;  ///< elements and their groups
    std::vector<std::size_t> current_, last_;  ///< the groups of this and of the last element
    std::vector<Index> points_;                ///< of the current element
};

/// The columns of the coordinates of a node.
struct IdeasColumns {
    std::size_t begin = 0;  ///< of x, in the line
    std::size_t width = 0;  ///< 25 or 13; 0 if the numbers are not in such columns
};

/// Returns the line of a coordinate, without its end.
std::string_view lineAt(std::string_view bytes, std::size_t offset) {
    const std::size_t before = offset == 0 ? std::string_view::npos : bytes.rfind('\n', offset - 1);
    const std::size_t begin = before == std::string_view::npos ? 0 : before + 1;
    std::string_view line = bytes.substr(begin, bytes.find('\n', offset) - begin);
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
}

std::string_view wordAt(std::string_view bytes, std::size_t offset) {
    std::string_view rest =
        bytes.substr(offset, std::min(bytes.find('\n', offset), bytes.size()) - offset);
    return takeWord(rest);
}

IdeasColumns columnsOf(std::string_view bytes, const CoordinateOffsets& offsets) {
    constexpr IdeasColumns kIdeasColumns[] = {{0, 25}, {40, 13}};
    const std::string_view line = lineAt(bytes, offsets[0]);
    const std::size_t begin = line.data() - bytes.data();
    for (const IdeasColumns& columns : kIdeasColumns) {
        bool fits = true;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::size_t first = columns.begin + axis * columns.width;
            const std::size_t at = offsets[axis] - begin;
            // The columns have this word alone, with space before it and after them.
            const std::size_t end = first + columns.width;
            fits = fits && (at > first || (axis == 0 && first == 0)) && at < end &&
                   trimmed(line.substr(first, columns.width)) == wordAt(bytes, offsets[axis]) &&
                   (end >= line.size() || axis < 2 || trimmed(line.substr(end, 1)).empty());
        }
        if (fits) return columns;
    }
    return {};
}

/// Returns the text of a number with as many digits as fit into columns of this width, with a space
/// before it; all digits if the width is 0. It has a decimal point, as Fortran needs it.
std::string fortranText(double number, std::size_t width, char exponentLetter) {
    const DecimalDigits all = number == 0 ? DecimalDigits{"0", 1} : digitsOf(std::abs(number));
    for (std::size_t count = all.digits.size();; --count) {
        const auto [digits, power] = rounded(all, count);
        const std::string exponent = std::to_string(std::abs(power - 1));
        std::string text = std::signbit(number) ? "-" : "";
        text.append(digits, 0, 1).append(1, '.').append(digits.size() > 1 ? digits.substr(1) : "0");
        text.append(1, exponentLetter).append(1, power < 1 ? '-' : '+');
        text.append(exponent.size() < 2 ? 1 : 0, '0').append(exponent);
        if (width == 0 || text.size() < width || count == 1) return text;
    }
}

double roundedToColumns(double number, const IdeasColumns& columns) {
    double result = number;
    return parseNumber(fortranText(number, columns.width, 'e'), result) ? result : number;
}

std::vector<Point3> storedIdeasPoints(const FileView& file, std::vector<Point3> moved) {
    const FileVectors& points = file.numbers.points;
    for (std::size_t point = 0; point < moved.size(); ++point) {
        if (moved[point] == points.values[point]) continue;
        const IdeasColumns columns = columnsOf(file.bytes, points.offsets[point]);
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (moved[point][axis] != points.values[point][axis])
                moved[point][axis] = roundedToColumns(moved[point][axis], columns);
    }
    return moved;
}

void writeIdeasPoints(std::ostream& out, const FileView& file, std::span<const Point3> moved,
                      std::span<const DeformationGradient>) {
    const FileVectors& points = file.numbers.points;
    TextPatch patch(out, file.bytes);
    for (std::size_t point = 0; point < moved.size(); ++point) {
        if (moved[point] == points.values[point]) continue;
        const CoordinateOffsets& offsets = points.offsets[point];
        const IdeasColumns columns = columnsOf(file.bytes, offsets);
        const std::string_view line = lineAt(file.bytes, offsets[0]);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (moved[point][axis] == points.values[point][axis]) continue;
            std::string_view old = wordAt(file.bytes, offsets[axis]);
            const bool hasD = old.find_first_of("dD") != std::string_view::npos;
            std::string text = fortranText(moved[point][axis], columns.width, hasD ? 'D' : 'E');
            if (columns.width > 0) {
                // The number ends where the old one did, or at the end of its columns.
                const std::size_t begin = columns.begin + axis * columns.width;
                std::size_t end = offsets[axis] - (line.data() - file.bytes.data()) + old.size();
                if (end - begin <= text.size()) end = begin + columns.width;
                text.insert(0, end - begin - text.size(), ' ');
                old = line.substr(begin, end - begin);
            }
            patch.replace(old, std::string_view(text));
        }
    }
    patch.finish();
}

std::string lossesOfColumns(const FileView& file) {
    std::size_t count = 0;
    double largest = 0;
    const FileVectors& points = file.numbers.points;
    for (std::size_t point = 0; point < points.values.size(); ++point) {
        if (columnsOf(file.bytes, points.offsets[point]).width != 13) continue;
        ++count;
        for (const double coordinate : points.values[point])
            if (std::isfinite(coordinate)) largest = std::max(largest, std::abs(coordinate));
    }
    if (count == 0) return {};
    // "-1.23456E+00" has 6 digits.
    int power = 0;
    for (double rest = largest; rest >= 10; rest /= 10) ++power;
    return concat(
        count, count == 1 ? " point" : " points",
        " in fields of 13 characters (dataset 15): a coordinate that moves keeps 6 digits, "
        "or 7 if it is positive, which rounds it by at most ",
        formatNumber(0.5 * std::pow(10.0, power - 5)), " up to a size of ", formatNumber(largest));
}

constexpr MeshFormat kIdeasMesh = {
    .readPoints = readIdeasPoints,
    .readCells = [](const std::filesystem::path& path, std::string_view bytes, Index,
                    CellVisitor& visitor) { IdeasCells(path, bytes).read(visitor); },
    .write = writeIdeasPoints,
    .stored = storedIdeasPoints,
    .losses = lossesOfColumns};

}  // namespace

const Format kIdeasFormat = {.extensions = {".unv"},
                             .isMesh = true,
                             .readModel = readMeshModel<kIdeasMesh>,
                             .readLattice = readMeshLattice<kIdeasMesh>};

}  // namespace espalier::io

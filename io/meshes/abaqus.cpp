// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/far/second_order_cells.h>
#include <espalier/io/files/file.h>

#include <algorithm>
#include <optional>
#include <ostream>
#include <utility>

#include "../files/text_output.h"
#include "abaqus_elements.h"
#include "abaqus_file.h"
#include "abaqus_sets.h"
#include "mesh_format.h"

// Reads meshes in the input files of Abaqus and CalculiX (.inp).
//
// The points are the lines of *NODE, in the order of the file. Each part, instance and assembly
// numbers its nodes on its own, and its elements name these nodes. Elements of the families in
// abaqus_elements.cpp are cells and faces; others are counted.
//
// The groups are the sets and surfaces of abaqus_sets.h. The nodes of a set of elements (*NSET,
// ELSET=) are no group, since the set of the elements is one. Members that the file does not have
// are left out.
//
// If no node has a z, then the mesh is of two dimensions, and new positions must have z = 0.
// Coordinates that single nodes lack are 0, and are added when they change. Further entries in the
// line of an element are ignored, as CalculiX does.
//
// Refused by name: nodes in another coordinate system (*SYSTEM, or SYSTEM=C of *NODE), nodes that
// Abaqus makes itself (*NGEN, *NFILL, *NCOPY, *NMAP), and nodes or elements in other files
// (INPUT=). Notes name other files (*INCLUDE), elements that Abaqus makes itself (*ELGEN, *ELCOPY),
// and instances that are moved.

namespace espalier::io {
namespace {

// An entry that is empty is 0, and so is an entry beyond the end of its line. Their offsets are the
// places where a number has to be inserted, with one of these bits.
constexpr std::size_t kEmptyEntry = std::size_t{1} << (8 * sizeof(std::size_t) - 1);
constexpr std::size_t kBeyondLine = kEmptyEntry >> 1;

/// Returns true if the file has a number for a coordinate.
bool hasNumberAt(std::size_t offset) {
    return offset < kBeyondLine;
}

/// Refuses nodes whose positions are not in the lines of *NODE.
void refuseOtherNodes(AbaqusFile& file) {
    const AbaqusKeyword& keyword = file.keyword();
    if (keyword.name == "node" || keyword.name == "element")
        if (const auto input = keyword.parameter("input"))
            file.fail(concat("the data of *", keyword.name == "node" ? "NODE" : "ELEMENT",
                             " are in the file ", inQuotes(*input),
                             "; put its lines here in place of INPUT="));
    constexpr std::pair<std::string_view, std::string_view> kMakers[] = {
        {"ngen", "NGEN"}, {"nfill", "NFILL"}, {"ncopy", "NCOPY"}, {"nmap", "NMAP"}};
    for (const auto& [name, shown] : kMakers)
        if (keyword.name == name)
            file.fail(concat("*", shown,
                             " makes nodes that the file does not list; write the mesh with all of "
                             "its nodes first"));
    const auto system = keyword.name == "node" ? keyword.parameter("system") : std::nullopt;
    if (system && lowerCase(*system) != "r")
        file.fail("the nodes are in cylindrical or spherical coordinates (SYSTEM=" +
                  std::string(*system) + "); write them in rectangular ones first");
    if (keyword.name == "system" && file.nextData())
        file.fail(
            "*SYSTEM gives nodes in a coordinate system of their own; write them in the global one "
            "first");
}

class AbaqusPoints {
public:
    AbaqusPoints(const std::filesystem::path& path, std::string_view bytes)
        : path_(path), file_(path, bytes) {}

    FileNumbers read() {
        while (file_.next()) {
            const std::string& keyword = file_.keyword().name;
            if (keyword == "include") {
                otherFiles_.emplace_back(file_.keyword().nameIn("input"));
            } else if (keyword == "elgen" || keyword == "elcopy") {
                made_ = keyword == "elgen" ? "*ELGEN" : "*ELCOPY";
            } else if (keyword == "instance") {
                // Its data are a translation and a rotation.
                movedInstances_ += file_.nextData() ? 1 : 0;
            } else {
                refuseOtherNodes(file_);
                if (keyword != "node") continue;
                while (const auto line = file_.nextData()) readNode(*line);
            }
        }
        if (numbers_.points.values.empty()) {
            if (otherFiles_.empty()) throw FileError(path_, "has no nodes; expected *NODE");
            throw FileError(path_, "has no nodes of its own; *INCLUDE names " +
                                       listedFiles(otherFiles_) +
                                       ": name the file that has the nodes");
        }
        if (flatNodes_ == numbers_.points.values.size()) numbers_.dimension = 2;
        addNotes();
        return std::move(numbers_);
    }

private:
    void addNotes() {
        if (!otherFiles_.empty())
            numbers_.notes.push_back("did not read the files that *INCLUDE names: " +
                                     listedFiles(otherFiles_));
        if (!made_.empty())
            numbers_.notes.push_back("did not read the elements that Abaqus makes by " + made_);
        if (movedInstances_ > 0)
            numbers_.notes.push_back(
                concat("took the nodes as their parts have them: ", movedInstances_,
                       movedInstances_ == 1 ? " instance is" : " instances are",
                       " moved by a translation or a rotation"));
    }

    void readNode(std::string_view line) {
        const std::string_view whole = trimmed(line);
        file_.integer(takeAbaqusEntry(line), "the number of a node");
        Point3& position = numbers_.points.values.emplace_back(Point3{0, 0, 0});
        CoordinateOffsets& offsets = numbers_.points.offsets.emplace_back();
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto entry = takeAbaqusEntry(line);
            if (!entry) {
                offsets[axis] = (file_.offsetOf(whole) + whole.size()) | kBeyondLine;
            } else if (entry->empty()) {
                offsets[axis] = file_.offsetOf(*entry) | kEmptyEntry;
            } else {
                offsets[axis] = file_.offsetOf(*entry);
                position[axis] = parseFortranCoordinate(*entry, axis, path_, file_.line());
            }
        }
        flatNodes_ +=
            hasNumberAt(offsets[0]) && hasNumberAt(offsets[1]) && !hasNumberAt(offsets[2]) ? 1 : 0;
    }

    const std::filesystem::path& path_;
    AbaqusFile file_;
    FileNumbers numbers_;
    std::size_t flatNodes_ = 0, movedInstances_ = 0;
    std::vector<std::string> otherFiles_;
    std::string made_;
};

/// Reads the elements. Each has an index, in the order of the file.
class AbaqusCells {
public:
    AbaqusCells(const std::filesystem::path& path, std::string_view bytes)
        : path_(path), bytes_(bytes) {
        readNumbers();
    }

    void read(CellVisitor& visitor) const {
        std::optional<AbaqusSets> sets;
        if (visitor.wantsGroups()) sets.emplace(path_, bytes_, numbers_);
        AbaqusFile file(path_, bytes_);
        Index next = 0;
        std::vector<std::string> groups;
        std::vector<Index> nodes;
        while (file.next()) {
            if (file.keyword().name != "element") continue;
            const std::string_view name = typeOf(file);
            const AbaqusElement type = abaqusElement(name);
            const NodeNumbers& numbers = numbers_.nodes[numbers_.partOf[file.scopes().current()]];
            ElementLines lines(file, name, type);
            while (lines.next()) {
                const Index element = next++;
                if (sets && sets->setNames(element, groups)) visitor.beginGroups(groups);
                nodes.clear();
                for (const std::string_view word : lines.words()) {
                    const std::int64_t number = file.integer(word, "a node of an element");
                    const auto node = numbers.find(number);
                    if (!node)
                        file.fail(
                            concat("an element names node ", number, ", which does not exist"));
                    nodes.push_back(*node);
                }
                visit(file, name, type, nodes, visitor);
                if (sets && sets->needsElements() && type.nodes > 0)
                    sets->addElement(element, type, nodes);
            }
        }
        if (sets) sets->visit(visitor);
    }

private:
    /// The elements of a keyword. Long elements go on in the next line.
    class ElementLines {
    public:
        ElementLines(AbaqusFile& file, std::string_view name, const AbaqusElement& type)
            : file_(file), name_(name), type_(type) {}

        bool next() {
            auto line = file_.nextData();
            if (!line) return false;
            number_ = file_.integer(takeAbaqusEntry(*line), "the number of an element");
            words_.clear();
            while (words_.size() < type_.nodes) {
                if (const auto entry = takeAbaqusEntry(*line)) {
                    words_.push_back(*entry);
                    continue;
                }
                line = file_.nextData();
                if (!line)
                    file_.fail(concat("the element ends; one of the type ", inQuotes(name_),
                                      " has ", type_.nodes, " nodes"));
            }
            // The number of nodes is not known. A line that ends with a comma has another one.
            while (type_.nodes == 0 && line && trimmed(*line).ends_with(','))
                line = file_.nextData();
            return true;
        }

        std::int64_t number() const { return number_; }
        const std::vector<std::string_view>& words() const { return words_; }

    private:
        AbaqusFile& file_;
        std::string_view name_;
        const AbaqusElement& type_;
        std::int64_t number_ = 0;
        std::vector<std::string_view> words_;  ///< the nodes
    };

    static std::string_view typeOf(const AbaqusFile& file) {
        const auto type = file.keyword().parameter("type");
        if (!type) file.fail("*ELEMENT has no TYPE=");
        return *type;
    }

    /// Reads the numbers of the nodes and of the elements.
    void readNumbers() {
        AbaqusFile file(path_, bytes_);
        std::map<std::string, std::size_t> parts;
        std::vector<std::pair<std::size_t, std::string>> partNames;  ///< of the instances
        Index node = 0, element = 0;
        while (file.next()) {
            const AbaqusKeyword& keyword = file.keyword();
            const std::size_t scope = file.scopes().current();
            numbers_.nodes.resize(file.scopes().count());
            numbers_.elements.resize(file.scopes().count());
            if (keyword.name == "part") {
                parts[lowerCase(keyword.nameIn("name"))] = scope;
            } else if (keyword.name == "instance") {
                numbers_.instances[lowerCase(keyword.nameIn("name"))] = scope;
                partNames.emplace_back(scope, lowerCase(keyword.nameIn("part")));
            } else if (keyword.name == "node") {
                numbers_.nodeBlocks.push_back(node);
                while (auto line = file.nextData())
                    numbers_.nodes[scope].add(
                        file.integer(takeAbaqusEntry(*line), "the number of a node"), node++);
            } else if (keyword.name == "element") {
                numbers_.elementBlocks.push_back(element);
                const std::string_view name = typeOf(file);
                const AbaqusElement type = abaqusElement(name);
                ElementLines lines(file, name, type);
                while (lines.next()) numbers_.elements[scope].add(lines.number(), element++);
            }
        }
        numbers_.nodeBlocks.push_back(node);
        numbers_.elementBlocks.push_back(element);
        for (NodeNumbers& numbers : numbers_.nodes)
            if (const auto twice = numbers.sort())
                throw FileError(path_, concat("two nodes have the number ", *twice));
        for (NodeNumbers& numbers : numbers_.elements) numbers.sort();
        for (std::size_t scope = 0; scope < numbers_.nodes.size(); ++scope)
            numbers_.partOf.push_back(scope);
        for (const auto& [scope, part] : partNames)
            if (const auto found = parts.find(part);
                found != parts.end() && numbers_.nodes[scope].empty())
                numbers_.partOf[scope] = found->second;
    }

    static void visit(const AbaqusFile& file, std::string_view name, const AbaqusElement& type,
                      std::span<const Index> nodes, CellVisitor& visitor) {
        if (type.dimension < 0)
            visitor.unknownElement(file.line(), concat("an element has the type ", inQuotes(name),
                                                       ", which is not known here"));
        else if (type.nodes == 0)
            visitor.smallCell(type.dimension, {});
        else if (type.isCurved)
            visitor.curvedCell(type.dimension, nodes);  // Abaqus has VTK's order.
        else if (type.dimension == 2)
            visitor.face(nodes);
        else
            visitor.cell(*far::kindOfCell(type.nodes), nodes);
    }

    const std::filesystem::path& path_;
    std::string_view bytes_;
    AbaqusNumbers numbers_;
};

void writeAbaqusNodes(std::ostream& out, const FileView& file, std::span<const Point3> moved,
                      std::span<const DeformationGradient> gradients) {
    const FileVectors& points = file.numbers.points;
    const auto hasNumbers = [&](const CoordinateOffsets& offsets) {
        return std::all_of(offsets.begin(),
                           offsets.begin() + static_cast<std::ptrdiff_t>(file.numbers.dimension),
                           hasNumberAt);
    };
    if (std::ranges::all_of(points.offsets, hasNumbers))
        return writeNumbers(out, file, moved, gradients);
    TextPatch patch(out, file.bytes);
    for (std::size_t point = 0; point < moved.size(); ++point) {
        const CoordinateOffsets& offsets = points.offsets[point];
        // The last coordinate that changes: all entries before it must be there.
        std::size_t last = 3;
        while (last > 0 && isSame(moved[point][last - 1], points.values[point][last - 1])) --last;
        for (std::size_t axis = 0; axis < last; ++axis) {
            const double now = moved[point][axis];
            if ((offsets[axis] & kBeyondLine) != 0) {
                const std::size_t end = offsets[axis] - kBeyondLine;
                const bool isFirst = axis == 0 || offsets[axis - 1] != offsets[axis];
                patch.insert(end, isFirst && file.bytes[end - 1] == ',' ? " " : ", ");
                patch.insert(end, formatNumber(now));
            } else if (isSame(now, points.values[point][axis])) {
                continue;
            } else if ((offsets[axis] & kEmptyEntry) != 0) {
                patch.insert(offsets[axis] - kEmptyEntry, formatNumber(now));
            } else {
                patch.replace(numberAt(file.bytes, offsets[axis]), now);
            }
        }
    }
    patch.finish();
}

constexpr MeshFormat kAbaqusMesh = {
    .readPoints = [](const std::filesystem::path& path,
                     std::string_view bytes) { return AbaqusPoints(path, bytes).read(); },
    .readCells = [](const std::filesystem::path& path, std::string_view bytes, Index,
                    CellVisitor& visitor) { AbaqusCells(path, bytes).read(visitor); },
    .write = writeAbaqusNodes};

}  // namespace

const Format kAbaqusFormat = {.extensions = {".inp"},
                              .isMesh = true,
                              .readModel = readMeshModel<kAbaqusMesh>,
                              .readLattice = readMeshLattice<kAbaqusMesh>};

}  // namespace espalier::io

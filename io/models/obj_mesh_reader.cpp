// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/far/cell_complex.h>
#include <espalier/far/complex_builder.h>
#include <espalier/far/marks.h>
#include <espalier/far/topology_error.h>
#include <espalier/io/files/file.h>
#include <espalier/io/models/obj_mesh.h>
#include <espalier/shapes/lattice.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "../lattices/lattice_parts.h"
#include "obj_statements.h"

namespace espalier::io {
namespace {

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

/// How many whole numbers, numbers and strings a tag has.
struct Counts {
    std::uint64_t ints = 0, floats = 0, strings = 0;

    std::uint64_t sum() const { return ints + floats + strings; }
    friend bool operator==(const Counts&, const Counts&) = default;
};

/// Whether `marks` marks have one sharpness each, or one for all.
bool fitMarks(const Counts& counts, std::uint64_t marks) {
    return marks > 0 && (counts.floats == 1 || counts.floats == marks) && counts.strings == 0;
}

// The counts that the kinds of tags may have.
bool areOfEdges(const Counts& counts) {
    return counts.ints % 2 == 0 && fitMarks(counts, counts.ints / 2);
}
bool areOfVertices(const Counts& counts) {
    return fitMarks(counts, counts.ints);
}
bool areOfFaces(const Counts& counts) {
    return counts.ints > 0 && counts == Counts{counts.ints, 0, 0};
}
bool areOneInt(const Counts& counts) {
    return counts == Counts{1, 0, 0};
}
bool areOneString(const Counts& counts) {
    return counts == Counts{0, 0, 1};
}

/// Reads "2/1/0".
bool parseCounts(std::string_view word, Counts& counts) {
    std::uint32_t parts[3] = {};
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t end = i < 2 ? word.find('/') : word.size();
        if (end == std::string_view::npos || !parseNumber(word.substr(0, end), parts[i]))
            return false;
        word.remove_prefix(std::min(end + 1, word.size()));
    }
    counts = {parts[0], parts[1], parts[2]};
    return true;
}

/// A sharpness as it is stored, so that what is written reads back the same; 0 if it is negative.
bool parseSharpness(std::string_view word, double& sharpness) {
    if (!parseNumber(word, sharpness) || std::isnan(sharpness)) return false;
    // By way of a double it could be rounded twice. What is no float is huge.
    if (float single = 0; parseNumber(word, single)) sharpness = single;
    sharpness = far::storedSharpness(std::max(sharpness, 0.0));
    return true;
}

/// A tag cut up by its counts.
struct ObjTags::Tag {
    std::size_t line;
    std::vector<std::int64_t> ints;
    std::vector<double> sharpness;
    std::vector<std::string_view> strings;

    /// Of mark i: there is one sharpness for each, or one for all.
    double sharpnessOf(std::size_t i) const { return sharpness[sharpness.size() > 1 ? i : 0]; }
};

struct ObjTags::Kind {
    std::string_view name;
    const char* counts;  ///< what they may be, for messages
    bool (*fits)(const Counts&);
    void (ObjTags::*take)(const Tag&);
};

void ObjTags::add(ObjWords& words, std::size_t line) {
    static constexpr Kind kKinds[] = {
        {"crease", "2k/1/0 or 2k/k/0 for k edges", areOfEdges, &ObjTags::addCreases},
        {"corner", "k/1/0 or k/k/0 for k vertices", areOfVertices, &ObjTags::addCorners},
        {"hole", "k/0/0 for k faces", areOfFaces, &ObjTags::addHoles},
        {"interpolateboundary", "1/0/0", areOneInt, &ObjTags::setBoundary},
        {"creasemethod", "0/0/1", areOneString, &ObjTags::setCreasing},
        {"smoothtriangles", "0/0/1", areOneString, &ObjTags::setTriangles}};
    const std::string_view name = words.next();
    if (name.empty()) throw FileError(path_, line, "the line ends; expected the name of a tag");
    for (const Kind& kind : kKinds)
        if (kind.name == name) (this->*kind.take)(parse(kind, words, line));
}

ObjTags::Tag ObjTags::parse(const Kind& kind, ObjWords& words, std::size_t line) const {
    const auto fail = [&](const std::string& cause) {
        throw FileError(path_, line, "the tag " + std::string(kind.name) + cause);
    };
    const std::string_view countsWord = words.next();
    Counts counts;
    if (!parseCounts(countsWord, counts) || !kind.fits(counts))
        fail(" has counts " + inQuotes(countsWord) + "; expected " + kind.counts);

    // No memory is taken for what is only claimed.
    Tag tag{line, {}, {}, {}};
    for (std::uint64_t i = 0; i < counts.sum(); ++i) {
        const std::string_view word = words.next();
        if (word.empty()) fail(concat(" ends after ", i, " words; expected ", counts.sum()));
        if (i < counts.ints) {
            if (!parseNumber(word, tag.ints.emplace_back()))
                fail(" has " + inQuotes(word) + "; expected a whole number");
        } else if (i < counts.ints + counts.floats) {
            if (!parseSharpness(word, tag.sharpness.emplace_back()))
                fail(" has " + inQuotes(word) + "; expected a sharpness");
        } else {
            tag.strings.push_back(word);
        }
    }
    if (const std::string_view word = words.next(); !word.empty())
        fail(concat(" goes on with ", inQuotes(word), " after ", counts.sum(),
                    " words; expected no more"));
    return tag;
}

void ObjTags::addCreases(const Tag& tag) {
    for (std::size_t i = 0; i < tag.ints.size() / 2; ++i)
        creases_.push_back({tag.line, {tag.ints[2 * i], tag.ints[2 * i + 1]}, tag.sharpnessOf(i)});
}

void ObjTags::addCorners(const Tag& tag) {
    for (std::size_t i = 0; i < tag.ints.size(); ++i)
        corners_.push_back({tag.line, {tag.ints[i]}, tag.sharpnessOf(i)});
}

void ObjTags::addHoles(const Tag& tag) {
    for (const std::int64_t face : tag.ints)
        holes_.push_back({tag.line, {face}, far::kInfinitelySharp});
}

void ObjTags::setBoundary(const Tag& tag) {
    switch (tag.ints[0]) {
        case 0:
            refinement_.boundary = far::Boundary::Open;
            break;
        case 1:
            refinement_.boundary = far::Boundary::Sharp;
            break;
        case 2:
            refinement_.boundary = far::Boundary::EdgeOnly;
            break;
        default:
            throw FileError(
                path_, tag.line,
                concat("the tag interpolateboundary is ", tag.ints[0], "; expected 0, 1 or 2"));
    }
}

void ObjTags::setCreasing(const Tag& tag) {
    if (tag.strings[0] == "normal")
        refinement_.creasing = far::Creasing::Uniform;
    else if (tag.strings[0] == "chaikin")
        refinement_.creasing = far::Creasing::Chaikin;
    else
        throw FileError(
            path_, tag.line,
            "the tag creasemethod is " + inQuotes(tag.strings[0]) + "; expected normal or chaikin");
}

void ObjTags::setTriangles(const Tag& tag) {
    if (tag.strings[0] == "catmark")
        refinement_.triangles = far::TriangleSubdivision::Catmark;
    else if (tag.strings[0] == "smooth")
        refinement_.triangles = far::TriangleSubdivision::Smooth;
    else
        throw FileError(path_, tag.line,
                        "the tag smoothtriangles is " + inQuotes(tag.strings[0]) +
                            "; expected catmark or smooth");
}

Index ObjTags::checkedNumber(std::int64_t number, Index count, const char* what,
                             std::size_t line) const {
    if (number < 0 || number >= count)
        throw FileError(
            path_, line,
            concat("a tag names ", what, " ", number,
                   count == 0 ? "; there are none" : concat("; expected 0 to ", count - 1)));
    return static_cast<Index>(number);
}

far::Marks ObjTags::marks(const far::CellComplex& mesh, std::span<const Index> dropped) const {
    const Index vertexCount = mesh.count(0) + static_cast<Index>(dropped.size());
    const auto vertexOf = [&](std::int64_t number, std::size_t line) {
        return numberWithout(dropped, checkedNumber(number, vertexCount, "vertex", line));
    };
    far::Marks marks;
    for (const auto& crease : creases_) {
        const auto a = vertexOf(crease.numbers[0], crease.line);
        const auto b = vertexOf(crease.numbers[1], crease.line);
        if (!a || !b || !isEdge(mesh, *a, *b))
            throw FileError(path_, crease.line,
                            concat("a tag names edge (", crease.numbers[0], ", ", crease.numbers[1],
                                   "); expected two neighbouring vertices of a face"));
        marks.edges.push_back({{*a, *b}, crease.sharpness});
    }
    for (const auto& corner : corners_)
        if (const auto vertex = vertexOf(corner.numbers[0], corner.line))
            marks.vertices.push_back({*vertex, corner.sharpness});
    for (const auto& hole : holes_)
        marks.holes.push_back(checkedNumber(hole.numbers[0], mesh.count(2), "face", hole.line));

    // After the later of two marks has won: a sharpness of 0 takes an earlier one back.
    marks = canonicalMarks(mesh, marks);
    const auto isSmooth = [](const auto& mark) { return mark.sharpness == far::kSmooth; };
    std::erase_if(marks.edges, isSmooth);
    std::erase_if(marks.vertices, isSmooth);
    return marks;
}

bool isEmptyOrWhole(std::string_view text) {
    std::int64_t ignored = 0;
    return text.empty() || parseNumber(text, ignored);
}

/// Reads "1", "1/2", "1//3" or "1/2/3", and keeps the 1.
bool parseCorner(std::string_view corner, std::int64_t& vertex) {
    const std::size_t first = corner.find('/');
    if (!parseNumber(corner.substr(0, first), vertex)) return false;
    if (first == std::string_view::npos) return true;
    const std::string_view rest = corner.substr(first + 1);
    const std::size_t second = rest.find('/');
    return isEmptyOrWhole(rest.substr(0, second)) &&
           (second == std::string_view::npos || isEmptyOrWhole(rest.substr(second + 1)));
}

/// The faces or the lines of a file.
struct Paths {
    const char* name;                      ///< "face" or "line"
    std::vector<std::int64_t> corners;     ///< of all, from 0; may be past the last vertex
    std::vector<std::size_t> ends;         ///< per path: end of its corners
    std::vector<std::size_t> lineNumbers;  ///< per path
    std::size_t count() const { return ends.size(); }
};

/// An `l`, to be read when it is known that there is no face.
struct LineStatement {
    ObjWords words;
    std::size_t line;
    std::size_t vertexCount;  ///< of the vertices before it
};

class ObjMeshReader {
public:
    explicit ObjMeshReader(const std::filesystem::path& path) : path_(path), tags_(path) {}

    Lattice read(std::string_view text, ReadNotes* notes) {
        forEachObjStatement(path_, text, [&](ObjWords& words, std::size_t line) {
            const std::string_view keyword = readObjKeyword(words, path_, line);
            if (keyword == "v")
                mesh_.positions.push_back(readObjPoint(words, path_, line).position);
            else if (keyword == "f" || keyword == "fo")
                readPath(words, line, mesh_.positions.size(), faces_);
            else if (keyword == "l")
                lineStatements_.push_back({words, line, mesh_.positions.size()});
            else if (keyword == "t")
                tags_.add(words, line);
        });
        const bool isCurve = faces_.count() == 0 && !lineStatements_.empty();
        if (faces_.count() == 0 && !isCurve)
            throw far::TopologyError(
                far::TopologyCause::EmptyComplex, {2, 0},
                shownPath(path_) + ": there is no face and no line, so neither a mesh nor a curve");
        std::vector<Index> dropped;
        mesh_.complex = isCurve ? buildCurve(dropped) : buildMesh();
        mesh_.marks = tags_.marks(mesh_.complex, dropped);
        eraseVertices(dropped, 1, mesh_.positions);
        if (notes) notes->droppedVertices = std::move(dropped);
        mesh_.tags = tags_.refinement();
        return std::move(mesh_);
    }

private:
    /// \param vertexCount of the vertices before it
    void readPath(ObjWords& words, std::size_t line, std::size_t vertexCount, Paths& paths) const {
        const auto before = static_cast<std::int64_t>(vertexCount);
        for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
            std::int64_t vertex = 0;
            if (!parseCorner(word, vertex))
                throw FileError(path_, line,
                                inQuotes(word) + " is not a corner of a " + paths.name +
                                    "; expected v, v/vt, v//vn or v/vt/vn");
            if (vertex == 0)
                throw FileError(path_, line,
                                std::string("a ") + paths.name +
                                    " names vertex 0; expected 1 or more, or less "
                                    "than 0 to count back");
            if (vertex < -before)
                throw FileError(path_, line,
                                concat("a ", paths.name, " names vertex ", vertex, "; there are ",
                                       before, " before it"));
            paths.corners.push_back(vertex < 0 ? before + vertex : vertex - 1);
        }
        paths.ends.push_back(paths.corners.size());
        paths.lineNumbers.push_back(line);
    }

    /// Calls add(vertices, line) for each path. What it throws of a topology gets path and line.
    template <class Add>
    void forEachPath(const Paths& paths, Add add) const {
        std::vector<Index> vertices;
        std::size_t corner = 0;
        for (std::size_t i = 0; i < paths.count(); ++i) {
            vertices.clear();
            for (; corner < paths.ends[i]; ++corner) {
                if (paths.corners[corner] >= vertexCount())
                    throw FileError(
                        path_, paths.lineNumbers[i],
                        concat("a ", paths.name, " names vertex ", paths.corners[corner] + 1,
                               "; the file has ", vertexCount()));
                vertices.push_back(static_cast<Index>(paths.corners[corner]));
            }
            naming(
                path_, [&] { add(vertices, paths.lineNumbers[i]); }, paths.lineNumbers[i]);
        }
    }

    far::CellComplex buildMesh() const {
        far::ComplexBuilder builder(2, vertexCount());
        forEachPath(faces_,
                    [&](const std::vector<Index>& loop, std::size_t) { builder.addFace(loop); });
        return naming(path_, [&] { return builder.build(); });
    }

    /// \param dropped gets the vertices that are on no line; the curve lacks them
    far::CellComplex buildCurve(std::vector<Index>& dropped) const {
        Paths lines{"line", {}, {}, {}};
        for (LineStatement statement : lineStatements_)
            readPath(statement.words, statement.line, statement.vertexCount, lines);
        far::ComplexBuilder builder(1, vertexCount());
        std::set<std::pair<Index, Index>> edges;
        forEachPath(lines, [&](const std::vector<Index>& vertices, std::size_t line) {
            if (vertices.size() < 2)
                throw FileError(path_, line,
                                concat("a line names ", vertices.size(),
                                       vertices.size() == 1 ? " vertex" : " vertices",
                                       "; expected two or more"));
            for (std::size_t i = 1; i < vertices.size(); ++i) {
                const auto [low, high] = std::minmax(vertices[i - 1], vertices[i]);
                if (low == high)
                    throw FileError(path_, line,
                                    "a line names " + nameInFile(low) + " twice in a row");
                if (!edges.insert({low, high}).second)
                    throw FileError(
                        path_, line,
                        nameInFile(low) + " and " + nameInFile(high) + " are joined twice");
                builder.addEdge(vertices[i - 1], vertices[i]);
            }
        });
        dropped = builder.dropUnusedVertices();
        return namingWithout(path_, dropped, [&] { return builder.build(); });
    }

    /// "vertex 1" for the first.
    static std::string nameInFile(Index vertex) { return concat("vertex ", vertex + 1); }

    Index vertexCount() const { return checkedIndex(path_, mesh_.positions.size(), "vertices"); }

    std::filesystem::path path_;
    Lattice mesh_;
    ObjTags tags_;
    Paths faces_{"face", {}, {}, {}};
    std::vector<LineStatement> lineStatements_;
};

}  // namespace

Lattice readObjMesh(const std::filesystem::path& path, std::string_view bytes, ReadNotes* notes) {
    return ObjMeshReader(path).read(bytes, notes);
}

}  // namespace espalier::io

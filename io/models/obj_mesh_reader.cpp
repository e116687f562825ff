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
#include "coordinates.h"
#include "obj_statements.h"

namespace espalier::io {
namespace {

/// Collects the tags of an OBJ (obj_mesh.h) while the file is read. They are checked when the mesh
/// is complete, because a tag may precede the faces that it names.
class ObjTags {
public:
    explicit ObjTags(std::filesystem::path path) : path_(std::move(path)) {}

    /// Reads a `t` statement. Tags with unknown names are ignored.
    /// \param words the words after the `t`
    /// \throws FileError if the counts do not fit the name or the words, or a word is malformed
    void add(ObjWords& words, std::size_t line);

    const RefinementTags& refinement() const { return refinement_; }

    /// Returns the canonical marks (lattice_parts.h), without marks of sharpness 0 and without
    /// corner marks on dropped vertices.
    /// \param dropped the vertices of the file that the mesh lacks, ascending
    /// \throws FileError with the line of a tag that names a vertex, an edge or a face that the
    ///         mesh lacks
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
    void setFaceVarying(const Tag& tag);

    Index checkedNumber(std::int64_t number, Index count, const char* what, std::size_t line) const;

    std::filesystem::path path_;
    std::vector<Mark<2>> creases_;
    std::vector<Mark<1>> corners_;
    std::vector<Mark<1>> holes_;
    RefinementTags refinement_;
};

/// The numbers of integers, real numbers and strings in a tag.
struct Counts {
    std::uint64_t ints = 0, floats = 0, strings = 0;

    std::uint64_t sum() const { return ints + floats + strings; }
    friend bool operator==(const Counts&, const Counts&) = default;
};

/// Returns true if the tag has one sharpness for each of its marks, or one for all of them.
bool fitMarks(const Counts& counts, std::uint64_t marks) {
    return marks > 0 && (counts.floats == 1 || counts.floats == marks) && counts.strings == 0;
}

// The counts that each kind of tag may have.
bool areEdgeCounts(const Counts& counts) {
    return counts.ints % 2 == 0 && fitMarks(counts, counts.ints / 2);
}
bool areVertexCounts(const Counts& counts) {
    return fitMarks(counts, counts.ints);
}
bool areFaceCounts(const Counts& counts) {
    return counts.ints > 0 && counts == Counts{counts.ints, 0, 0};
}
bool areOneInt(const Counts& counts) {
    return counts == Counts{1, 0, 0};
}
bool areOneString(const Counts& counts) {
    return counts == Counts{0, 0, 1};
}

/// Reads counts such as "2/1/0". Returns false if the word is malformed.
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

/// Reads a sharpness and rounds it to its stored precision, so that writing and reading it again
/// gives the same value. Negative values become 0. Returns false if the word is no number.
bool parseSharpness(std::string_view word, double& sharpness) {
    if (!parseNumber(word, sharpness) || std::isnan(sharpness)) return false;
    // Parsed as a float, since rounding to double first could round twice. A number that is too
    // large for a float keeps its double.
    if (float single = 0; parseNumber(word, single)) sharpness = single;
    sharpness = far::storedSharpness(std::max(sharpness, 0.0));
    return true;
}

/// A tag, split into integers, sharpness values and strings by its counts.
struct ObjTags::Tag {
    std::size_t line;
    std::vector<std::int64_t> ints;
    std::vector<double> sharpness;
    std::vector<std::string_view> strings;

    /// Returns the sharpness of mark i. The tag has one for each mark, or one for all.
    double sharpnessOf(std::size_t i) const { return sharpness[sharpness.size() > 1 ? i : 0]; }
};

struct ObjTags::Kind {
    std::string_view name;
    const char* counts;  ///< the expected counts, for messages
    bool (*fits)(const Counts&);
    void (ObjTags::*take)(const Tag&);
};

void ObjTags::add(ObjWords& words, std::size_t line) {
    static constexpr Kind kKinds[] = {
        {"crease", "2k/1/0 or 2k/k/0 for k edges", areEdgeCounts, &ObjTags::addCreases},
        {"corner", "k/1/0 or k/k/0 for k vertices", areVertexCounts, &ObjTags::addCorners},
        {"hole", "k/0/0 for k faces", areFaceCounts, &ObjTags::addHoles},
        {"interpolateboundary", "1/0/0", areOneInt, &ObjTags::setBoundary},
        {"creasemethod", "0/0/1", areOneString, &ObjTags::setCreasing},
        {"smoothtriangles", "0/0/1", areOneString, &ObjTags::setTriangles},
        {"facevaryinginterpolateboundary", "1/0/0", areOneInt, &ObjTags::setFaceVarying}};
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

    // The vectors grow word by word: the claimed counts may be huge.
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

void ObjTags::setFaceVarying(const Tag& tag) {
    // OpenSubdiv numbers its modes in the order of the words.
    const std::int64_t mode = tag.ints[0];
    if (mode < 0 || mode >= std::ssize(far::kFaceVaryingLinearWords))
        throw FileError(path_, tag.line,
                        concat("the tag facevaryinginterpolateboundary is ", mode,
                               "; expected 0 to ", std::ssize(far::kFaceVaryingLinearWords) - 1));
    refinement_.faceVarying = static_cast<far::FaceVaryingLinear>(mode);
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

    // canonicalMarks() keeps the later of two marks; then a sharpness of 0 cancels an earlier mark.
    marks = canonicalMarks(mesh, marks);
    const auto isSmooth = [](const auto& mark) { return mark.sharpness == far::kSmooth; };
    std::erase_if(marks.edges, isSmooth);
    std::erase_if(marks.vertices, isSmooth);
    return marks;
}

/// Reads a whole number, or 0 from an empty word. Returns false if the word is malformed.
bool parseWholeOrEmpty(std::string_view word, std::int64_t& number) {
    number = 0;
    return word.empty() || parseNumber(word, number);
}

/// Reads the vertex, 1, and the texture coordinate, 2 or 0 if there is none, of a corner "1",
/// "1/2", "1//3" or "1/2/3". Returns false if it is malformed.
bool parseCorner(std::string_view corner, std::int64_t& vertex, std::int64_t& texture) {
    texture = 0;
    const std::size_t first = corner.find('/');
    if (!parseNumber(corner.substr(0, first), vertex)) return false;
    if (first == std::string_view::npos) return true;
    const std::string_view rest = corner.substr(first + 1);
    const std::size_t second = rest.find('/');
    std::int64_t normal = 0;
    return parseWholeOrEmpty(rest.substr(0, second), texture) &&
           (second == std::string_view::npos || parseWholeOrEmpty(rest.substr(second + 1), normal));
}

/// The faces or the lines of a file.
struct Paths {
    const char* name;                      ///< "face" or "line"
    std::vector<std::int64_t> corners;     ///< vertices of all paths, from 0; some may not exist
    std::vector<std::size_t> ends;         ///< the end of the corners of each path
    std::vector<std::size_t> lineNumbers;  ///< the line of each path in the file
    /// Texture coordinates of all corners, from 0; −1 where a corner has none; may exceed the last.
    std::vector<std::int64_t> textures = {};
    std::size_t count() const { return ends.size(); }
};

/// An `l` statement. It is read only when the end of the file has shown that there is no face.
struct LineStatement {
    ObjWords words;
    std::size_t line;
    std::size_t vertexCount;  ///< number of vertices before the statement
};

class ObjMeshReader {
public:
    explicit ObjMeshReader(const std::filesystem::path& path) : path_(path), tags_(path) {}

    Lattice read(std::string_view text, ReadNotes* notes) {
        ObjKeywords keywords(path_);
        forEachObjStatement(path_, text, [&](ObjWords& words, std::size_t line) {
            const std::string_view keyword = keywords.read(words, line);
            if (keyword == "v")
                mesh_.positions.push_back(readPoint(words, line));
            else if (keyword == "vt")
                textures_.push_back(readTexture(words, line));
            else if (keyword == "f" || keyword == "fo")
                readPath(words, line, mesh_.positions.size(), faces_);
            else if (keyword == "l")
                lineStatements_.push_back({words, line, mesh_.positions.size()});
            else if (keyword == "t")
                tags_.add(words, line);
        });
        keywords.checkFile(!mesh_.positions.empty());
        if (const std::string lines = keywords.unknown(); notes && !lines.empty())
            notes->others.push_back("skipped " + lines);
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
        if (!isCurve) addTextureCoordinates(notes);
        return std::move(mesh_);
    }

private:
    Point3 readPoint(ObjWords& words, std::size_t line) const {
        const ObjPoint point = readObjPoint(words, path_, line);
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (!std::isfinite(point.position[axis]))
                refuseNotFinite(point.words[axis], axis, path_, line);
        return point.position;
    }

    /// Reads u and v of a `vt` statement; v is 0 if it is missing, and w is not kept.
    std::array<double, 2> readTexture(ObjWords& words, std::size_t line) const {
        std::array<double, 2> texture = {};
        for (std::size_t i = 0; i < 2; ++i) {
            const std::string_view word = words.next();
            if (i == 1 && word.empty()) break;
            if (!parseNumber(word, texture[i]) || !std::isfinite(texture[i]))
                throw FileError(path_, line,
                                inQuotes(word) + " is not a texture coordinate; expected a number");
        }
        return texture;
    }

    /// Gives the mesh its texture coordinates, if each corner of each face names one.
    void addTextureCoordinates(ReadNotes* notes) {
        if (textures_.empty()) return;
        const auto count = static_cast<std::int64_t>(textures_.size());
        for (const std::int64_t texture : faces_.textures) {
            if (0 <= texture && texture < count) continue;
            if (notes)
                notes->droppedTextureCoordinates =
                    checkedIndex(path_, textures_.size(), "texture coordinates");
            return;
        }
        FaceVaryingAttribute& result = mesh_.textureCoordinates;
        for (const auto& texture : textures_)
            result.values.insert(result.values.end(), texture.begin(), texture.end());
        for (const std::int64_t texture : faces_.textures)
            result.corners.push_back(static_cast<Index>(texture));
    }

    /// Adds a statement to `paths`.
    /// \param vertexCount number of vertices before the statement
    void readPath(ObjWords& words, std::size_t line, std::size_t vertexCount, Paths& paths) const {
        const auto before = static_cast<std::int64_t>(vertexCount);
        for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
            std::int64_t vertex = 0, texture = 0;
            if (!parseCorner(word, vertex, texture))
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
            const auto texturesBefore = static_cast<std::int64_t>(textures_.size());
            paths.textures.push_back(
                texture < 0 ? std::max<std::int64_t>(texturesBefore + texture, -1) : texture - 1);
        }
        paths.ends.push_back(paths.corners.size());
        paths.lineNumbers.push_back(line);
    }

    /// Calls add(vertices, line) for each path. A TopologyError that `add` throws gets the path and
    /// line of the file.
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
            withPathInErrors(
                path_, [&] { add(vertices, paths.lineNumbers[i]); }, paths.lineNumbers[i]);
        }
    }

    far::CellComplex buildMesh() const {
        far::ComplexBuilder builder(2, vertexCount());
        forEachPath(faces_,
                    [&](const std::vector<Index>& loop, std::size_t) { builder.addFace(loop); });
        return withPathInErrors(path_, [&] { return builder.build(); });
    }

    /// \param dropped receives the vertices that are on no line; the curve lacks them
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
        return withPathAndDroppedInErrors(path_, dropped, [&] { return builder.build(); });
    }

    /// Names a vertex as the file does: vertex 0 is "vertex 1".
    static std::string nameInFile(Index vertex) { return concat("vertex ", vertex + 1); }

    Index vertexCount() const { return checkedIndex(path_, mesh_.positions.size(), "vertices"); }

    std::filesystem::path path_;
    Lattice mesh_;
    ObjTags tags_;
    Paths faces_{"face", {}, {}, {}};
    std::vector<std::array<double, 2>> textures_;
    std::vector<LineStatement> lineStatements_;
};

}  // namespace

Lattice readObjMesh(const std::filesystem::path& path, std::string_view bytes, ReadNotes* notes) {
    return ObjMeshReader(path).read(bytes, notes);
}

}  // namespace espalier::io

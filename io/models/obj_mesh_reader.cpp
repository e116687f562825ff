// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/far/complex_builder.h>
#include <espalier/far/topology_error.h>
#include <espalier/io/files/file.h>
#include <espalier/io/models/obj_mesh.h>

#include <algorithm>
#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "../lattices/lattice_parts.h"
#include "obj_statements.h"
#include "obj_tags.h"

namespace espalier::io {

namespace {

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
            throw far::TopologyError(far::TopologyCause::EmptyComplex, {2, 0},
                                     shownPath(path_) + ": there is no face, and no line");
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
            naming(path_, paths.lineNumbers[i], [&] { add(vertices, paths.lineNumbers[i]); });
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

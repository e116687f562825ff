// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/complex_builder.h>
#include <espalier/io/file.h>
#include <espalier/io/lattice_parts.h>
#include <espalier/io/obj_mesh.h>
#include <espalier/io/obj_statements.h>
#include <espalier/io/obj_tags.h>
#include <espalier/io/words.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace espalier::io {

using far::Index;

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

class ObjMeshReader {
public:
    explicit ObjMeshReader(const std::filesystem::path& path) : path_(path), tags_(path) {}

    Lattice read(std::string_view text) {
        forEachObjStatement(path_, text, [&](ObjWords& words, std::size_t line) {
            const std::string_view keyword = words.next();
            if (keyword == "v")
                mesh_.positions.push_back(readObjPoint(words, path_, line).position);
            else if (keyword == "f")
                readFace(words, line);
            else if (keyword == "t")
                tags_.add(words, line);
        });
        mesh_.complex = build();
        mesh_.marks = tags_.marks(mesh_.complex);
        mesh_.tags = tags_.refinement();
        return std::move(mesh_);
    }

private:
    void readFace(ObjWords& words, std::size_t line) {
        const auto vertexCount = static_cast<std::int64_t>(mesh_.positions.size());
        for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
            std::int64_t vertex = 0;
            if (!parseCorner(word, vertex))
                throw FileError(path_, line,
                                inQuotes(word) +
                                    " is not a corner of a face; expected v, v/vt, v//vn or "
                                    "v/vt/vn");
            if (vertex == 0)
                throw FileError(path_, line,
                                "a face names vertex 0; expected 1 or more, or less "
                                "than 0 to count back");
            if (vertex < -vertexCount)
                throw FileError(path_, line,
                                "a face names vertex " + std::to_string(vertex) + "; there are " +
                                    std::to_string(vertexCount) + " before it");
            corners_.push_back(vertex < 0 ? vertexCount + vertex : vertex - 1);
        }
        faceEnds_.push_back(corners_.size());
        faceLines_.push_back(line);
    }

    far::CellComplex build() const {
        const Index vertexCount = checkedIndex(path_, mesh_.positions.size(), "vertices");
        far::ComplexBuilder builder(2, vertexCount);
        std::vector<Index> loop;
        std::size_t corner = 0;
        for (std::size_t face = 0; face < faceEnds_.size(); ++face) {
            loop.clear();
            for (; corner < faceEnds_[face]; ++corner) {
                if (corners_[corner] >= vertexCount)
                    throw FileError(path_, faceLines_[face],
                                    "a face names vertex " + std::to_string(corners_[corner] + 1) +
                                        "; the file has " + std::to_string(vertexCount));
                loop.push_back(static_cast<Index>(corners_[corner]));
            }
            naming(path_, faceLines_[face], [&] { return builder.addFace(loop); });
        }
        return naming(path_, [&] { return builder.build(); });
    }

    std::filesystem::path path_;
    Lattice mesh_;
    ObjTags tags_;
    std::vector<std::int64_t> corners_;   ///< of all faces, from 0; may be past the last vertex
    std::vector<std::size_t> faceEnds_;   ///< per face: end of its corners
    std::vector<std::size_t> faceLines_;  ///< per face
};

}  // namespace

Lattice readObjMesh(const std::filesystem::path& path) {
    const std::string text = readFile(path);
    return ObjMeshReader(path).read(text);
}

}  // namespace espalier::io

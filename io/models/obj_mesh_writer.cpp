// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/far/marks.h>
#include <espalier/io/files/file.h>
#include <espalier/io/models/obj_mesh.h>

#include <cmath>
#include <initializer_list>
#include <ostream>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "../files/text_output.h"
#include "../lattices/lattice_parts.h"
#include "../vtk/vtk_xml.h"
#include "surface_writers.h"

namespace espalier::io {

namespace {

/// Splits a curve into lines that are as long as possible: first the lines that begin at an end or
/// a junction, then closed lines, which end at their first vertex.
std::vector<std::vector<Index>> linesOf(const far::CellComplex& curve) {
    const auto& edgesAt = curve.relation(0, 1);
    const auto& endsOf = curve.relation(1, 0);
    std::vector<bool> isDrawn(curve.count(1), false);
    std::vector<std::vector<Index>> lines;
    const auto draw = [&](Index edge, Index from) {
        std::vector<Index> line = {from};
        while (!isDrawn[edge]) {
            isDrawn[edge] = true;
            const Index to = endsOf[edge][endsOf[edge].front() == line.back() ? 1 : 0];
            line.push_back(to);
            if (edgesAt[to].size() != 2) break;
            edge = edgesAt[to][edgesAt[to].front() == edge ? 1 : 0];
        }
        if (line.size() > 1) lines.push_back(std::move(line));
    };
    for (Index vertex = 0; vertex < curve.count(0); ++vertex)
        if (edgesAt[vertex].size() != 2)
            for (const Index edge : edgesAt[vertex]) draw(edge, vertex);
    for (Index vertex = 0; vertex < curve.count(0); ++vertex) draw(edgesAt[vertex].front(), vertex);
    return lines;
}

class ObjMeshWriter {
public:
    explicit ObjMeshWriter(std::ostream& out) : out_(out) {}

    void write(const Lattice& mesh, const far::Marks& marks) {
        putObjPoints(out_, mesh.positions);
        const FaceVaryingAttribute& textures = mesh.textureCoordinates;
        for (std::size_t i = 0; i < textures.values.size(); ++i)
            out_.put(i % 2 == 0 ? "vt " : " ", textures.values[i], i % 2 == 0 ? "" : "\n");
        if (mesh.complex.dimension() == 1)
            for (const std::vector<Index>& line : linesOf(mesh.complex)) writeLine(line);
        else
            for (Index face = 0; face < mesh.complex.count(2); ++face) writeFace(mesh, face);
        writeTags(mesh.tags);
        for (const auto& mark : marks.edges)
            writeMark("t crease 2/1/0", {mark.vertices[0], mark.vertices[1]}, mark.sharpness);
        for (const auto& mark : marks.vertices)
            writeMark("t corner 1/1/0", {mark.vertex}, mark.sharpness);
        for (const Index face : marks.holes) out_.put("t hole 1/0/0 ", face, "\n");
    }

private:
    void writeLine(std::span<const Index> vertices) {
        out_.put("l");
        for (const Index vertex : vertices) out_.put(" ", vertex + 1);
        out_.put("\n");
    }

    void writeFace(const Lattice& mesh, Index face) {
        const far::Incidence& loops = mesh.complex.relation(2, 0);
        std::span<const Index> textures = mesh.textureCoordinates.corners;
        if (!textures.empty()) textures = textures.subspan(loops.offset(face), loops[face].size());
        putObjFace(out_, loops[face], textures);
    }

    static int numberOf(far::Boundary boundary) {
        switch (boundary) {
            case far::Boundary::Open:
                return 0;
            case far::Boundary::Sharp:
                return 1;
            case far::Boundary::EdgeOnly:
                break;
        }
        return 2;
    }

    void writeTags(const RefinementTags& tags) {
        if (tags.boundary) out_.put("t interpolateboundary 1/0/0 ", numberOf(*tags.boundary), "\n");
        if (tags.creasing) {
            const bool isChaikin = tags.creasing == far::Creasing::Chaikin;
            out_.put("t creasemethod 0/0/1 ", isChaikin ? "chaikin\n" : "normal\n");
        }
        if (tags.triangles) {
            const bool isSmooth = tags.triangles == far::TriangleSubdivision::Smooth;
            out_.put("t smoothtriangles 0/0/1 ", isSmooth ? "smooth\n" : "catmark\n");
        }
        if (tags.faceVarying)
            out_.put("t facevaryinginterpolateboundary 1/0/0 ", static_cast<int>(*tags.faceVarying),
                     "\n");
    }

    void writeMark(const char* tag, std::initializer_list<Index> vertices, double sharpness) {
        const float stored = far::storedSharpness(sharpness);
        if (stored == far::kSmooth) return;
        out_.put(tag);
        for (const Index vertex : vertices) out_.put(" ", vertex);
        out_.put(" ", static_cast<float>(sharpnessToFile(stored)), "\n");
    }

    TextOutput out_;
};

void checkTextureCoordinates(const std::filesystem::path& path, const Lattice& mesh) {
    const auto& [components, values, corners] = mesh.textureCoordinates;
    if (values.empty() && corners.empty()) return;
    const auto fail = [&](const std::string& cause) {
        throw FileError(path, "cannot be written: the texture coordinates " + cause);
    };
    if (components != 2) fail(concat("have ", components, " components; an OBJ has 2"));
    if (values.size() % 2 != 0) fail(concat("have ", values.size(), " numbers; expected pairs"));
    for (const double value : values)
        if (!std::isfinite(value)) fail("are not finite");
    if (corners.empty()) return;
    if (mesh.complex.dimension() != 2 ||
        corners.size() != mesh.complex.relation(2, 0).values().size())
        fail("are not one for each corner of each face");
    for (const Index corner : corners)
        if (corner < 0 || corner >= std::ssize(values) / 2)
            fail(concat("have no number ", corner, ", which a corner names"));
}

}  // namespace

void writeObjMesh(const std::filesystem::path& path, const Lattice& mesh) {
    const int dimension = mesh.complex.dimension() == 1 ? 1 : 2;
    const far::Marks marks = checkedForWriting(path, mesh, dimension);
    if (!mesh.attributes.empty() || !mesh.integers.empty())
        throw FileError(path, "cannot be written: the mesh has the attribute " +
                                  inQuotes(mesh.attributes.empty() ? mesh.integers[0].name
                                                                   : mesh.attributes[0].name) +
                                  ", and an OBJ has no place for attributes");
    checkTextureCoordinates(path, mesh);
    writeFile(path, [&](std::ostream& out) { ObjMeshWriter(out).write(mesh, marks); });
}

}  // namespace espalier::io

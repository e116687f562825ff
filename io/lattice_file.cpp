// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/lattices/ovm.h>
#include <espalier/io/meshes/gmsh.h>
#include <espalier/io/meshes/medit.h>
#include <espalier/io/meshes/openfoam.h>
#include <espalier/io/meshes/plot3d.h>
#include <espalier/io/meshes/su2.h>
#include <espalier/io/models/obj_mesh.h>
#include <espalier/io/read_notes.h>
#include <espalier/io/vtk/vtk_legacy.h>

#include <algorithm>
#include <string>
#include <string_view>

namespace espalier::io {

namespace {

/// Returns the note on skipped cells, "skipped 2 lines and 6 surface cells, ..."; empty if there
/// are none.
std::string skippedText(const std::array<Index, 3>& counts) {
    constexpr const char* kNames[3][2] = {
        {"vertex cell", "vertex cells"}, {"line", "lines"}, {"surface cell", "surface cells"}};
    std::vector<std::string> parts;
    for (std::size_t d = 0; d < counts.size(); ++d)
        if (counts[d] > 0) parts.push_back(concat(counts[d], " ", kNames[d][counts[d] > 1]));
    if (parts.empty()) return "";
    std::string text = "skipped " + parts[0];
    for (std::size_t i = 1; i < parts.size(); ++i)
        text += (i + 1 < parts.size() ? ", " : " and ") + parts[i];
    const bool isOne = counts[0] + counts[1] + counts[2] == 1;
    return text +
           (isOne ? ", which is not a cell of a lattice" : ", which are not cells of a lattice");
}

/// Returns the note on texture coordinates; empty if none were dropped.
std::string droppedText(Index textureCoordinates) {
    if (textureCoordinates == 0) return "";
    return concat("dropped ", textureCoordinates,
                  " texture coordinates, because some corners of faces have none");
}

/// Returns the note on vertices; empty if none were dropped.
std::string droppedText(const std::vector<Index>& dropped) {
    if (dropped.empty()) return "";
    const bool isOne = dropped.size() == 1;
    return concat("dropped ", dropped.size(),
                  isOne ? " unused vertex (vertex " : " unused vertices (vertices ",
                  listed(dropped), ")");
}

}  // namespace

std::string describe(const std::filesystem::path& path, const ReadNotes& notes) {
    const std::string all[] = {skippedText(notes.skippedCells), droppedText(notes.droppedVertices),
                               droppedText(notes.droppedTextureCoordinates)};
    std::string text;
    for (const std::string& note : all)
        if (!note.empty()) text += (text.empty() ? shownPath(path) + ": " : "; ") + note;
    return text;
}

namespace {

using Path = std::filesystem::path;

using LatticeReader = Lattice (*)(const Path&, std::string_view bytes, ReadNotes*);

struct LatticeFormat {
    std::string_view extension;  ///< or the name of the file
    LatticeReader read;
    void (*write)(const Path&, const Lattice&, const WriteLatticeOptions&) = nullptr;
};

constexpr LatticeFormat kFormats[] = {
    {".ovm", readOvm,
     [](const Path& path, const Lattice& lattice, const WriteLatticeOptions&) {
         writeOvm(path, lattice);
     }},
    {".vtu", readVtu,
     [](const Path& path, const Lattice& lattice, const WriteLatticeOptions& options) {
         writeVtu(path, lattice, options.vtuEncoding);
     }},
    {".vtk", readVtkLegacy,
     [](const Path& path, const Lattice& lattice, const WriteLatticeOptions&) {
         writeVtkLegacy(path, lattice);
     }},
    {".msh", readGmsh},
    {".mesh", readMedit},
    {".su2", readSu2},
    {".xyz", readPlot3d},
    {".p3d", readPlot3d},
    {".fmt", readPlot3d},
    {kFoamPoints, readFoam}};

constexpr std::string_view kMeshExtension = ".obj";

std::string extensionOf(const Path& path) {
    return lowerCase(path.extension().string());
}

/// Returns ".ovm, .vtu, .vtk" for writing; for reading more.
std::string latticeExtensions(bool areWritten = false) {
    std::string names;
    for (const LatticeFormat& format : kFormats)
        if (format.write || (!areWritten && format.read != readFoam))
            names += (names.empty() ? "" : ", ") + std::string(format.extension);
    return areWritten ? names : names + " or an OpenFOAM case";
}

/// The format that a path names; null if it names none.
const LatticeFormat* findFormat(const Path& path) {
    const std::string extension = extensionOf(path);
    for (const LatticeFormat& format : kFormats)
        if (format.extension == extension || (format.read == readFoam && isFoamPath(path)))
            return &format;
    return nullptr;
}

bool isMeshFile(const Path& path) {
    return extensionOf(path) == kMeshExtension;
}

const LatticeFormat& formatOf(const Path& path, bool isWritten = false) {
    if (const LatticeFormat* format = findFormat(path)) return *format;
    throw FileError(path, (isMeshFile(path) ? "an OBJ file holds a mesh or a curve, not a lattice"
                                            : "is not of a known lattice format") +
                              ("; expected " + latticeExtensions(isWritten)));
}

const LatticeFormat& writableFormatOf(const Path& path) {
    const LatticeFormat& format = formatOf(path, true);
    if (!format.write)
        throw FileError(path,
                        concat("a lattice cannot be written in this format, which is only read; "
                               "expected ",
                               latticeExtensions(true)));
    return format;
}

LatticeReader refinableReaderOf(const Path& path) {
    if (isMeshFile(path)) return readObjMesh;
    if (const LatticeFormat* format = findFormat(path)) return format->read;
    throw FileError(path, "is not of a known format of curves, meshes or lattices; expected " +
                              std::string(kMeshExtension) + ", " + latticeExtensions());
}

}  // namespace

bool isLatticeFile(const Path& path) {
    return findFormat(path) != nullptr;
}

Lattice readLattice(const Path& path, ReadNotes* notes) {
    const LatticeFormat& format = formatOf(path);
    const Path file = foamPointsOf(path);
    return format.read(file, readFile(file), notes);
}

Lattice readLattice(const Path& path, std::string_view bytes, ReadNotes* notes) {
    return formatOf(path).read(path, bytes, notes);
}

void writeLattice(const Path& path, const Lattice& lattice, const WriteLatticeOptions& options) {
    writableFormatOf(path).write(path, lattice, options);
}

void checkLatticeTarget(const Path& path) {
    writableFormatOf(path);
}

Lattice readRefinable(const Path& path, ReadNotes* notes) {
    const LatticeReader read = refinableReaderOf(path);
    const Path file = foamPointsOf(path);
    return read(file, readFile(file), notes);
}

Lattice readRefinable(const Path& path, std::string_view bytes, ReadNotes* notes) {
    return refinableReaderOf(path)(path, bytes, notes);
}

void writeRefinable(const Path& path, const Lattice& lattice, const WriteLatticeOptions& options) {
    checkRefinableTarget(path, lattice.complex.dimension());
    if (isMeshFile(path))
        writeObjMesh(path, lattice);
    else
        writeLattice(path, lattice, options);
}

void checkRefinableTarget(const Path& path, int dimension) {
    if ((dimension == 1 || dimension == 2) && !isMeshFile(path))
        throw FileError(path, std::string(dimension == 1 ? "a curve" : "a mesh") +
                                  " cannot be written in this format; expected " +
                                  std::string(kMeshExtension));
    const LatticeFormat* format = findFormat(path);
    if (dimension == 3 && (!format || !format->write))
        throw FileError(path, "a lattice cannot be written in this format; expected " +
                                  latticeExtensions(true));
    if (dimension < 1 || dimension > 3)
        throw FileError(path, concat("a complex of dimension ", dimension,
                                     " cannot be written; expected a curve (1), a mesh (2) or a "
                                     "lattice (3)"));
}

}  // namespace espalier::io

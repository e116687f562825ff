// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <espalier/io/read_notes.h>

#include <algorithm>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "files/other_content.h"
#include "format.h"

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

/// Returns the notes that are not empty, with semicolons between them.
std::string joined(std::span<const std::string> notes) {
    std::string text;
    for (const std::string& note : notes)
        if (!note.empty()) text += (text.empty() ? "" : "; ") + note;
    return text;
}

std::string lineOf(const std::filesystem::path& path, std::span<const std::string> notes) {
    const std::string text = joined(notes);
    return text.empty() ? text : shownPath(path) + ": " + text;
}

}  // namespace

std::string describe(const std::filesystem::path& path, const ReadNotes& notes) {
    std::vector<std::string> all = {skippedText(notes.skippedCells),
                                    droppedText(notes.droppedVertices),
                                    droppedText(notes.droppedTextureCoordinates)};
    all.insert(all.end(), notes.others.begin(), notes.others.end());
    return lineOf(path, all);
}

std::string describe(const std::filesystem::path& path, const Model& model) {
    return lineOf(path, model.notes());
}

void refuseNotes(const std::filesystem::path& path, const Model& model) {
    if (const std::string text = joined(model.notes()); !text.empty())
        throw FileError(path, "is not understood in full: " + text);
}

namespace {

using Path = std::filesystem::path;

/// Returns a format of lattices, which may be one that is only read.
/// \param use what the caller wants to do, for the message
const Format& formatOf(const Path& path, FileUse use) {
    if (const Format* format = findFormat(path, FileContent::Lattice)) return *format;
    throw FileError(path, (isFileOf(FileContent::Mesh, path)
                               ? "an OBJ file holds a mesh or a curve, not a lattice"
                               : "is not of a known lattice format") +
                              ("; expected " + listOfFormats(FileContent::Lattice, use)));
}

const Format& writableFormatOf(const Path& path) {
    const Format& format = formatOf(path, FileUse::Write);
    if (!format.writeLattice)
        throw FileError(path,
                        "a lattice cannot be written in this format, which is only read; "
                        "expected " +
                            listOfFormats(FileContent::Lattice, FileUse::Write));
    return format;
}

/// Returns a format of curves, meshes or lattices.
const Format& refinableFormatOf(const Path& path) {
    if (const Format* format = findFormat(path, FileContent::Mesh)) return *format;
    if (const Format* format = findFormat(path, FileContent::Lattice)) return *format;
    throw FileError(path, "is not of a known format of curves, meshes or lattices; expected " +
                              listOfFormats(FileContent::Mesh, FileUse::Read) + ", " +
                              listOfFormats(FileContent::Lattice, FileUse::Read));
}

Lattice readBytes(const Format& found, const Path& path, std::string_view bytes, ReadNotes* notes) {
    const LatticeReader read =
        found.readMesh ? found.readMesh
                       : formatOfFile(found, path, FileContent::Lattice, bytes).readLattice;
    return explainingContent(path, bytes, [&] { return read(path, bytes, notes); });
}

}  // namespace

Lattice readLattice(const Path& path, ReadNotes* notes) {
    const Path file = modelFile(path);
    const Format& format = formatOf(path, FileUse::Read);
    return readBytes(format, file, readModelBytes(file), notes);
}

Lattice readLattice(const Path& path, std::string_view bytes, ReadNotes* notes) {
    return readBytes(formatOf(path, FileUse::Read), path, bytes, notes);
}

void writeLattice(const Path& path, const Lattice& lattice, const WriteLatticeOptions& options) {
    writableFormatOf(path).writeLattice(path, lattice, options);
}

void checkLatticeTarget(const Path& path) {
    writableFormatOf(path);
}

Lattice readRefinable(const Path& path, ReadNotes* notes) {
    const Path file = modelFile(path);
    const Format& format = refinableFormatOf(path);
    return readBytes(format, file, readModelBytes(file), notes);
}

Lattice readRefinable(const Path& path, std::string_view bytes, ReadNotes* notes) {
    return readBytes(refinableFormatOf(path), path, bytes, notes);
}

void writeRefinable(const Path& path, const Lattice& lattice, const WriteLatticeOptions& options) {
    checkRefinableTarget(path, lattice.complex.dimension());
    if (const Format* format = findFormat(path, FileContent::Mesh, FileUse::Write))
        format->writeMesh(path, lattice);
    else
        writeLattice(path, lattice, options);
}

void checkRefinableTarget(const Path& path, int dimension) {
    if (dimension < 1 || dimension > 3)
        throw FileError(path, concat("a complex of dimension ", dimension,
                                     " cannot be written; expected a curve (1), a mesh (2) or a "
                                     "lattice (3)"));
    const FileContent content = dimension == 3 ? FileContent::Lattice : FileContent::Mesh;
    constexpr const char* kNames[] = {"a curve", "a mesh", "a lattice"};
    if (!isFileOf(content, path, FileUse::Write))
        throw FileError(
            path, concat(kNames[dimension - 1], " cannot be written in this format; expected ",
                         listOfFormats(content, FileUse::Write)));
}

}  // namespace espalier::io

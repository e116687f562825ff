// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/formats.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/matrices/matrix_file.h>
#include <espalier/io/model.h>
#include <espalier/io/read_notes.h>
#include <espalier/shapes/lattice.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <filesystem>
#include <iosfwd>
#include <memory>
#include <string>
#include <string_view>

namespace espalier::io {

struct Animation;
struct SurfaceView;

/// Reads a lattice, or a curve or a mesh, from the bytes of a file.
/// \param path for messages
/// \param notes may be null
using LatticeReader = Lattice (*)(const std::filesystem::path& path, std::string_view bytes,
                                  ReadNotes* notes);

/// A format of files: all that Espalier knows of it. A function is null if the format lacks this
/// content, or if Espalier does not read or write it.
struct Format {
    /// In lower case: ".obj". Most formats have one.
    std::array<std::string_view, 8> extensions = {};

    /// The name of the format in lists, if it has no extension: "an OpenFOAM case".
    std::string_view words = {};

    /// True for meshes of simulations: their cells are read, and only coordinates are replaced.
    bool isMesh = false;

    /// Returns true for further paths of the format.
    bool (*isPath)(const std::filesystem::path&) = nullptr;

    /// Returns true if a file is of this format, for an extension that an earlier format of the
    /// list has, too; null if the extension decides.
    bool (*isContent)(std::string_view bytes) = nullptr;

    // Models.

    /// \param format this format
    /// \param path for messages
    std::unique_ptr<Model> (*readModel)(const Format& format, const std::filesystem::path& path,
                                        std::string bytes) = nullptr;

    /// Writes a new file from points, faces and normals.
    void (*writeSurface)(std::ostream&, const SurfaceView&) = nullptr;

    /// Where a new file has normals. Facets have normals that follow from their corners.
    enum class Normals { Facets, Points, Corners } normals = Normals::Points;

    /// True if the faces of a new file are triangles.
    bool holdsTriangles = false;

    /// True if a new file is to be looked at: it has texture coordinates, colours of points and
    /// names of materials, and leaves out shapes that faces cannot describe.
    bool holdsAppearance = false;

    /// Returns true if a new file is a list of triangles in single precision, and nothing else.
    bool isFacets() const { return normals == Normals::Facets; }

    // Lattices, curves and meshes.

    LatticeReader readLattice = nullptr;
    void (*writeLattice)(const std::filesystem::path&, const Lattice&,
                         const WriteLatticeOptions&) = nullptr;
    LatticeReader readMesh = nullptr;
    void (*writeMesh)(const std::filesystem::path&, const Lattice&) = nullptr;
    bool isEditorMesh = false;

    // Matrices.

    stencils::StencilTable<double> (*readMatrix)(const std::filesystem::path&,
                                                 std::string_view bytes) = nullptr;
    void (*writeFloats)(const std::filesystem::path&, const stencils::StencilTable<float>&,
                        const MatrixFileOptions&) = nullptr;
    void (*writeDoubles)(const std::filesystem::path&, const stencils::StencilTable<double>&,
                         const MatrixFileOptions&) = nullptr;

    // Other content.

    void (*writeAnimation)(const std::filesystem::path&, const Model&, const Animation&) = nullptr;

    bool isBoundModel = false;
    bool isTargets = false;
    bool isDisplacements = false;

    /// The first extension, or the name of the file if the format has none.
    std::string_view extension() const { return extensions[0]; }

    /// Returns true if Espalier reads or writes this content in the format.
    bool holds(FileContent content, FileUse use) const;
};

// All formats. Each is defined beside its reader or writer. The list in formats.cpp needs each one,
// too.
extern const Format kOvmFormat, kObjFormat, kPlyFormat, kStlFormat, kVtuFormat, kVtpFormat,
    kVtkLegacyFormat;
extern const Format kGmshFormat, kSu2Format, kMeditFormat, kNastranFormat, kAbaqusFormat,
    kIdeasFormat, kFluentFormat, kPlot3dFormat, kFoamFormat;
extern const Format kMatrixMarketFormat, kNumpyArchiveFormat, kNumpyArraysFormat,
    kPetscBinaryFormat;
extern const Format kPointCacheFormat, kMotionDesignerFormat, kGltfFormat;
extern const Format kBoundModelFormat, kTargetsFormat, kCommaSeparatedFormat;

/// Returns the format with this content that a path names; null if there is none. (A folder "a.obj"
/// can be a case of OpenFOAM, and so a lattice.)
const Format* findFormat(const std::filesystem::path& path, FileContent content,
                         FileUse use = FileUse::Read);

/// Returns the format with this content that a file has: another one than findFormat() returned if
/// its extension belongs to several formats, and the bytes tell which.
const Format& formatOfFile(const Format& found, const std::filesystem::path& path,
                           FileContent content, std::string_view bytes);

/// Returns true if a path names this format, perhaps besides others.
bool isPathOf(const Format& format, const std::filesystem::path& path);

/// Returns true if a path names any format.
bool namesFormat(const std::filesystem::path& path);

/// Adds the format of an optional component. To be called before other threads use files.
/// \param format must live for ever
ESPALIER_API void addFormat(const Format& format);

}  // namespace espalier::io

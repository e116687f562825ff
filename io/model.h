// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/base/progress.h>
#include <espalier/far/simulation_mesh.h>
#include <espalier/io/directions.h>

#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace espalier::io {

/// The faces of a model. A face is a loop of points, by their numbers in positions().
struct ModelFaces {
    std::vector<Index> corners;     ///< the corners of all faces, one face after the other
    std::vector<std::size_t> ends;  ///< the end of the corners of each face

    std::size_t count() const { return ends.size(); }

    std::span<const Index> operator[](std::size_t face) const {
        const std::size_t begin = face == 0 ? 0 : ends[face - 1];
        return std::span(corners).subspan(begin, ends[face] - begin);
    }

    /// Ends a face, whose corners have been added.
    /// \throws as checkCancelled(), which it calls once in 4096 faces, for all who make faces
    void endFace() {
        checkCancelledEvery(ends.size(), 12);
        ends.push_back(corners.size());
    }

    /// Adds the triangles of a strip: each point but the first two ends one with the two points
    /// before it, and every second triangle is wound the other way.
    void addStrip(std::span<const Index> points) {
        for (std::size_t i = 2; i < points.size(); ++i) {
            const std::size_t odd = i % 2;
            corners.insert(corners.end(), {points[i - 2 + odd], points[i - 1 - odd], points[i]});
            endFace();
        }
    }

    /// Appends the faces of another model, whose points follow `firstPoint` other points.
    void append(const ModelFaces& others, Index firstPoint) {
        const std::size_t firstCorner = corners.size();
        for (const Index corner : others.corners) corners.push_back(firstPoint + corner);
        for (const std::size_t end : others.ends) ends.push_back(firstCorner + end);
    }

    friend bool operator==(const ModelFaces&, const ModelFaces&) = default;
};

/// The cells of a model, if it is a mesh of a simulation. Its points are positions().
///
/// The cells of `volume` are tetrahedra, pyramids, wedges and hexahedra of first and second order,
/// and polyhedra, right-handed, in the order of the file; the faces of `surface` triangles and
/// quadrilaterals of first and second order. `patches` are the patches of OpenFOAM, the markers of
/// SU2, the physical groups of Gmsh, the references of Medit, the properties of Nastran, the sets
/// and surfaces of Abaqus, the groups of I-deas, the zones of Fluent, and the boundary conditions
/// and sections of CGNS, in the order of the file. A group without a name has one of its dimension
/// and number: "surface 3", "volume 1".
struct ModelCells : far::SimulationMesh {
    /// Number of cells of a volume of third order and above, or whose order of points is not known.
    /// They are not in `volume`.
    Index curvedCells = 0;

    /// The same number for faces of surfaces, and the number of faces with more than 4 corners.
    /// They are not in `surface`.
    Index curvedFaces = 0;
    Index polygons = 0;

    /// If the file has cells of a volume: the number of triangles and quadrilaterals of surfaces
    /// that are no faces of these cells.
    Index facesBeside = 0;

    /// Number of elements of types that the reader does not know. They may be cells or not.
    Index unknownElements = 0;

    /// Of a decomposed mesh: number of faces between two parts whose points are at different places
    /// in the files of both. They count as faces of the boundary.
    Index facesApart = 0;

    /// Number of elements that boundary conditions of CGNS name, and that no section has.
    Index missingElements = 0;

    bool isOpenFoam = false;  ///< the format of the file
};

/// A number of elements of a mesh, and their name in the plural.
struct ElementCount {
    Index count;
    const char* name;
};

/// Returns the numbers of tetrahedra, pyramids, wedges, hexahedra, polyhedra, triangles and
/// quadrilaterals among the cells of a mesh, in this order, also where a number is 0.
ESPALIER_API std::vector<ElementCount> cellCounts(const far::SimulationMesh& mesh);

/// Returns the number of cells of second order.
ESPALIER_API Index secondOrderCount(const far::SimulationMesh& mesh);

/// Returns the elements of a file that are no cells of its mesh, and so in no check.
ESPALIER_API std::vector<ElementCount> uncheckedElements(const ModelCells& cells);

/// Returns the faces that only one cell of a volume has, each anticlockwise seen from outside.
/// \cost O(points of faces)
ESPALIER_API ModelFaces boundaryFaces(const far::VolumeMesh& mesh);

/// The surface of a model without its positions, and the names of all other data in its file.
struct ModelSurface {
    /// Data that are none of the members below.
    struct OtherData {
        /// The kinds of the numbers that attributes() lists.
        static constexpr const char* kPointData = "point data";
        static constexpr const char* kPointProperties = "properties of points";

        std::string kind;                ///< plural: "texture coordinates", kPointData
        std::vector<std::string> names;  ///< names of its parts, if the file has names for them
    };

    ModelFaces faces;

    /// Normals. Empty if the file has none, or if some corner of a face has none.
    std::vector<Point3> normals;

    /// Per corner of the faces: the number of its normal. Empty if the normals are one per point.
    std::vector<Index> normalCorners;

    /// Texture coordinates u and v, with v upwards, and per corner of the faces the number of its
    /// pair. Empty unless each corner has a pair. In an OBJ and in glTF, corners without texture
    /// coordinates have the pair 0 0 if other corners have some.
    std::vector<std::array<double, 2>> textures;
    std::vector<Index> textureCorners;

    /// Per point: red, green and blue as screens show them (sRGB), and the opacity, from 0 to 1.
    /// Empty if some point has no colour.
    std::vector<std::array<float, 4>> colors;

    /// Per point: the covariance xx, xy, xz, yy, yz and zz of its Gaussian splat. Empty if the
    /// points are no splats; readAppearance() reads them.
    std::vector<std::array<float, 6>> covariances;

    /// Names of materials, and per face the number of its material, or -1. Empty if no face has
    /// one. An OBJ lists the materials in the order of their first use. glTF lists all, with names
    /// that may be empty.
    std::vector<std::string> materials;
    std::vector<Index> faceMaterials;

    /// True if the points in no face are no points of the surface: they repeat a point of a face,
    /// as in an STL, or belong to a morph target.
    bool dropsLoosePoints = false;

    std::vector<OtherData> others;

    /// Replaces each face by any number of faces, whose corners are corners of the old one.
    /// \param replace function of the number of an old face that returns the new ones, each as the
    ///        positions of its corners in the loop of the old face
    void replaceFaces(
        const std::function<std::vector<std::vector<std::size_t>>(std::size_t face)>& replace);

    /// Names of shapes in the file that faces cannot describe: "27 cells of VTK's type 12
    /// (hexahedron)".
    std::vector<std::string> otherShapes;

    /// Adds a kind of data, and the name of a part of it, if it is not empty. Each kind and each
    /// name of it is listed once. \cost O(kinds + log names)
    void addOther(const std::string& kind, const std::string& name = {});

    /// Removes a name from the data of points (kPointData, kPointProperties).
    void removePointData(const std::string& name);

private:
    std::set<std::pair<std::string, std::string>> known_;  ///< kinds and names in `others`
};

/// Numbers of the normals, tangents and splats in a file, which follow a deformation by its
/// gradients.
struct DirectionCounts {
    std::size_t normals = 0;
    std::size_t tangents = 0;
    std::size_t splats = 0;  ///< Gaussian splats, with their covariances and colours

    /// Number of harmonics of each splat (f_rest_0, f_rest_1, …) if it is none of 9, 24 and 45, the
    /// numbers of the degrees 1 to 3. Such harmonics stay; otherwise 0.
    std::size_t keptHarmonics = 0;

    std::size_t count() const { return normals + tangents + splats; }
};

/// Numbers of a file, one per point, that may say how far each point follows a lattice.
struct PointAttribute {
    /// The meaning that the format gives the numbers.
    enum class Kind { Numbers, Color, TextureCoordinate };

    /// As the file has it; for one number of several, with its number behind a colon: "COLOR_0:3".
    std::string name;

    /// Reads the numbers, one per point. The model must still exist.
    /// \throws FileError if they are malformed
    std::function<std::vector<double>()> read;

    Kind kind = Kind::Numbers;
    std::size_t component = 0;  ///< of a colour: red, green, blue, opacity; or u and v of a texture
};

/// Points of a model that belong together: the points of the faces in a group.
struct PointGroup {
    std::string name;

    /// Reads the points, ascending. The model must still exist.
    /// \throws FileError if the file is malformed
    std::function<std::vector<Index>()> read;
};

/// Returns patches as groups, which hold the points.
ESPALIER_API std::vector<PointGroup> groupsOf(std::vector<far::MeshPatch> patches);

class ModelConversion;
struct Format;

/// How a file stores its coordinates: as text, which can hold any number; or rounded to a type.
enum class CoordinateStorage { Text, Float, Double, Integer };

/// A file with points that a lattice deforms. write() copies the file with new coordinates and
/// keeps all other bytes as they were read. If no point has moved, the copy is identical.
///
/// write() to a file with the extension of another model format converts the model: it writes the
/// points, the faces and, where both formats have them, the normals of the points or corners.
/// checkTarget() names the data that the new file lacks.
///
///     .obj               faces of any size; normals per corner
///     .ply               ASCII, coordinates of type double; normals per point
///     .vtp, .vtu, .vtk   polygons, coordinates of type double; normals per point
///     .glb, .gltf        as glTF 2.0 (io/gltf/gltf_writer.h), with texture coordinates, colours
///     and
///                        materials
///     .stl               binary, coordinates rounded to floats; faces are split into triangles,
///                        the same for all positions
///
/// The points keep their numbers, except that equal corners of an STL become one point. A model
/// with shapes that faces cannot describe, such as the cells of a volume, is not converted.
///
/// Directions at the points, that is normals, tangents and splats, are kept as well, unless write()
/// is given a deformation gradient per point. docs/file-formats.md says which numbers of a file are
/// directions; the source of each format says it in full (io/models/obj.cpp).
///
/// The model keeps its converted surface, so that several poses in one other format convert it
/// once.
///
/// Models are immutable, and so safe to share between threads.
class ESPALIER_API Model {
public:
    virtual ~Model() = default;
    Model(const Model&) = delete;
    Model& operator=(const Model&) = delete;

    /// The points in the order of the file; all are finite. If the file has points that are not, in
    /// no face and no cell (or only together with others that are not finite), the first finite
    /// point stands in for them here and in files of other formats. write() keeps their bytes
    /// wherever they are moved, and notes() counts them.
    virtual std::span<const Point3> positions() const = 0;

    /// The points, ascending, for which the first finite one stands in in positions().
    virtual std::vector<Index> heldPoints() const { return {}; }

    /// Reads the surface from the file, which the model keeps; the result is not stored, so that a
    /// model whose surface nobody asks for costs no memory for it.
    ///
    /// In an STL, corners at equal positions are one point: the first of them.
    ///
    /// \throws FileError if a face is malformed, or names a point that does not exist
    /// \cost one pass over the file; O(n log n) for an STL
    virtual ModelSurface readSurface() const = 0;

    /// Reads the cells of a mesh from the file, or from the files beside it. The result is not
    /// stored. It has no cells if the format is none of a mesh, or the file has none.
    ///
    /// Cells are right-handed: if most cells of a kind have a negative volume, all cells of this
    /// kind are turned, and each polyhedron is turned so that its volume is positive. (In
    /// OpenFOAM's format nothing is turned, since owners and neighbours determine the outside.)
    ///
    /// \throws FileError if a cell is malformed, or names a point that does not exist
    /// \cost one pass over the file, and far::VolumeMeshBuilder::build()
    virtual ModelCells readCells() const { return {}; }

    /// Returns the numbers at the points that can be read: properties of a PLY, arrays of VTK's
    /// point data, attributes of glTF, and the colours of an OBJ. Colours in bytes are divided by
    /// 255: red, green, blue and alpha of a PLY; arrays of 3 or 4 bytes for each point in VTK's
    /// files; and normalized integers of glTF, as the file says.
    virtual std::vector<PointAttribute> attributes() const { return {}; }

    /// Returns the groups, objects and materials of an OBJ, the meshes, nodes and materials of
    /// glTF, and the patches of a mesh, in the order of the file. Parts of one name are one group.
    /// \throws FileError as readSurface()
    /// \cost one pass over the file; and one for each group that is read
    virtual std::vector<PointGroup> groups() const { return {}; }

    /// Returns the faces along which weights of points have slopes: the faces of the surface. In
    /// glTF each morph target has the same faces again, with its own points.
    ///
    /// \param shapes gets the shape of each point, 0 for the surface and n for morph target n; or
    ///        stays empty, if there is one shape only
    virtual ModelFaces facesOfShapes([[maybe_unused]] std::vector<Index>& shapes) const {
        return readSurface().faces;
    }

    /// Returns notes on parts of the file that were skipped, or are kept without being understood;
    /// none for most files. Each note is a phrase with a number: "kept 3 lines whose first word no
    /// OBJ has ("foo" in line 7)". describe() makes one line of them, and refuseNotes() an error
    /// (read_notes.h).
    virtual std::vector<std::string> notes() const { return {}; }

    /// How the file stores the coordinates. If parts of a file differ, the least precise of them.
    virtual CoordinateStorage storage() const = 0;

    /// Returns points, one per point of the model, as a file that write() makes in the format of
    /// the model holds them: where it has single precision, rounded to the nearest float, which is
    /// infinite for a coordinate that write() refuses; in fields of a fixed width, rounded to the
    /// digits that fit. Other formats of text and doubles change nothing.
    virtual std::vector<Point3> stored(std::vector<Point3> points) const;

    /// Extension of the file in lower case: ".obj"; "points" for OpenFOAM, whose file has this
    /// name.
    std::string_view extension() const { return extension_; }

    const Format& format() const { return format_; }

    /// Returns how many directions the file has that write() can carry by gradients. The normals of
    /// an STL do not count: they always follow the points.
    virtual DirectionCounts directions() const = 0;
    bool hasDirections() const { return directions().count() > 0; }

    /// Checks a name for write() without touching the file, so that a wrong name is refused before
    /// long work.
    ///
    /// \return one line for the user, or nothing. It names the data of the model that a file in
    ///         another format lacks, and the changes ("a.stl: ...; 6 faces are split into 12
    ///         triangles"). For a name without extension ("/dev/stdout"), or with the number of a
    ///         pose instead ("a.0001"), the model is written in its own format. In this format,
    ///         there is a line only if fields of a fixed width round the coordinates (Nastran)
    /// \throws FileError if the extension belongs to no model format ("a.gltf"); if it belongs to
    ///         another one to which this model cannot be converted, with the reason; if the points
    ///         of an OpenFOAM mesh would get another name, or replace the points of another mesh
    /// \cost if the format is another one, the cost of readSurface() and of splitting faces. The
    ///       result stays in memory: the same call is free the next time
    std::string checkTarget(const std::filesystem::path& path) const;

    /// Writes the model with new positions, one per point, in its own format or in the one that the
    /// extension of `path` names.
    ///
    /// A format with single-precision numbers rounds them. An existing file is replaced when all is
    /// written (see writeFile).
    ///
    /// \throws Error unless there is one position for each of positions(), finite and not too large
    ///         for the format; FileError if checkTarget() refuses the path, or the file
    ///         cannot be written
    /// \cost one pass over the file; for another format also the cost of checkTarget()
    void write(const std::filesystem::path& path, std::span<const Point3> positions) const;

    /// Writes the model as above, and carries the directions at each point by its gradient: normals
    /// by carryNormal(), tangents by carryTangent(), splats by their covariances
    /// (io/models/splats.h). Directions keep their lengths, except for the rounding of the format.
    /// If all gradients are the identity and no point has moved, the copy is identical. Three
    /// numbers that are no direction, such as 0 0 0 or NaN, stay as they are.
    ///
    /// \param gradients one per point
    /// \throws Error unless there is one position for each of positions(), finite and not too large
    ///         for the format, and one finite gradient per point; FileError if checkTarget()
    ///         refuses the path, or the file cannot be written
    void write(const std::filesystem::path& path, std::span<const Point3> positions,
               std::span<const DeformationGradient> gradients) const;

protected:
    /// \param format must outlive the model
    /// \param path of the file that was read
    Model(const Format& format, const std::filesystem::path& path);

private:
    void writeInFormat(const std::filesystem::path& path, std::span<const Point3> positions,
                       std::span<const DeformationGradient> gradients) const;

    /// Returns the conversion to another format. Keeps the last one for later calls.
    std::shared_ptr<const ModelConversion> conversionTo(const Format& format,
                                                        const std::filesystem::path& path) const;

    void checkExtension(const std::filesystem::path& path) const;

    /// Throws unless the model may be written to a file in its own format.
    virtual void checkOwnTarget(const std::filesystem::path&) const {}

    /// Returns what a file in the own format of the model loses, as a phrase; empty if nothing.
    virtual std::string ownLosses() const { return {}; }

    /// Writes the model in its own format.
    /// \param gradients one per point; or empty, and the directions stay
    virtual void writeChecked(const std::filesystem::path& path, std::span<const Point3> positions,
                              std::span<const DeformationGradient> gradients) const = 0;

    const Format& format_;
    std::string_view extension_;
    mutable std::mutex conversionMutex_;
    mutable std::shared_ptr<const ModelConversion> conversion_;
};

/// Adds colours and texture coordinates that the file has as attributes of the points (PLY, VTK) to
/// a surface that readSurface() returned without them, and removes them from its other data. Adds
/// the covariances of splats, and the colours that they have without harmonics.
/// \throws FileError if the numbers are malformed
/// \cost one pass over the file for each component
ESPALIER_API void readAppearance(const Model& model, ModelSurface& surface);

/// Returns the file that a path of a model means: the points of OpenFOAM for a folder
/// (meshes/openfoam.h), and the path itself otherwise, also for the folder of a decomposed case.
/// readModel() does this, too.
/// \throws FileError if a folder has no mesh of OpenFOAM, or if there is no file or folder of a
///         name that is of no known format, and so may have been meant as a folder
ESPALIER_API std::filesystem::path modelFile(const std::filesystem::path& path);

/// Returns the files that hold a model: one; of a decomposed case of OpenFOAM the points of all its
/// parts.
/// \throws FileError as modelFile()
ESPALIER_API std::vector<std::filesystem::path> modelFiles(const std::filesystem::path& path);

/// Returns the files that Model::write() writes for a path: likewise the points for a folder.
/// \throws FileError if a folder has no mesh of OpenFOAM
ESPALIER_API std::vector<std::filesystem::path> modelTargets(const std::filesystem::path& path);

/// Reads the bytes of a model: of its file; of a decomposed case one archive of its files.
/// \param path a result of modelFile()
/// \throws FileError if a file cannot be read
ESPALIER_API std::string readModelBytes(const std::filesystem::path& path);

/// Returns a name by which readModel() knows the format of these bytes without their folders: the
/// name of the file.
/// \param path a result of modelFile()
ESPALIER_API std::string modelName(const std::filesystem::path& path);

/// Checks a model whose points are wanted themselves, as the vertices of a pose or as targets: no
/// other point can stand in for them.
/// \param path of the model
/// \throws FileError if the model has heldPoints()
ESPALIER_API void refuseHeldPoints(const std::filesystem::path& path, const Model& model);

/// Reads a model in the format that its extension names, in upper or lower case.
/// \throws FileError if the extension is not known, if the file cannot be read or is malformed
///         (naming the line, or the byte in binary data), if a point that is not finite is in a
///         face or a cell with finite ones, or if it has no points
ESPALIER_API std::unique_ptr<Model> readModel(const std::filesystem::path& path);

/// The same for a file that is in memory already.
/// \param path names the format, and the file in messages
/// \param bytes the whole file; or the archive that readModelBytes() returns
ESPALIER_API std::unique_ptr<Model> readModel(const std::filesystem::path& path, std::string bytes);

}  // namespace espalier::io

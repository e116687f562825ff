// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/base/word.h>
#include <espalier/shapes/lattice.h>

#include <array>
#include <cstddef>
#include <span>
#include <string>

// cages/ makes lattices that follow the shape of a model, and collars around lattices.
//
// cage() takes the faces of a model and returns a Lattice. Inside, the steps are files:
// model_surface.h makes one surface of the faces, model_voxels.h finds the solid, grid_cells.h
// chooses cells of a grid with the topology of the solid, and fit_cage.h moves their vertices until
// the boundary follows the model, and proves the result. cage.cpp searches for the size and place
// of the grid. docs/cages.md describes the methods and has measured results.
//
// collar() (collar.h) adds cells around a lattice: collar_grid.h around a box, collar_extrusion.h
// around others; untangle.h removes folds.
namespace espalier::cages {

/// The faces of a model: any polygons, in any order, wound in any way. They may intersect, leave
/// gaps, or occur several times.
struct SurfaceModel {
    std::span<const Point3> points;
    std::span<const Index> corners;     ///< the corners of all faces, one face after the other
    std::span<const std::size_t> ends;  ///< the end of the corners of each face
};

/// The planes about which a cage is symmetric. They are across the coordinate axes.
enum class Symmetric {
    Auto,  ///< all planes about which the model is symmetric
    None,
    X,  ///< the plane across x, whatever the model is like
    Y,
    Z,
    XY,  ///< two planes
    XZ,
    YZ,
    XYZ
};
inline constexpr Word<Symmetric> kSymmetricWords[] = {
    {"auto", Symmetric::Auto}, {"none", Symmetric::None}, {"x", Symmetric::X},
    {"y", Symmetric::Y},       {"z", Symmetric::Z},       {"xy", Symmetric::XY},
    {"xz", Symmetric::XZ},     {"yz", Symmetric::YZ},     {"xyz", Symmetric::XYZ}};

struct CageOptions {
    /// Number of vertices of the lattice, 8 to 100,000. The result has between 0.8 and 1.2 times as
    /// many. Not used if `cellSize` is set.
    Index vertices = 200;

    /// Edge of the cells before they are fitted, in the units of the model, above 0; 0: not set.
    double cellSize = 0;

    /// Least distance between the model and the boundary of the limit volume, as a fraction of the
    /// diagonal of the smallest box with sides along the axes that holds the model: 0 to 1.
    double margin = 0;

    /// Above 0: the lattice is made around the surface only, and contains all points within half of
    /// this distance, in the units of the model, at most twice the diagonal of the model. 0: around
    /// the solid.
    double shell = 0;

    /// True: parts of the model that are nearer to each other than a cell stay separate. Parts
    /// that are further apart than two cells are separate in any case.
    bool keepApart = false;

    /// The planes about which the lattice is symmetric.
    Symmetric symmetric = Symmetric::Auto;

    /// Largest distance of the mirror image of a point from the nearest point of a model that
    /// counts as symmetric, as a fraction of the diagonal of the model: 0 to 1. Coordinates in
    /// files are rounded, so it is more than 0.
    double symmetry = 1e-4;
};

/// The symmetry of a model, and the planes that cage() used.
struct ModelSymmetry {
    struct Plane {
        double at = 0;  ///< the coordinate of the plane: the middle of the box around the model

        /// Largest distance of the mirror image of a point from the nearest point of the model, as
        /// a fraction of the diagonal. An estimate if the model is not symmetric about the plane.
        double off = 0;

        bool isOfModel = false;  ///< true: `off` is at most CageOptions::symmetry
        bool isUsed = false;     ///< true: the lattice is symmetric about the plane
    };
    std::array<Plane, 3> planes;  ///< the planes across x, y and z
    bool isMeasured = false;      ///< false: CageOptions::symmetric is Symmetric::None
};

/// Describes the symmetry of a cage in one line: "symmetric about x = 0 within 2e-7 of the
/// diagonal; off by 3 % about y, 12 % about z".
/// \return an empty text if it was not measured
ESPALIER_API std::string symmetryText(const ModelSymmetry& symmetry);

/// Makes a lattice of hexahedra that follows the shape of a model.
///
/// The *solid* is the space inside the closed pieces of the surface, by their winding numbers, and
/// the space that open pieces enclose except for gaps narrower than half a cell. Where there is no
/// solid, as at a sheet, the lattice is made around the surface.
///
/// The result is proved (fit_cage.h):
/// - every point of the model is inside the limit volume and inside level 3. Faces are sampled at
///   an eighth of a cell, or up to twice as far apart where so many overlap that there would be
///   millions of samples (docs/cages.md);
/// - every patch of the limit volume has a positive Jacobian.
///
/// If the model is symmetric, as CageOptions::symmetric says, the lattice is exactly symmetric:
/// each vertex has a vertex at the mirrored coordinates, and each cell has a mirrored cell.
/// Vertices that are their own images are exactly on the plane. By default, a lattice that cannot
/// be fitted with all planes is tried with one of them, then without.
///
/// The lattice has the connected parts, handles and cavities of the model at the scale of its
/// cells; its boundary is a manifold, without marks. The result has the same bits for any number of
/// threads, and for the same model with its faces and points in another order, with duplicates that
/// are wound the same way, with faces that start at another corner, or with all faces turned
/// around.
///
/// \param symmetry gets the symmetry of the model and of the lattice, if it is not null
/// \throws ArgumentError for an option out of range; Error if there are no faces, a face names a
///         point that does not exist, a point is not finite or beyond ±1e90, the diagonal of the
///         model is not between 1e-40 and 1e40, or a coordinate is beyond 1e8 diagonals; if no
///         lattice of about this size can be fitted, which happens for tangled models and few
///         vertices; if none is proved within a limit on the work, which is counted and does not
///         depend on the machine
/// \cost on one thread about 4 s for 100,000 triangles and 500 vertices, 19 s and 1.04 GB for 1.7
///       million triangles. Grows with the number of vertices; docs/cages.md has times
ESPALIER_API Lattice cage(const SurfaceModel& model, const CageOptions& options = {},
                          ModelSymmetry* symmetry = nullptr);

}  // namespace espalier::cages

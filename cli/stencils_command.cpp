// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/printable.h>
#include <espalier/embed/basis_functions.h>
#include <espalier/io/files/file.h>
#include <espalier/io/matrices/matrix_file.h>
#include <espalier/io/matrices/matrix_market.h>
#include <espalier/io/model.h>
#include <espalier/io/numbered_path.h>
#include <espalier/stencils/composition.h>
#include <fmt/format.h>

#include <algorithm>

#include "bind_model.h"
#include "commands.h"
#include "files.h"
#include "job.h"

namespace espalier::cli {
namespace {

struct StencilsOptions : LatticeOptions {
    std::string points;
    BindOptions bind;  ///< the command uses --basis, --limit and the part of the model only
    bool gradients = false;
    bool levelTables = false;
    io::PetscInt petscIntegers = io::PetscInt::Bits32;
    std::string output;
};

constexpr Word<io::PetscInt> kPetscIntWords[] = {{"32", io::PetscInt::Bits32},
                                                 {"64", io::PetscInt::Bits64}};

/// A matrix, its file, and a description of its rows and columns.
struct Export {
    std::filesystem::path path;
    stencils::StencilTable<double> table;
    std::string description;
};

std::filesystem::path levelPath(const StencilsOptions& options, int k) {
    return io::numberedPath(options.output, k, options.level);
}

/// Returns the file of the gradients with respect to coordinate `axis` at rest: D.dx.npz for D.npz
/// and axis 0.
std::filesystem::path gradientPath(const StencilsOptions& options, std::size_t axis) {
    std::filesystem::path path = options.output;
    const std::string extension = path.extension().string();
    return path.replace_extension(fmt::format(".d{}{}", "xyz"[axis], extension));
}

/// Returns the files of all matrices.
std::vector<std::filesystem::path> matrixPaths(const StencilsOptions& options) {
    if (options.levelTables) {
        std::vector<std::filesystem::path> paths;
        for (int k = 1; k <= options.level; ++k) paths.push_back(levelPath(options, k));
        return paths;
    }
    std::vector<std::filesystem::path> paths = {options.output};
    for (std::size_t axis = 0; options.gradients && axis < 3; ++axis)
        paths.push_back(gradientPath(options, axis));
    return paths;
}

/// Returns the name of D for comments in files: "D at level 3".
std::string nameOfD(const StencilsOptions& options) {
    if (options.bind.basis == embed::Basis::Bezier) return "D of the Bézier volume";
    if (options.bind.basis == embed::Basis::BSpline) return "D of the uniform cubic B-splines";
    if (options.bind.limit) return "D in the limit";
    return fmt::format("D at level {}", options.level);
}

/// Returns the options for binding the points.
BindOptions bindOptions(const StencilsOptions& options) {
    BindOptions bind = options.bind;
    bind.common = options.common;
    bind.model = options.points;
    bind.rest = options.lattice;
    bind.level = options.level;
    return bind;
}

/// Returns D, and its gradients if they were asked for.
std::vector<Export> deformation(const StencilsOptions& options, Stages& stages) {
    const auto model = readModel(options.points, options.common, stages);
    const Lattice lattice = readLattice(options.lattice, stages);
    bind::Binding bound =
        bindModel(bindOptions(options), *model, lattice, stages, options.gradients);
    warnOfPointsOutside(bind::statisticsOf(bound), options.common);
    embed::GradientTables gradients;
    if (bound.gradients) gradients = bind::gradientTables(bound);
    const std::string rowsAndColumns = fmt::format(
        "rows are the points of {}, in the order of the file, and "
        "empty where a point stays in place; columns are the vertices of {}",
        printable(options.points), printable(options.lattice));
    std::vector<Export> result;
    result.push_back({options.output, std::move(bound.table),
                      fmt::format("{}: {}", nameOfD(options), rowsAndColumns)});
    for (std::size_t axis = 0; bound.gradients && axis < 3; ++axis)
        result.push_back(
            {gradientPath(options, axis), std::move(gradients[axis]),
             fmt::format("Gradient of D: its product with a pose is column {} of the "
                         "deformation gradient, the derivative by {} of the rest pose; {}",
                         axis, "xyz"[axis], rowsAndColumns)});
    return result;
}

std::vector<Export> exports(const StencilsOptions& options, Stages& stages) {
    if (!options.points.empty()) return deformation(options, stages);
    std::vector<Export> result;
    const auto refiner = readAndRefine(options, FileKind::Refinable, stages).second;
    if (!options.levelTables) {
        auto table =
            stages.run("building", [&] { return stencils::buildStencils(refiner, options.level); });
        result.push_back(
            {options.output, std::move(table),
             fmt::format("S_{} of {}: rows are the vertices of level {}, in the order of espalier "
                         "refine; columns are the vertices of the file",
                         options.level, printable(options.lattice), options.level)});
        return result;
    }
    auto tables =
        stages.run("building", [&] { return stencils::buildLevelTables(refiner, options.level); });
    for (int k = 1; k <= options.level; ++k)
        result.push_back({levelPath(options, k), std::move(tables[k - 1]),
                          fmt::format("R_{} of {}: rows are the vertices of level {}, columns the "
                                      "vertices of level {}, in the order of espalier refine",
                                      k, printable(options.lattice), k, k - 1)});
    return result;
}

/// Returns the names of the files of a matrix, for the output of the command.
std::string namesOf(const std::filesystem::path& path) {
    std::vector<std::string> names;
    for (const auto& each : io::matrixPaths(path)) names.push_back(io::shownPath(each));
    return fmt::format("{}", fmt::join(names, ", "));
}

void write(const Export& matrix, const StencilsOptions& options) {
    const io::MatrixFileOptions format{{matrix.description}, options.petscIntegers};
    // Devices and pipes have no extension that tells the format: they get Matrix Market.
    if (!io::isFileOf(io::FileContent::Matrix, matrix.path, io::FileUse::Write))
        io::writeMatrixMarket(matrix.path, matrix.table, format.comments);
    else
        io::writeMatrix(matrix.path, matrix.table, format);
}

void runStencils(const StencilsOptions& options) {
    checkBasis(options.bind);
    Job job(options.common, {{"LATTICE", options.lattice}, {"--points", options.points}});
    if (options.levelTables && options.level == 0)
        throw CLI::ValidationError("--level-tables",
                                   "there are no level tables before level 1; use -n 1 or more");
    for (const std::filesystem::path& output : matrixPaths(options)) {
        const auto files = io::matrixPaths(output);
        for (const auto& path : files)
            job.writes(path, path == files.front()
                                 ? io::extensionsOf(io::FileContent::Matrix, io::FileUse::Write)
                                 : std::vector<std::string>());
    }
    Stages& stages = job.stages();
    for (const Export& matrix : exports(options, stages)) {
        stages.run("writing", [&] { write(matrix, options); });
        if (!options.common.quiet)
            fmt::print("{}: {} × {}, {} entries\n", namesOf(matrix.path), matrix.table.rowCount(),
                       matrix.table.columnCount(), matrix.table.entryCount());
    }
}

}  // namespace

void addStencilsCommand(CLI::App& program) {
    const auto [command, options] =
        addCommand(program, "stencils",
                   "Write the sparse matrix that refines a lattice, mesh "
                   "or curve, or the one that deforms a model",
                   runStencils);
    addLatticeOptions(command, FileKind::Refinable, options);
    addStrictOption(command, options.common);
    CLI::Option* const points = command.add_option(
        "--points", options.points,
        "A model: write D, the matrix that deforms its points (points × lattice vertices), instead "
        "of "
        "S_N, the matrix of level N (vertices of level N × vertices of the input)");
    const auto others = static_cast<std::ptrdiff_t>(command.get_options().size());
    addBasisOptions(command, options.bind);
    addEmbeddingOptions(command, options.common);
    addPartOptions(command, options.bind.part, options.common);
    command.add_flag(
        "--gradients", options.gradients,
        "Also write the gradients of D, to D.dx.npz, D.dy.npz and D.dz.npz beside D.npz: "
        "their products with a pose are the columns of the deformation gradient");
    const auto all = command.get_options();
    for (auto option = all.begin() + others; option != all.end(); ++option)
        (*option)->needs(points);
    command
        .add_flag(
            "--level-tables", options.levelTables,
            "Write the matrices R_1 to R_N, each from one level to the next, to numbered files")
        ->excludes(points);
    addOutputOption(
        command, options.output,
        "The matrix: Matrix Market (.mtx), SciPy's archive (.npz), the same arrays in three "
        "files (.npy), or PETSc's binary format (.petsc)")
        ->required();
    addChoice<io::PetscInt>(
        command, "--petsc-indices", options.petscIntegers, kPetscIntWords,
        "Bits of an index in the build of PETSc that will read the .petsc file");
}

}  // namespace espalier::cli

// SPDX-License-Identifier: Apache-2.0
#include "files.h"

#include <espalier/io/files/file.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <espalier/io/pose_file.h>
#include <espalier/shapes/refiner_options.h>
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "standard_streams.h"

namespace espalier::cli {

far::TopologyRefiner refineLattice(const std::filesystem::path& path, const Lattice& lattice,
                                   const CommonOptions& options, int level) {
    return ofFile(path, [&] {
        far::TopologyRefiner refiner(
            lattice.complex,
            refinerOptions(lattice, options.refinement, options.sharpEdges, options.rules));
        refiner.refineUniform(level);
        return refiner;
    });
}

Lattice readLattice(const std::filesystem::path& path, Stages& stages, FileKind kind) {
    io::ReadNotes notes;
    Lattice lattice = stages.read(path, [&] {
        return kind == FileKind::Refinable ? io::readRefinable(path, &notes)
                                           : io::readLattice(path, &notes);
    });
    printNotes(path, notes);
    return lattice;
}

std::unique_ptr<io::Model> readModel(const std::string& path, const CommonOptions& common,
                                     Stages& stages) {
    auto model = stages.read(path, [&] { return io::readModel(path); });
    tellNotes(path, *model, common);
    return model;
}

void tellNotes(const std::filesystem::path& path, const io::Model& model,
               const CommonOptions& common) {
    if (common.strict) io::refuseNotes(path, model);
    if (const std::string text = io::describe(path, model); !text.empty()) printError(text.c_str());
}

std::pair<Lattice, far::TopologyRefiner> readAndRefine(const LatticeOptions& options, FileKind kind,
                                                       Stages& stages) {
    Lattice lattice = readLattice(options.lattice, stages, kind);
    auto refiner = stages.run("refining", [&] {
        return refineLattice(options.lattice, lattice, options.common, options.level);
    });
    return {std::move(lattice), std::move(refiner)};
}

void printNotes(const std::filesystem::path& path, const io::ReadNotes& notes) {
    if (const std::string text = io::describe(path, notes); !text.empty()) printError(text.c_str());
}

std::vector<std::vector<Point3>> readPoses(
    const std::vector<std::string>& paths,
    const std::function<std::vector<Point3>(const std::string& path, io::ReadNotes* notes)>& read,
    Stages& stages) {
    std::vector<std::vector<Point3>> poses;
    io::ReadNotes before;
    for (const std::string& path : paths) {
        io::ReadNotes notes;
        poses.push_back(stages.read(path, [&] { return read(path, &notes); }));
        if (notes != before) printNotes(path, notes);
        before = std::move(notes);
    }
    return poses;
}

std::vector<std::vector<Point3>> readPoses(const std::vector<std::string>& paths,
                                           const Lattice& rest, const std::string& restPath,
                                           Stages& stages) {
    const auto read = [&](const std::string& path, io::ReadNotes* notes) {
        return io::readPose(path, rest, io::shownPath(restPath), notes);
    };
    return readPoses(paths, read, stages);
}

}  // namespace espalier::cli

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/memory.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/io/files/file.h>
#include <espalier/io/model.h>
#include <espalier/io/read_notes.h>
#include <espalier/shapes/lattice.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "options.h"
#include "run.h"

namespace espalier::cli {

/// Plural names of the entities, by dimension.
inline constexpr const char* kNamesOfParts[] = {"vertices", "edges", "faces", "cells"};

/// Refines a lattice or a mesh that was read from `path`. The options override the tags of the
/// file, and the tags override the defaults. Errors name the file.
far::TopologyRefiner refineLattice(const std::filesystem::path& path, const Lattice& lattice,
                                   const CommonOptions& options, int level);

/// Reads a file of this kind in the stage "reading", and prints the notes of its reader to standard
/// error.
Lattice readLattice(const std::filesystem::path& path, Stages& stages,
                    FileKind kind = FileKind::Lattice);

/// Reads a model in the stage "reading", and tells its notes.
std::unique_ptr<io::Model> readModel(const std::string& path, const CommonOptions& common,
                                     Stages& stages);

/// Prints the notes on a model as printNotes() does. With --strict they are an error.
/// \throws FileError
void tellNotes(const std::filesystem::path& path, const io::Model& model,
               const CommonOptions& common);

/// Reads the lattice, mesh or curve that a command names, and refines it to the level that the
/// command asks for.
std::pair<Lattice, far::TopologyRefiner> readAndRefine(const LatticeOptions& options, FileKind kind,
                                                       Stages& stages);

/// Runs `work`, and adds the name of the file to its errors, except those that are about an option.
template <class Work>
auto ofFile(const std::filesystem::path& path, const Work& work) {
    try {
        return work();
    } catch (const io::FileError&) {
        throw;
    } catch (const ArgumentError&) {
        throw;
    } catch (const MemoryError& error) {
        throw MemoryError(io::shownPath(path) + ": " + error.what());
    } catch (const Error& error) {
        throw io::FileError(path, error.what());
    }
}

/// Prints the notes on a file to standard error, in one line; nothing if there are none. To be
/// called between stages, so that the line of progress is empty.
void printNotes(const std::filesystem::path& path, const io::ReadNotes& notes);

/// Reads all poses of a lattice, each in the stage "reading". A command reads them before it uses
/// one, so that a bad pose leaves nothing half done. If consecutive poses have the same notes, only
/// the notes of the first are printed.
///
/// \param read returns the positions of a pose (io/pose_file.h)
/// \throws FileError naming the file that is not a pose, and the difference
std::vector<std::vector<Point3>> readPoses(
    const std::vector<std::string>& paths,
    const std::function<std::vector<Point3>(const std::string& path, io::ReadNotes* notes)>& read,
    Stages& stages);

/// Reads poses of the lattice `rest`, which was read from `restPath`.
std::vector<std::vector<Point3>> readPoses(const std::vector<std::string>& paths,
                                           const Lattice& rest, const std::string& restPath,
                                           Stages& stages);

}  // namespace espalier::cli

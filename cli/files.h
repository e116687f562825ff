// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/memory.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/io/files/file.h>
#include <espalier/io/read_notes.h>
#include <espalier/shapes/lattice.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "options.h"
#include "run.h"

namespace espalier::cli {

/// The names of the entities of a lattice, by dimension.
inline constexpr const char* kNamesOfParts[] = {"vertices", "edges", "faces", "cells"};

/// Refines a lattice or a mesh that was read from `path`, as the options, its tags and the defaults
/// say, in this order. Errors name the file.
far::TopologyRefiner refineLattice(const std::filesystem::path& path, const Lattice& lattice,
                                   const CommonOptions& options, int level);

/// A file that a command reads, and the argument that names it: "MODEL", "--rest".
struct Input {
    std::string argument;
    std::string path;
};

/// Several files of one argument.
std::vector<Input> inputsOf(const std::string& argument, const std::vector<std::string>& paths);

/// Refuses two inputs that are the same pipe or device: the second would wait for ever for what the
/// first has read. Refuses "-", unless it is a file: a name has to tell the format.
/// \throws FileError naming the file and the arguments
void checkInputs(const std::vector<Input>& inputs);

/// Refuses an output that would replace one of the inputs, or is the same pipe, whose folder does
/// not exist, or that must not be written to, before any work is done. With `extensions` (".mtx"),
/// also one of another extension; devices and pipes may have any. \throws FileError
void checkOutput(const std::filesystem::path& output, const std::vector<Input>& inputs,
                 const std::vector<std::string>& extensions = {});

/// Refuses outputs of one command that are one file, by way of links: all but the last written
/// would be lost. Devices and pipes may take several outputs.
/// \throws io::FileError naming two such outputs
void checkDistinct(const std::vector<std::filesystem::path>& outputs);

/// Reads a file of this kind in the stage "reading", and prints the notes of its reader.
Lattice readLattice(const std::filesystem::path& path, Stages& stages,
                    FileKind kind = FileKind::Lattice);

/// Reads the lattice, mesh or curve that a command names, and refines it to the level that the
/// command asks for.
std::pair<Lattice, far::TopologyRefiner> readAndRefine(const LatticeOptions& options, FileKind kind,
                                                       Stages& stages);

/// Errors of what `work` makes of a file name it.
template <class Work>
auto ofFile(const std::filesystem::path& path, const Work& work) {
    try {
        return work();
    } catch (const io::FileError&) {
        throw;
    } catch (const MemoryError& error) {
        throw MemoryError(io::shownPath(path) + ": " + error.what());
    } catch (const Error& error) {
        throw io::FileError(path, error.what());
    }
}

/// Prints the notes on a file on standard error, in one line; nothing if there are none. To be
/// called between stages.
void printNotes(const std::filesystem::path& path, const io::ReadNotes& notes);

/// Reads poses of one lattice, each in the stage "reading", before any is used: a bad one leaves
/// nothing half done. If consecutive poses have the same notes, only the notes of the first are
/// printed.
///
/// \param difference what a lattice is no pose of, and why; nothing if it is a pose
/// \throws FileError naming a file that is no pose, and the difference
std::vector<std::vector<Point3>> readPoses(
    const std::vector<std::string>& paths,
    const std::function<std::optional<std::string>(const Lattice&)>& difference, Stages& stages);

/// The same for poses of the lattice `rest` that was read from `restPath`.
std::vector<std::vector<Point3>> readPoses(const std::vector<std::string>& paths,
                                           const Lattice& rest, const std::string& restPath,
                                           Stages& stages);

}  // namespace espalier::cli

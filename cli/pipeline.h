// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/memory.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/io/files/file.h>
#include <espalier/io/model.h>
#include <espalier/io/read_notes.h>
#include <espalier/shapes/lattice.h>

#include <filesystem>
#include <memory>
#include <string>
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

/// Reads a model in the stage "reading".
std::unique_ptr<io::Model> readModel(const std::filesystem::path& path, Stages& stages);

/// Reads a file of this kind in the stage "reading", and prints the notes of its reader.
Lattice readLattice(const std::filesystem::path& path, Stages& stages,
                    FileKind kind = FileKind::Lattice);

/// A lattice and its refinement.
struct RefinedFile {
    Lattice lattice;
    far::TopologyRefiner refiner;
};

/// Reads the lattice, mesh or curve that a command names, and refines it to the level that the
/// command asks for.
RefinedFile readAndRefine(const LatticeOptions& options, FileKind kind, Stages& stages);

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

/// Says on standard error, in one line per attribute, how many values of a lattice that was read
/// from `path` are not finite, and where the first stands. To be called between stages.
void warnOfNonFinite(const std::filesystem::path& path, const Lattice& lattice);

/// A level as a lattice of its own, with the positions and the attributes of a base lattice,
/// refined.
Lattice refinedLattice(const far::TopologyRefiner& refiner, int level, const CommonOptions& options,
                       const Lattice& base);

/// Reads a pose of the lattice `rest` that was read from `restPath`.
/// \param notes gets the notes on the file, to be printed after the stage
/// \throws Error saying what differs if its topology is another
std::vector<Point3> readPose(const std::filesystem::path& path, const Lattice& rest,
                             const std::filesystem::path& restPath, io::ReadNotes& notes);

}  // namespace espalier::cli

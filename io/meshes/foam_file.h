// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/far/incidence.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mesh_format.h"

// Reads single files of OpenFOAM: a header, and lists.

namespace espalier::io {

/// A patch of the boundary: the faces from `startFace` on.
struct FoamPatch {
    std::string name, type;
    std::string neighbourPatch;  ///< of a cyclic patch: its partner
    std::string referPatch;      ///< of a processorCyclic patch: the cyclic patch of its faces
    Index faceCount = 0;
    Index startFace = 0;
    std::optional<Index> neighbour = {};  ///< of a processor patch: the other process
};

/// The file of one process in a collated file, and the text of its size before it.
struct FoamBlock {
    std::size_t sizeBegin, sizeEnd;
    std::size_t begin, end;
    std::size_t line;  ///< of its begin
};

/// Reads a file of OpenFOAM in the order of its text. All functions throw FileError with the line.
class FoamFile {
public:
    /// Reads the header.
    /// \param path, bytes must outlive this
    FoamFile(const std::filesystem::path& path, std::string_view bytes);

    /// The same for a block of a collated file. Only the first block has a header.
    /// \param line of its first byte
    /// \param before the first block, or for this the collated file
    FoamFile(std::string_view block, std::size_t line, const FoamFile& before);

    /// The class that the header names: "vectorField".
    const std::string& className() const { return className_; }

    /// Returns true for a file with the files of several processes.
    bool isCollated() const { return className_ == "decomposedBlockData"; }

    /// Reads the blocks of a collated file.
    std::vector<FoamBlock> blocks();

    /// Reads a list of points.
    FileNumbers points();

    /// Reads a list of numbers from 0 to the largest Index. Twelve bytes can claim any number of
    /// equal ones ("1000000{0}"), so the number is compared with `limit` before memory is taken.
    /// \param what one of them in messages
    /// \param limit the largest number of labels: that of the things named `limited`, "faces"
    /// \param least the smallest label: 0 or −1
    std::vector<Index> labels(const char* what, std::size_t limit, const char* limited,
                              Index least = 0);

    /// Reads a list of faces: of lists of points, or the compact form of two lists.
    far::Rows<Index> faces();

    /// Reads the list of patches of a file "boundary", which is text in binary cases, too.
    std::vector<FoamPatch> patches();

    /// Throws unless only white space and comments are left.
    void expectEnd();

private:
    void readHeader();
    void skipSpace();
    std::string_view word(const char* what);
    void expect(std::string_view mark);
    std::size_t count(const char* what, std::size_t minBytes);
    /// Returns a word without its quotation marks.
    std::string text(const char* what);

    /// Skips the value of a keyword: words and lists up to a semicolon, or a dictionary in braces.
    void skipValue();

    Index label(const char* what, Index least = 0);
    Index textLabel(const char* what, Index least = 0);  ///< also in a binary file
    Index checkedLabel(std::int64_t number, const char* what, Index least) const;
    double scalar(std::size_t axis, std::size_t& offset);
    [[noreturn]] void fail(const std::string& cause) const;

    const std::filesystem::path* path_;
    std::string_view bytes_;
    std::size_t position_ = 0;
    std::size_t line_ = 1;
    std::size_t items_ = 0;  ///< number of words and numbers read, for checkCancelledEvery()
    std::string className_;
    std::string blockClass_;  ///< of the blocks of a collated file; empty if their header has it
    bool isBinary_ = false;
    bool hasBinaryBlocks_ = false;
    std::endian order_ = std::endian::little;
    std::size_t labelBytes_ = 4;
    std::size_t scalarBytes_ = 8;
};

/// Calls f with a file: with the file itself, or with each block of a collated one.
template <class F>
void forEachFoamPart(const std::filesystem::path& path, std::string_view bytes, F f) {
    FoamFile file(path, bytes);
    if (!file.isCollated()) {
        f(file);
        file.expectEnd();
        return;
    }
    std::optional<FoamFile> first;
    for (const FoamBlock& block : file.blocks()) {
        FoamFile part(bytes.substr(block.begin, block.end - block.begin), block.line,
                      first ? *first : file);
        if (!first) first = part;
        f(part);
        part.expectEnd();
    }
}

}  // namespace espalier::io

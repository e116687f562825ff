// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/file.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/ovm.h>
#include <espalier/io/text_reader.h>
#include <espalier/io/vtk_legacy.h>

#include <string>
#include <string_view>

namespace espalier::io {
namespace {

using Path = std::filesystem::path;

struct LatticeFormat {
    std::string_view extension;
    Lattice (*read)(const Path&);
    void (*write)(const Path&, const Lattice&, const WriteLatticeOptions&);
};

constexpr LatticeFormat kFormats[] = {
    {".ovm", readOvm,
     [](const Path& path, const Lattice& lattice, const WriteLatticeOptions&) {
         writeOvm(path, lattice);
     }},
    {".vtu", readVtu,
     [](const Path& path, const Lattice& lattice, const WriteLatticeOptions& options) {
         writeVtu(path, lattice, options.vtuEncoding);
     }},
    {".vtk", readVtkLegacy,
     [](const Path& path, const Lattice& lattice, const WriteLatticeOptions&) {
         writeVtkLegacy(path, lattice);
     }}};

const LatticeFormat& formatOf(const Path& path) {
    const std::string extension = lowerCase(path.extension().string());
    std::string known;
    for (const LatticeFormat& format : kFormats) {
        if (format.extension == extension) return format;
        known += (known.empty() ? "" : ", ") + std::string(format.extension);
    }
    throw FileError(path, "not a lattice format that is known; expected " + known);
}

}  // namespace

Lattice readLattice(const Path& path) {
    return formatOf(path).read(path);
}

void writeLattice(const Path& path, const Lattice& lattice, const WriteLatticeOptions& options) {
    formatOf(path).write(path, lattice, options);
}

void checkLatticeTarget(const Path& path) {
    formatOf(path);
}

}  // namespace espalier::io

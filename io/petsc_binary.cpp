// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/byte_output.h>
#include <espalier/io/file.h>
#include <espalier/io/finite.h>
#include <espalier/io/petsc_binary.h>

#include <cstdint>
#include <limits>
#include <string>

namespace espalier::io {
namespace {

using stencils::Index;
using stencils::StencilTable;

template <class Integer, class Real>
void write(ByteOutput& out, const StencilTable<Real>& table) {
    constexpr Integer kMatrix = 1211216;  // MAT_FILE_CLASSID
    out.number(kMatrix);
    out.number(static_cast<Integer>(table.rowCount()));
    out.number(static_cast<Integer>(table.columnCount()));
    out.number(static_cast<Integer>(table.entryCount()));
    for (Index row = 0; row < table.rowCount(); ++row)
        out.number(static_cast<Integer>(table.columns(row).size()));
    out.numbersAs<Integer>(table.columns());
    out.numbersAs<double>(table.weights());
}

}  // namespace

template <class Real>
void writePetscBinary(const std::filesystem::path& path, const StencilTable<Real>& table,
                      PetscInt integers) {
    checkFinite(table);
    if (integers == PetscInt::Bits32 &&
        table.entryCount() > std::numeric_limits<std::int32_t>::max())
        throw Error("the table has " + std::to_string(table.entryCount()) +
                    " entries, which take a PETSc of 64-bit indices");
    writeFile(path, [&](std::ostream& stream) {
        ByteOutput out(stream, std::endian::big);
        if (integers == PetscInt::Bits32)
            write<std::int32_t>(out, table);
        else
            write<std::int64_t>(out, table);
    });
}

template void writePetscBinary(const std::filesystem::path&, const StencilTable<float>&, PetscInt);
template void writePetscBinary(const std::filesystem::path&, const StencilTable<double>&, PetscInt);

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/file.h>
#include <espalier/io/matrices/petsc_binary.h>

#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include "../files/bytes.h"
#include "matrix_rows.h"

namespace espalier::io {
namespace {

using stencils::StencilTable;

constexpr std::int32_t kMatrix = 1211216;  // MAT_FILE_CLASSID

template <class Integer, class Real>
void write(ByteOutput& out, const StencilTable<Real>& table) {
    out.number(Integer{kMatrix}, Integer{table.rowCount()}, Integer{table.columnCount()},
               static_cast<Integer>(table.entryCount()));
    for (Index row = 0; row < table.rowCount(); ++row)
        out.number(static_cast<Integer>(table.columns(row).size()));
    out.numbersAs<Integer>(table.columns());
    out.numbersAs<double>(table.weights());
}

/// Returns the offsets of rows from the number of entries in each row.
Array<Offset> offsetsOf(const Array<Offset>& lengths, Offset entryCount) {
    Array<Offset> offsets(lengths.size() + 1);
    offsets[0] = 0;
    for (std::size_t row = 0; row < lengths.size(); ++row) {
        if (lengths[row] < 0 || lengths[row] > entryCount - offsets[row])
            throw CodingError(concat("row ", row, " claims ", lengths[row], " of the ", entryCount,
                                     " entries, of which ", entryCount - offsets[row],
                                     " are left"));
        offsets[row + 1] = offsets[row] + lengths[row];
    }
    return offsets;
}

/// Reads the matrix after the first number of the file.
template <class Integer>
StencilTable<double> read(ByteInput& in) {
    const Index rowCount = matrixSize(in.number<Integer>(), "rows");
    const Index columnCount = matrixSize(in.number<Integer>(), "columns");
    const Offset entryCount = in.number<Integer>();
    constexpr Offset kDense = -1;  // MATRIX_BINARY_FORMAT_DENSE
    if (entryCount == kDense) throw CodingError("holds a dense matrix; expected a sparse one");

    const std::uint64_t left = in.left();
    const std::uint64_t lengthBytes = static_cast<std::uint64_t>(rowCount) * sizeof(Integer);
    // Compared by division, so that no claimed size can overflow.
    constexpr std::uint64_t kEntrySize = sizeof(Integer) + sizeof(double);
    if (left < lengthBytes || (left - lengthBytes) % kEntrySize != 0 ||
        !std::cmp_equal((left - lengthBytes) / kEntrySize, entryCount))
        throw CodingError(
            concat("claims ", rowCount, " rows and ", entryCount, " entries, but ", left,
                   " bytes follow; expected one matrix, with weights in double precision"));
    const auto lengths = in.numbersAs<Integer, Offset>(static_cast<std::uint64_t>(rowCount));
    auto offsets = offsetsOf(lengths, entryCount);
    auto columns = in.numbersAs<Integer, Index>(static_cast<std::uint64_t>(entryCount));
    auto weights = in.numbersAs<double, double>(static_cast<std::uint64_t>(entryCount));
    return tableOfRows(columnCount, std::move(offsets), std::move(columns), std::move(weights));
}

}  // namespace

template <class Real>
void writePetscBinary(const std::filesystem::path& path, const StencilTable<Real>& table,
                      PetscInt integers) {
    checkFinite(table);
    if (integers == PetscInt::Bits32 &&
        table.entryCount() > std::numeric_limits<std::int32_t>::max())
        throw Error(concat("the table has ", table.entryCount(),
                           " entries, which needs PETSc with 64-bit indices"));
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

StencilTable<double> readPetscBinary(const std::filesystem::path& path, std::string_view bytes) {
    return decodeFile(path, [&] {
        // As a 64-bit integer, the first number begins with 32 zero bits; so the 32-bit integer at
        // the same place is 0, and not kMatrix.
        ByteInput narrow(bytes, std::endian::big), wide = narrow;
        if (narrow.number<std::int32_t>() == kMatrix) return read<std::int32_t>(narrow);
        if (wide.number<std::int64_t>() == kMatrix) return read<std::int64_t>(wide);
        throw CodingError("is not a matrix of PETSc");
    });
}

}  // namespace espalier::io

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/files/file.h>
#include <espalier/stencils/stencil_table.h>

#include <filesystem>
#include <string_view>

#include "support/test.h"

namespace espalier::test {

using Table = stencils::StencilTable<double>;

/// Returns a table with rows of 3, 0 and 2 entries. Its numbers would change in a careless text or
/// in a float.
template <class Real>
stencils::StencilTable<Real> sampleTable() {
    const Real third = Real{1} / 3;
    return {4,
            {0, 3, 3, 5},
            {0, 1, 3, 2, 3},
            {Real{0.25}, third, -std::numeric_limits<Real>::denorm_min(),
             std::numeric_limits<Real>::max(), third / 1024}};
}

/// Returns tables without rows, columns or entries, and one with the largest number of columns.
inline std::vector<Table> edgeTables() {
    std::vector<Table> tables;
    tables.emplace_back();
    tables.emplace_back(3, Array<Offset>{0}, Array<Index>{}, Array<double>{});
    tables.emplace_back(0, Array<Offset>{0, 0, 0}, Array<Index>{}, Array<double>{});
    tables.emplace_back(kMaxIndex, Array<Offset>{0, 0, 2, 2}, Array<Index>{0, kMaxIndex - 1},
                        Array<double>{1, -2});
    return tables;
}

/// Returns the folder of files that NumPy and SciPy wrote.
inline std::filesystem::path matrixFolder() {
    return std::filesystem::path(ESPALIER_SOURCE_DIR) / "tests/io/matrices";
}

/// Returns the table that these files contain.
inline Table tableOfOtherPrograms() {
    return {100'000, {0, 2, 2, 5, 5}, {0, 2, 0, 1, 3}, {0.25, -1.5, std::ldexp(1.0, -100), 7, 1}};
}

/// Expects that a table is valid, by the constructor that checks it, and that its weights are
/// finite.
inline void expectValidTable(const Table& table) {
    EXPECT_NO_THROW(Table(table.columnCount(), {table.offsets().begin(), table.offsets().end()},
                          {table.columns().begin(), table.columns().end()},
                          {table.weights().begin(), table.weights().end()}));
    for (const double weight : table.weights()) EXPECT_TRUE(std::isfinite(weight));
}

/// Expects that a file that is truncated at any byte is refused.
/// \param read function that reads the bytes
template <class Read>
void expectPartsOfMatrixRefused(const std::string& bytes, Read read) {
    for (std::size_t size = 0; size < bytes.size(); ++size)
        EXPECT_THROW(read(bytes.substr(0, size)), io::FileError) << "cut after byte " << size;
}

/// Expects that a file with any single byte changed is refused, or gives a table that `check`
/// accepts.
template <class Read, class Check>
void expectFlipsRefusedOr(const std::string& bytes, Read read, Check check) {
    for (std::size_t at = 0; at < bytes.size(); ++at)
        for (const int flip : {0x01, 0x10, 0x80, 0xff}) {
            SCOPED_TRACE("byte " + std::to_string(at) + " flipped by " + std::to_string(flip));
            std::string changed = bytes;
            changed[at] = char(changed[at] ^ flip);
            try {
                check(read(changed));
            } catch (const io::FileError&) {
                continue;
            }
        }
}

}  // namespace espalier::test

// SPDX-License-Identifier: Apache-2.0
#include "lattice_target.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    espalier::fuzz::runLatticeTarget("a.vtk", espalier::fuzz::textOf(data, size));
    return 0;
}

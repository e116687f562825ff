// SPDX-License-Identifier: Apache-2.0
#include "matrix_target.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    espalier::fuzz::runMatrixTarget("a.petsc", espalier::fuzz::textOf(data, size));
    return 0;
}

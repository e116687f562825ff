// SPDX-License-Identifier: Apache-2.0
#include "model_target.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    espalier::fuzz::runModelTarget("a.stl", espalier::fuzz::textOf(data, size));
    return 0;
}

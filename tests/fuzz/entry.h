// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

// The entry functions of the targets. libFuzzer calls them with its inputs, replay.cpp with files.

/// Selects the target that the first argument names: --target=NAME.
extern "C" int LLVMFuzzerInitialize(int* argumentCount, char*** arguments);

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

// The entries of the targets: libFuzzer calls them with what it has made up, replay.cpp with files.

/// Chooses the target that the first argument names: --target=NAME.
extern "C" int LLVMFuzzerInitialize(int* argumentCount, char*** arguments);

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <cstring>
#include <optional>

#include "allocation_faults.h"

// For a program that is run with this library before all others (LD_PRELOAD), and without what runs
// before main() of the C++ library: memory is short there as the environment says.
//
//     ESPALIER_TEST_FAILING=one:7     its seventh allocation fails
//     ESPALIER_TEST_FAILING=all:7     and so do all that follow

namespace {

std::optional<espalier::test::AllocationFault> fault;

struct FromEnvironment {
    FromEnvironment() {
        using espalier::test::Failing;
        const char* const said = std::getenv("ESPALIER_TEST_FAILING");
        if (said == nullptr || std::strlen(said) < 5) return;
        const bool isOne = std::strncmp(said, "one:", 4) == 0;
        fault.emplace(isOne ? Failing::One : Failing::AllFrom, std::atol(said + 4));
    }
} fromEnvironment;

}  // namespace

// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <cstring>
#include <optional>

#include "allocation_faults.h"

// Makes allocations fail in a program that is run with this library preloaded (LD_PRELOAD), as an
// environment variable says. Allocations of the C++ library before main() are not counted.
//
//     ESPALIER_TEST_FAILING=one:7     its seventh allocation fails
//     ESPALIER_TEST_FAILING=all:7     its seventh and all later ones fail

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

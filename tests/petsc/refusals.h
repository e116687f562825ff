// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace espalier::test {

/// Message of the error that a table threw before PetscInitialize().
extern std::string refusalBeforeInitialisation;

}  // namespace espalier::test

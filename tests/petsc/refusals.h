// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace espalier::test {

/// What a table said that was made before PetscInitialize().
extern std::string refusalBeforeInitialisation;

}  // namespace espalier::test

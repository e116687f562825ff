// SPDX-License-Identifier: Apache-2.0
#include "matrix_target.h"

namespace espalier::fuzz {
namespace {

const Target kMtx("mtx", [](std::string_view bytes) { runMatrix("a.mtx", bytes); });
const Target kPetsc("petsc", [](std::string_view bytes) { runMatrix("a.petsc", bytes); });

}  // namespace
}  // namespace espalier::fuzz

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace espalier::io {

/// Returns the names of the properties of a Nastran file, by their numbers. The format has no
/// names: the programs that write it put them into comments. The comments of HyperMesh, Femap,
/// ANSA, NX, I-DEAS and Patran are understood.
std::map<std::int64_t, std::string> nastranPropertyNames(std::string_view bytes);

}  // namespace espalier::io

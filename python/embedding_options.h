// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/stencils/embedding.h>

#include <string>

#include "words.h"

namespace espalier::python {

inline const Words<stencils::OutsidePolicy> kOutsidePolicies = {
    {"keep", stencils::OutsidePolicy::Keep},
    {"nearest", stencils::OutsidePolicy::Nearest},
    {"error", stencils::OutsidePolicy::Error}};

inline stencils::EmbeddingOptions embeddingOptions(const std::string& outside, double tolerance) {
    return {chosen(kOutsidePolicies, "outside", outside), tolerance};
}

}  // namespace espalier::python

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/embedding.h>

#include <string>

#include "words.h"

namespace espalier::python {

inline const Words<embed::OutsidePolicy> kOutsidePolicies = {
    {"keep", embed::OutsidePolicy::Keep},
    {"nearest", embed::OutsidePolicy::Nearest},
    {"error", embed::OutsidePolicy::Error}};

inline embed::EmbeddingOptions embeddingOptions(const std::string& outside, double tolerance) {
    return {chosen(kOutsidePolicies, "outside", outside), tolerance};
}

}  // namespace espalier::python

// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/complex_builder.h>
#include <espalier/stencils/composition.h>
#include <gtest/gtest.h>

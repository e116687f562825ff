// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/topology_refiner.h>
#include <gtest/gtest.h>

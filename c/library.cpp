// SPDX-License-Identifier: Apache-2.0
#include "espalier.h"

static_assert(ESPALIER_VERSION_MAJOR == ESPALIER_PROJECT_MAJOR &&
                  ESPALIER_VERSION_MINOR == ESPALIER_PROJECT_MINOR &&
                  ESPALIER_VERSION_PATCH == ESPALIER_PROJECT_PATCH,
              "the version in espalier.h is not that of the project");

const char* espalier_version(void) {
    return ESPALIER_PROJECT_VERSION;
}

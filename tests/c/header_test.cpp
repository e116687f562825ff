// SPDX-License-Identifier: Apache-2.0
// Checks that the headers also compile as C++11.
#include <espalier_shapes.h>
#include <espalier_solve.h>

int main() {
    espalier_bind_options options = espalier_default_bind_options();
    options.outside = ESPALIER_OUTSIDE_NEAREST;
    espalier_binding* binding = nullptr;
    return espalier_binding_create(nullptr, 0, nullptr, 0, nullptr, &options, &binding) ==
                   ESPALIER_ERROR_INPUT
               ? 0
               : 1;
}

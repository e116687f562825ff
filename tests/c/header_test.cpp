// SPDX-License-Identifier: Apache-2.0
// That the header is C++ as well, as old as C++11.
#include <espalier.h>

int main() {
    espalier_bind_options options = espalier_default_bind_options();
    options.outside = ESPALIER_OUTSIDE_NEAREST;
    espalier_binding* binding = nullptr;
    return espalier_binding_create(nullptr, 0, nullptr, 0, nullptr, &options, &binding) ==
                   ESPALIER_ERROR_INPUT
               ? 0
               : 1;
}

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>

#include "espalier.h"

namespace espalier::c {

/// Keeps what the exception that is being handled says for espalier_last_error().
/// \return its status
espalier_status statusOfException() noexcept;

/// Every function of the C API that can fail does its work in here, so that no exception leaves it.
template <class Body>
espalier_status guarded(const Body& body) noexcept {
    try {
        body();
        return ESPALIER_OK;
    } catch (...) {
        return statusOfException();
    }
}

}  // namespace espalier::c

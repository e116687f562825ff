// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Marks the functions and classes that a shared library exports; all others are hidden. A static
/// library exports nothing, so that a plug-in linked to it does not export our symbols either.
#if defined(__GNUC__) && !defined(ESPALIER_STATIC)
#define ESPALIER_API __attribute__((visibility("default")))
#else
#define ESPALIER_API
#endif

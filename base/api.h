// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Before what a shared library shows to those who link it; all else is hidden. A static library
/// hides all of it, so that a plug-in that is linked to one does not show it in its turn.
#if defined(__GNUC__) && !defined(ESPALIER_STATIC)
#define ESPALIER_API __attribute__((visibility("default")))
#else
#define ESPALIER_API
#endif

/* SPDX-License-Identifier: Apache-2.0 */
#ifndef ESPALIER_TESTS_CHECK_H
#define ESPALIER_TESTS_CHECK_H

#include <espalier_model.h>
#include <espalier_pose.h>
#include <espalier_shapes.h>
#include <espalier_solve.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Ends the program with a message that says where and why. */
static inline void fail(const char* file, int line, const char* what, const char* why) {
    printf("%s:%d: %s: %s\n", file, line, what, why);
    exit(1);
}

#define CHECK(condition)                                                  \
    do {                                                                  \
        if (!(condition)) fail(__FILE__, __LINE__, #condition, "not so"); \
    } while (0)

#define OK(call)                                                                           \
    do {                                                                                   \
        if ((call) != ESPALIER_OK) fail(__FILE__, __LINE__, #call, espalier_last_error()); \
    } while (0)

/* Checks that a call fails with this status, and with a message that contains this text. */
#define REFUSED(call, expected, text)                                              \
    do {                                                                           \
        if ((call) != (expected)) fail(__FILE__, __LINE__, #call, "wrong status"); \
        if (strstr(espalier_last_error(), (text)) == NULL)                         \
            fail(__FILE__, __LINE__, #call, espalier_last_error());                \
    } while (0)

#define INVALID(call, text) REFUSED(call, ESPALIER_ERROR_INPUT, text)

#endif

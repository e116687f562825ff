// SPDX-License-Identifier: Apache-2.0
// Tests the statuses of exceptions that no call of the C API can be made to throw.
#include "guard.h"

#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/far/topology_error.h>
#include <espalier/io/files/file.h>
#include <gtest/gtest.h>

#include <new>
#include <stdexcept>
#include <string>
#include <thread>

namespace espalier::c {
namespace {

template <class Exception>
espalier_status statusOf(const Exception& exception) {
    return guarded([&] { throw exception; });
}

TEST(Guard, EachExceptionHasAStatusAndAMessage) {
    EXPECT_EQ(guarded([] {}), ESPALIER_OK);
    EXPECT_EQ(statusOf(Error("cell 3 is bad")), ESPALIER_ERROR_INPUT);
    EXPECT_STREQ(espalier_last_error(), "cell 3 is bad");
    EXPECT_EQ(statusOf(far::TopologyError(far::TopologyCause::OpenCell, {3, 4}, "cell 4 is open")),
              ESPALIER_ERROR_INPUT);
    EXPECT_STREQ(espalier_last_error(), "cell 4 is open");
    EXPECT_EQ(statusOf(io::FileError("a.vtu", 7, "is bad")), ESPALIER_ERROR_FILE);
    EXPECT_STREQ(espalier_last_error(), "a.vtu:7: is bad");
    EXPECT_EQ(statusOf(Cancelled()), ESPALIER_CANCELLED);
    EXPECT_STREQ(espalier_last_error(), Cancelled().what());
    EXPECT_EQ(statusOf(std::bad_alloc()), ESPALIER_ERROR_MEMORY);
    EXPECT_STREQ(espalier_last_error(), "there is not enough memory");
    EXPECT_EQ(statusOf(std::length_error("vector::_M_default_append")), ESPALIER_ERROR_MEMORY);
    EXPECT_STREQ(espalier_last_error(), "there is not enough memory");
    EXPECT_EQ(statusOf(std::logic_error("never")), ESPALIER_ERROR_INTERNAL);
    EXPECT_STREQ(espalier_last_error(), "never");
    EXPECT_EQ(statusOf(42), ESPALIER_ERROR_INTERNAL);
    EXPECT_STREQ(espalier_last_error(), "an exception of unknown type");
}

TEST(Guard, EachThreadHasItsOwnMessage) {
    statusOf(Error("of this thread"));
    std::thread([] {
        EXPECT_STREQ(espalier_last_error(), "");
        statusOf(Error("of another"));
        EXPECT_STREQ(espalier_last_error(), "of another");
    }).join();
    EXPECT_STREQ(espalier_last_error(), "of this thread");
}

}  // namespace
}  // namespace espalier::c

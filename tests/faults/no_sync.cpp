// SPDX-License-Identifier: Apache-2.0

/// Replaces the C library's fsync. These tests do not need durable files, and syncing a thousand
/// files takes a second or two.
extern "C" int fsync(int) {
    return 0;
}

// SPDX-License-Identifier: MIT
//
// The version of the library: semantic versioning. Below 1.0, a minor version may change the interface; the
// shared library's soname (libstipple.so.MAJOR) changes with the major version.
#pragma once

#include <stipple/base.h>

#define STP_VERSION_MAJOR 0
#define STP_VERSION_MINOR 1
#define STP_VERSION_PATCH 0

#ifdef __cplusplus
extern "C" {
#endif

/// The version of the library that is loaded: 10000 * major + 100 * minor + patch. The macros above are those
/// of the headers that a program was compiled with. Any thread.
STP_API uint32_t stp_version(void);

#ifdef __cplusplus
}
#endif

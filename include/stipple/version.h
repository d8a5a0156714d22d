// SPDX-License-Identifier: MIT
//
// Library version, by semantic versioning. Below 1.0, a minor version may change the interface; the
// shared library's soname (libstipple.so.MAJOR) changes with the major version.
#pragma once

#include <stipple/base.h>

#define STP_VERSION_MAJOR 0
#define STP_VERSION_MINOR 1
#define STP_VERSION_PATCH 0

#ifdef __cplusplus
extern "C" {
#endif

/// Version of the loaded library: 10000 * major + 100 * minor + patch. The macros above give the
/// version of the headers. Callable from any thread.
STP_API uint32_t stp_version(void);

#ifdef __cplusplus
}
#endif

// SPDX-License-Identifier: MIT
#include <stipple/version.h>

uint32_t stp_version(void)
{
    return STP_VERSION_MAJOR * 10000u + STP_VERSION_MINOR * 100u + STP_VERSION_PATCH;
}

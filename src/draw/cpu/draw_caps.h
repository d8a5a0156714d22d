// SPDX-License-Identifier: MIT
#pragma once

#include "draw/cpu/cpu.h"

/// Whether the frame may have caps.
static inline bool stp_cpu_has_caps(const stp_cpu_renderer* r)
{
    return r->style->caps && r->sections->count > 0;
}

/// Draws caps (draw/caps.h) into the shaded picture and its depths. @return as stp_caps_find
STP_MUST_USE stp_result stp_cpu_put_caps(stp_cpu_renderer* r);

// SPDX-License-Identifier: MIT
#pragma once

#include "draw/cpu/cpu.h"

/// Whether the frame may have caps.
static inline bool cpu_has_caps(const cpu_renderer* r)
{
    return r->style->caps && r->sections->count > 0;
}

/// Draws caps (draw/caps.h) into the shaded picture and its depths. @return as stp_caps_find
STP_MUST_USE stp_result cpu_put_caps(cpu_renderer* r);

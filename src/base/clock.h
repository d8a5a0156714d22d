// SPDX-License-Identifier: MIT
#pragma once

/// Milliseconds from an arbitrary start; never goes back. For reports only: no result may depend on it.
double stp_clock_ms(void);

// SPDX-License-Identifier: MIT
#pragma once

/// Milliseconds since an arbitrary start; monotonic. For reports only: no result may depend on it.
double stp_clock_ms(void);

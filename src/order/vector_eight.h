// SPDX-License-Identifier: MIT
// Leaves are tested with the vectors of branches, eight floats. Included after the names `eight_*`.
#pragma once

enum { WIDE = 8 };
typedef eight wide;
#define wide_load eight_load
#define wide_store eight_store
#define wide_set eight_set
#define wide_add eight_add
#define wide_sub eight_sub
#define wide_mul eight_mul
#define wide_min eight_min
#define wide_max eight_max
#define wide_root eight_root
#define wide_less eight_less
#define wide_equal eight_equal
#define wide_blend eight_blend
#define wide_highest eight_highest
#define wide_lowest eight_lowest

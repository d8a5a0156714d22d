// SPDX-License-Identifier: MIT
#include "capture/fill_kernel.h"

void stp_fill_drop_portable(const stp_fill_query* query, uint32_t first_row,
                            const stp_raster_target* target)
{
    drop_known(query, first_row, target);
}

// SPDX-License-Identifier: MIT
#include "lod/surfels.h"

void stp_splats_destroy(stp_context* context, stp_splats* surfels)
{
    stp_free(context, surfels->positions);
    stp_free(context, surfels->normals);
    stp_free(context, surfels->materials);
    stp_free(context, surfels->colors);
    stp_free(context, surfels->coverages);
    stp_free(context, surfels->shapes);
    stp_free(context, surfels->ranges);
    *surfels = (stp_splats){0};
}

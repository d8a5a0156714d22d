// SPDX-License-Identifier: MIT
//
// PTS: a text with a point a line behind a line that counts them; several such blocks are one
// cloud. Of four columns behind the place that might all be colours, the first is the intensity.
#include "import/text_points.h"

static stp_result read(stp_import* import)
{
    return stp_points_text_read(import, true);
}

const stp_importer stp_importer_pts = {.name = "pts", .extensions = "pts", .read = read};

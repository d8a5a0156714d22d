// SPDX-License-Identifier: MIT
//
// PTS: text with one point per line after a line with their number; several such blocks form one
// cloud. Of four columns after the position that could all be colours, the first is the intensity.
#include "import/text/text_points.h"

static stp_result read(stp_import* import)
{
    return stp_points_text_read(import, true);
}

const stp_importer stp_importer_pts = {
    .name = "pts", .title = "PTS", .extensions = "pts", .read = read, .columns = true};

// SPDX-License-Identifier: MIT
//
// Text files with one point per line: XYZ, TXT, CSV, ASC, and PTS, which starts with the number of
// points. Columns are named by --columns or a header line, or detected by number and values. The
// default up axis is z, as in surveying.
#include "import/reading/surface.h"
#include "import/text/text_points.h"

#include <assert.h>
#include <string.h>

static stp_result check_counts(stp_import* import, const stp_text_points* points)
{
    if (points->declared > points->lines) {
        return stp_fail(import->context, STP_ERROR_TRUNCATED,
                        "%s: its count lines say %llu points, but it has %llu", import->path,
                        (unsigned long long)points->declared, (unsigned long long)points->lines);
    }
    if (points->declared > 0 && points->declared < points->lines) {
        stp_warn(import->context, "%s: its count lines say %llu points, but it has %llu: keeps all",
                 import->path, (unsigned long long)points->declared,
                 (unsigned long long)points->lines);
    }
    return STP_OK;
}

static stp_result read_points(stp_import* import, const stp_text_blocks* blocks,
                              bool intensity_first, stp_cloud* cloud)
{
    stp_columns_found found;
    stp_result result = stp_columns_find(import, blocks, intensity_first, &found);
    if (result != STP_OK) {
        return result;
    }
    stp_point_columns_desc columns = stp_text_points_wants(&found.columns);
    assert(found.first_line < blocks->line_count && "it has a point");
    result = stp_cloud_create(cloud, import, blocks->line_count - found.first_line, &columns);
    if (result != STP_OK) {
        return result;
    }
    stp_cloud_set_origin(cloud, found.place);
    stp_text_points points = {.cloud = cloud,
                              .blocks = blocks,
                              .columns = found.columns,
                              .first_line = found.first_line,
                              .color_fractions = found.color_fractions,
                              .ranges = found.ranges,
                              .declared = found.declared};
    result = stp_text_points_read(&points);
    result = result == STP_OK ? check_counts(import, &points) : result;
    stp_losses_add(&import->losses, STP_LOSS_COLUMN, found.columns.unused);
    stp_affine pose = stp_affine_identity();
    return result == STP_OK ? stp_cloud_finish(cloud, NULL, &pose) : result;
}

stp_result stp_points_text_read(stp_import* import, bool intensity_first)
{
    stp_text_blocks blocks;
    stp_cloud cloud = {0};
    stp_cloud_set_axes(import);
    stp_result result =
        stp_text_blocks_create(import->context, import->file.bytes, import->file.size, &blocks);
    result = result == STP_OK ? read_points(import, &blocks, intensity_first, &cloud) : result;
    stp_cloud_destroy(&cloud);
    stp_text_blocks_destroy(&blocks);
    return result;
}

static stp_result read(stp_import* import)
{
    return stp_points_text_read(import, false);
}

const stp_importer stp_importer_xyz = {.name = "xyz",
                                       .title = "XYZ",
                                       .extensions = "xyz txt csv asc",
                                       .listed = "xyz csv asc",
                                       .read = read,
                                       .columns = true};

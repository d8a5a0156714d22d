// SPDX-License-Identifier: MIT
//
// PTX: a sequence of scans, each a grid of columns and rows with the scanner's position and one
// line per cell. A cell at 0 0 0, the scanner itself, is empty. Normals come from neighbouring
// cells. The default up axis is z.
#include "import/reading/place_sample.h"
#include "import/reading/scan_values.h"
#include "import/reading/surface.h"
#include "import/text/text_points.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>

enum { HEADER_LINES = 10 };
#define NUMBER_LIMIT 1e15 ///< magnitudes in the header must be below it

typedef struct reader {
    stp_import* import;
    stp_text_blocks blocks;
    stp_line_cursor header; ///< first line of the scan's header
    stp_line_cursor cells;  ///< first line behind it
    uint32_t scan;          ///< from 1
    uint32_t columns, rows;
    double scanner[3];
    stp_affine pose;
} reader;

static stp_result fail_line(const reader* r, uint64_t line, const char* what)
{
    return stp_fail(r->import->context, STP_ERROR_FORMAT, "%s: line %llu: %s", r->import->path,
                    (unsigned long long)line + 1, what);
}

// Reads up to `maximum` numbers of a line; @return their number
static int read_numbers_at(stp_text at, double* values, int maximum)
{
    int count = 0;
    while (count < maximum && at != NULL) {
        at = stp_skip_blanks(at);
        at = *at != '\n' ? stp_read_number(at, &values[count]) : NULL;
        count += at != NULL;
    }
    return count;
}

static bool read_size(stp_text at, uint32_t* size)
{
    double values[2];
    bool good = read_numbers_at(at, values, 2) == 1 && values[0] >= 0.0 &&
                values[0] < (double)STP_NONE && values[0] == floor(values[0]);
    *size = good ? (uint32_t)values[0] : 0;
    return good;
}

// Rejects numbers that a scene cannot hold, by the header line that has them.
static stp_result check_number(const reader* r, uint64_t line, double value)
{
    if (fabs(value) < NUMBER_LIMIT) {
        return STP_OK;
    }
    static const char* const contents[] = {"scanner's position", "scanner's axes",
                                           "rotation of the pose", "translation of the pose"};
    assert(line >= r->header.line + 2 && line < r->header.line + HEADER_LINES);
    uint64_t row = line - r->header.line - 2;
    int kind = row == 0 ? 0 : row < 4 ? 1 : row < 7 ? 2 : 3;
    return stp_fail(r->import->context, STP_ERROR_FORMAT,
                    "%s: line %llu: %g in the %s: expected magnitudes below %g", r->import->path,
                    (unsigned long long)line + 1, value, contents[kind], NUMBER_LIMIT);
}

// The pose is a matrix for row vectors: the rotation in three lines, the translation in the fourth.
static stp_result read_header(reader* r)
{
    double n[4];
    uint64_t first = r->header.line;
    assert(first < r->blocks.line_count);
    if (r->blocks.line_count - first < HEADER_LINES) {
        return stp_fail(
            r->import->context, STP_ERROR_TRUNCATED,
            "%s: line %llu: a scan starts with %d header lines, but the file ends within them",
            r->import->path, (unsigned long long)first + 1, HEADER_LINES);
    }
    stp_line_cursor at = r->header;
    bool sized = read_size(at.at, &r->columns);
    stp_line_cursor_next(&at);
    if (!sized || !read_size(at.at, &r->rows)) {
        return fail_line(
            r, first, "expected the number of columns and, on the next line, the number of rows");
    }
    for (int i = 0; i < HEADER_LINES - 2; ++i) {
        int wanted = i < 4 ? 3 : 4;
        stp_line_cursor_next(&at);
        if (read_numbers_at(at.at, n, wanted) != wanted) {
            return fail_line(r, at.line,
                             i < 4 ? "expected the three coordinates of the scanner"
                                   : "expected four numbers of the scanner's pose");
        }
        for (int k = 0; k < 3; ++k) {
            stp_result result = check_number(r, at.line, n[k]);
            if (result != STP_OK) {
                return result;
            }
            if (i == 0) {
                r->scanner[k] = n[k];
            } else if (i >= 4) {
                r->pose.m[k][i - 4] = n[k];
            }
        }
    }
    r->cells = at;
    stp_line_cursor_skip(&r->cells, 1);
    return STP_OK;
}

// The scanner's position in the scan's own coordinates: the origin, unless the points are already
// placed.
static stp_vec3d find_scanner(const reader* r)
{
    const stp_affine* a = &r->pose;
    double det = stp_affine_determinant(a);
    stp_vec3d d = {r->scanner[0] - a->m[0][3], r->scanner[1] - a->m[1][3],
                   r->scanner[2] - a->m[2][3]};
    stp_vec3d c0 = {a->m[0][0], a->m[1][0], a->m[2][0]}, c1 = {a->m[0][1], a->m[1][1], a->m[2][1]},
              c2 = {a->m[0][2], a->m[1][2], a->m[2][2]};
    if (fabs(det) < 1e-12) {
        return (stp_vec3d){0};
    }
    return (stp_vec3d){stp_dotd(d, stp_crossd(c1, c2)) / det, stp_dotd(d, stp_crossd(c2, c0)) / det,
                       stp_dotd(d, stp_crossd(c0, c1)) / det};
}

// Columns of a line: x y z, optionally an intensity, optionally a colour.
static bool find_columns(const reader* r, stp_columns* columns)
{
    static const stp_columns known = {.roles = {STP_COLUMN_X, STP_COLUMN_Y, STP_COLUMN_Z,
                                                STP_COLUMN_INTENSITY, STP_COLUMN_R, STP_COLUMN_G,
                                                STP_COLUMN_B}};
    double values[8];
    *columns = known;
    int count = read_numbers_at(r->cells.at, values, 8);
    columns->count = (uint32_t)count;
    return count == 3 || count == 4 || count == 7;
}

// The first measured points choose the origin.
static void set_origin(const reader* r, stp_cloud* cloud)
{
    stp_place_sample places = {0};
    double place[3] = {0};
    uint32_t count = cloud->set.point_count;
    if (count == 0) {
        return;
    }
    stp_line_cursor cursor = r->cells;
    for (uint32_t i = 0; i < count && places.count < STP_PLACE_SAMPLES; ++i) {
        bool whole = read_numbers_at(cursor.at, place, 3) == 3;
        if (whole && (place[0] != 0.0 || place[1] != 0.0 || place[2] != 0.0)) {
            stp_place_sample_add(&places, place);
        }
        stp_line_cursor_next(&cursor);
    }
    stp_place_sample_choose(&places, place);
    stp_cloud_set_origin(cloud, place);
}

static stp_result fill_cloud(const reader* r, const stp_columns* columns, stp_cloud* cloud)
{
    stp_text_points points = {.cloud = cloud,
                              .blocks = &r->blocks,
                              .columns = *columns,
                              .first_line = r->cells.line,
                              .first_at = r->cells.at,
                              .strict = true,
                              .zero_is_empty = true,
                              .ranges = stp_column_ranges_empty()};
    points.ranges.low[STP_COLUMN_INTENSITY] = 0.0;
    points.ranges.high[STP_COLUMN_INTENSITY] = 1.0;
    assert((uint64_t)r->columns * r->rows == cloud->set.point_count && "a line per cell");
    set_origin(r, cloud);
    stp_result result = stp_text_points_read(&points);
    if (result != STP_OK) {
        return result;
    }
    stp_vec3d s = find_scanner(r);
    stp_scan_grid grid = {.columns = r->columns,
                          .rows = r->rows,
                          .scanner = {(float)(s.x - cloud->origin[0]),
                                      (float)(s.y - cloud->origin[1]),
                                      (float)(s.z - cloud->origin[2])}};
    stp_grid_normals(cloud, &grid);
    char name[32];
    snprintf(name, sizeof(name), "scan %u", r->scan);
    return stp_cloud_finish(cloud, name, &r->pose);
}

static stp_result read_scan(reader* r)
{
    stp_result result = read_header(r);
    if (result != STP_OK) {
        return result;
    }
    uint64_t cells = (uint64_t)r->columns * r->rows;
    uint64_t left = r->blocks.line_count - r->cells.line;
    if (cells > left) {
        return stp_fail(
            r->import->context, STP_ERROR_TRUNCATED,
            "%s: scan %u has %u columns of %u cells, but the file ends after %llu cells",
            r->import->path, r->scan, r->columns, r->rows, (unsigned long long)left);
    }
    stp_columns columns = {0};
    if (cells > 0 && !find_columns(r, &columns)) {
        return fail_line(r, r->cells.line,
                         "expected three, four or seven numbers: x y z, intensity, red green blue");
    }
    stp_point_columns_desc desc = stp_text_points_wants(&columns);
    desc.normals = true;
    stp_cloud cloud;
    result = stp_cloud_create(&cloud, r->import, cells, &desc);
    result = result == STP_OK ? fill_cloud(r, &columns, &cloud) : result;
    stp_cloud_destroy(&cloud);
    r->header = r->cells;
    stp_line_cursor_skip(&r->header, cells);
    return result;
}

static stp_result read_scans(reader* r)
{
    stp_result result = STP_OK;
    if (r->blocks.line_count > 0) {
        r->header = stp_line_cursor_at(&r->blocks, 0);
    }
    while (result == STP_OK && r->header.line < r->blocks.line_count) {
        if (r->scan > 0 && *stp_skip_blanks(r->header.at) == '\n') {
            stp_line_cursor_skip(&r->header, 1);
            continue;
        }
        r->scan += 1;
        result = read_scan(r);
    }
    if (result == STP_OK && r->scan == 0) {
        result = stp_fail(r->import->context, STP_ERROR_TRUNCATED, "%s: is empty", r->import->path);
    }
    return result;
}

static stp_result read(stp_import* import)
{
    reader r = {.import = import};
    stp_cloud_set_axes(import);
    stp_result result =
        stp_text_blocks_create(import->context, import->file.bytes, import->file.size, &r.blocks);
    result = result == STP_OK ? read_scans(&r) : result;
    stp_text_blocks_destroy(&r.blocks);
    return result;
}

const stp_importer stp_importer_ptx = {
    .name = "ptx", .title = "PTX", .extensions = "ptx", .read = read};

// SPDX-License-Identifier: MIT
// Binary PLY: double coordinates, colour, intensity, station and time; optionally the truth. Misses
// are not stored.
#include "base/io/bytes.h"
#include "lab/scan/scan_file.h"

#include <assert.h>
#include <stdio.h>

enum { HEADER = 1024 };

/// The header, with the length it will have at the end: a comment pads it.
static size_t put_header(const scan_file* f, char text[HEADER])
{
    char body[HEADER];
    int size =
        snprintf(body, sizeof(body),
                 "element vertex %llu\n"
                 "property double x\nproperty double y\nproperty double z\n%s"
                 "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                 "property ushort intensity\nproperty ushort point_source_id\n"
                 "property double gps_time\n%send_header\n",
                 (unsigned long long)f->points,
                 f->desc.truth ? "property float nx\nproperty float ny\nproperty float nz\n" : "",
                 f->desc.truth ? "property uint object\nproperty float range_error\n" : "");
    int fill = 640 - size;
    return (size_t)snprintf(text, HEADER,
                            "ply\nformat binary_little_endian 1.0\n"
                            "comment simulated scan by stipple, metres, z is up\n"
                            "comment %*s\n%s",
                            fill, ".", body);
}

static stp_result begin(scan_file* f)
{
    char text[HEADER];
    f->header_size = put_header(f, text);
    return stp_file_writer_append(f->writer, text, f->header_size);
}

static stp_result add(scan_file* f, const scan_station* station, const scan_point* points,
                      size_t count)
{
    stp_result result = STP_OK;
    for (size_t i = 0; i < count && result == STP_OK; ++i) {
        const scan_point* p = &points[i];
        unsigned char row[80];
        size_t size = 0;
        if (!p->hit) {
            continue;
        }
        for (int k = 0; k < 3; ++k, size += 8) {
            stp_write_f64(row + size, p->place[k] + f->desc.shift[k]);
        }
        for (int k = 0; k < 3 && f->desc.truth; ++k, size += 4) {
            stp_write_f32(row + size, p->normal[k]);
        }
        memcpy(row + size, p->color, 3);
        stp_write_u16(row + size + 3, p->intensity);
        stp_write_u16(row + size + 5, (uint16_t)station->number);
        stp_write_f64(row + size + 7, p->time);
        size += 15;
        if (f->desc.truth) {
            stp_write_u32(row + size, p->object);
            stp_write_f32(row + size + 4, p->range_error);
            size += 8;
        }
        assert(size <= sizeof(row));
        result = stp_file_writer_append(f->writer, row, size);
    }
    return result;
}

static stp_result end(scan_file* f)
{
    char text[HEADER];
    size_t size = put_header(f, text);
    assert(size == f->header_size && size < HEADER && "points follow the header");
    return stp_file_writer_patch(f->writer, 0, text, size);
}

const scan_format scan_format_ply = {
    .ending = ".ply", .has_truth = true, .begin = begin, .add = add, .end = end};

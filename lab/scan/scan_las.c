// SPDX-License-Identifier: MIT
// LAS 1.4 (ASPRS, revision 15), point format 7: coordinates in millimetres as whole numbers,
// intensity, scan angle, station, time and colour. Misses are not stored.
#include "base/io/bytes.h"
#include "lab/scan/scan_file.h"

enum { HEADER = 375, VLR_HEADER = 54, RECORD = 36 };

/// A local coordinate system in metres: point formats above 5 require one.
static const char system_text[] =
    "LOCAL_CS[\"simulated scan\",LOCAL_DATUM[\"scene\",0],UNIT[\"metre\",1],"
    "AXIS[\"X\",EAST],AXIS[\"Y\",NORTH],AXIS[\"Z\",UP]]";

enum { HEAD = HEADER + VLR_HEADER + sizeof(system_text) };

#define SCALE 0.001

static double along(stp_vec3d v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

static void put_header(const scan_file* f, unsigned char h[HEAD])
{
    memset(h, 0, HEAD);
    memcpy(h, "LASF", 4);
    stp_write_u16(h + 6, 1u << 4); // the coordinate system is WKT
    h[24] = 1;
    h[25] = 4;
    memcpy(h + 26, "SIMULATION", 10);
    memcpy(h + 58, "Stipple " STP_VERSION, sizeof("Stipple " STP_VERSION) - 1);
    stp_write_u16(h + 90, 1); // the format requires a date; a constant keeps the bytes the same
    stp_write_u16(h + 92, 2000);
    stp_write_u16(h + 94, HEADER);
    stp_write_u32(h + 96, HEAD);
    stp_write_u32(h + 100, 1); // variable length record
    h[104] = 7;
    stp_write_u16(h + 105, RECORD);
    bool any = f->points > 0;
    for (int k = 0; k < 3; ++k) {
        stp_write_f64(h + 131 + 8 * k, SCALE);
        stp_write_f64(h + 155 + 8 * k, f->offset[k]);
        stp_write_f64(h + 179 + 16 * k, any ? along(f->stored.max, k) * SCALE + f->offset[k] : 0.0);
        stp_write_f64(h + 187 + 16 * k, any ? along(f->stored.min, k) * SCALE + f->offset[k] : 0.0);
    }
    stp_write_u64(h + 247, f->points);
    stp_write_u64(h + 255, f->points); // all are first returns
    unsigned char* vlr = h + HEADER;
    memcpy(vlr + 2, "LASF_Projection", 15);
    stp_write_u16(vlr + 18, 2112);
    stp_write_u16(vlr + 20, sizeof(system_text));
    memcpy(vlr + VLR_HEADER, system_text, sizeof(system_text));
}

static stp_result begin(scan_file* f)
{
    stp_vec3d middle = stp_scaled(stp_addd(f->desc.bounds.min, f->desc.bounds.max), 0.5);
    for (int k = 0; k < 3; ++k) {
        f->offset[k] = floor(along(middle, k) + f->desc.shift[k]);
    }
    unsigned char header[HEAD];
    put_header(f, header);
    return stp_file_writer_append(f->writer, header, HEAD);
}

static stp_result add(scan_file* f, const scan_station* station, const scan_point* points,
                      size_t count)
{
    stp_result result = STP_OK;
    for (size_t i = 0; i < count && result == STP_OK; ++i) {
        const scan_point* p = &points[i];
        unsigned char r[RECORD] = {0};
        double stored[3];
        bool fits = true;
        for (int k = 0; k < 3; ++k) {
            stored[k] = floor((p->place[k] + (f->desc.shift[k] - f->offset[k])) / SCALE + 0.5);
            fits = fits && fabs(stored[k]) < 2147483647.0;
            stp_write_u32(r + 4 * k, fits && p->hit ? (uint32_t)(int32_t)stored[k] : 0);
        }
        if (!p->hit) {
            continue;
        }
        if (!fits) {
            return stp_fail(
                f->context, STP_ERROR_LIMIT,
                "%s: the points extend farther than LAS can store: 4,294 km in millimetres",
                f->desc.path);
        }
        stp_boxd_add(&f->stored, (stp_vec3d){stored[0], stored[1], stored[2]});
        stp_write_u16(r + 12, p->intensity);
        r[14] = 1 | 1 << 4; // the first of one return
        stp_write_u16(r + 18, (uint16_t)(int16_t)floor((double)p->angle / 0.006 + 0.5));
        stp_write_u16(r + 20, (uint16_t)station->number);
        stp_write_f64(r + 22, p->time);
        for (int k = 0; k < 3; ++k) {
            stp_write_u16(r + 30 + 2 * k, (uint16_t)(p->color[k] * 257));
        }
        result = stp_file_writer_append(f->writer, r, RECORD);
    }
    return result;
}

static stp_result end(scan_file* f)
{
    unsigned char header[HEAD];
    put_header(f, header);
    return stp_file_writer_patch(f->writer, 0, header, HEAD);
}

const scan_format scan_format_las = {.ending = ".las", .begin = begin, .add = add, .end = end};

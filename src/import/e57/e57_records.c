// SPDX-License-Identifier: MIT
//
// Converts records to points. A stream is one sequence of bits across all packets, so the bits of
// any run of records can be located: runs are read on all threads.
#include "base/io/bytes.h"
#include "base/math/math.h"
#include "import/e57/e57.h"
#include "import/reading/place_sample.h"
#include "import/reading/scan_values.h"

#include <assert.h>
#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

enum { RUN = 2048, BYTES = RUN * 8 + 16 };

#define RELEASE_EVERY 512 ///< runs, after which pages are released

// Buffers into which a worker reads a run, and the values that it has seen.
typedef struct buffers {
    double values[STP_E57_SLOTS][RUN];
    unsigned char bytes[BYTES];
    double low[STP_E57_SLOTS], high[STP_E57_SLOTS]; ///< of fields without limits
    uint64_t not_finite;                            ///< valid records without a finite position
} buffers;

typedef struct reader {
    const stp_e57* e57;
    const stp_e57_scan* scan;
    stp_cloud cloud;
    buffers* rooms;                            ///< one per worker
    stp_intensity_range limits[STP_E57_SLOTS]; ///< of intensities and colours
    atomic_uint_least32_t* cells; ///< first record of each grid cell, or STP_NONE; NULL: no grid
} reader;

static bool has(const reader* r, stp_e57_slot slot)
{
    return r->scan->fields[slot].used;
}

// `at` has eight readable bytes behind the value.
static uint64_t read_bits(const unsigned char* bytes, uint64_t at, unsigned bits)
{
    assert(bits >= 1 && bits <= 64);
    const unsigned char* from = bytes + (at >> 3);
    unsigned shift = (unsigned)at & 7;
    uint64_t value = stp_read_u64(from) >> shift;
    if (shift + bits > 64) {
        value |= (uint64_t)from[8] << (64 - shift);
    }
    return bits < 64 ? value & ((UINT64_C(1) << bits) - 1) : value;
}

static void read_field(const reader* r, stp_e57_slot slot, uint64_t first, size_t count,
                       buffers* room)
{
    const stp_e57_field* f = &r->scan->fields[slot];
    double* out = room->values[slot];
    uint64_t bit = first * f->bits, begin = bit / 8, end = (bit + count * f->bits + 7) / 8;
    assert(count <= RUN && end - begin + 16 <= BYTES && f->bits <= 64);
    assert(first + count <= r->scan->record_count);
    memset(room->bytes + (end - begin), 0, 16);
    stp_e57_copy_stream(r->e57, r->scan, slot, begin, room->bytes, (size_t)(end - begin));
    if (f->is_float) {
        for (size_t i = 0; i < count; ++i) {
            out[i] = f->bits == 32 ? (double)stp_read_f32(room->bytes + 4 * i)
                                   : stp_read_f64(room->bytes + 8 * i);
        }
        return;
    }
    uint64_t at = bit - 8 * begin;
    for (size_t i = 0; i < count; ++i, at += f->bits) {
        uint64_t raw = f->bits > 0 ? read_bits(room->bytes, at, f->bits) : 0;
        out[i] = (double)(int64_t)(raw + (uint64_t)f->minimum) * f->scale + f->offset;
    }
}

// Range, azimuth from x towards y, elevation from the plane.
static void turn_spherical(buffers* room, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        double sine_a, cosine_a, sine_e, cosine_e, range = room->values[STP_E57_X][i];
        stp_sine_cosine(room->values[STP_E57_Y][i], &sine_a, &cosine_a);
        stp_sine_cosine(room->values[STP_E57_Z][i], &sine_e, &cosine_e);
        room->values[STP_E57_X][i] = range * cosine_e * cosine_a;
        room->values[STP_E57_Y][i] = range * cosine_e * sine_a;
        room->values[STP_E57_Z][i] = range * sine_e;
    }
}

static void read_places(const reader* r, uint64_t first, size_t count, buffers* room)
{
    for (int slot = STP_E57_X; slot <= STP_E57_INVALID; ++slot) {
        if (has(r, (stp_e57_slot)slot)) {
            read_field(r, (stp_e57_slot)slot, first, count, room);
        }
    }
    if (r->scan->spherical) {
        turn_spherical(room, count);
    }
}

static void store_normals(const reader* r, size_t first, size_t count, const buffers* room)
{
    for (size_t i = 0; i < count; ++i) {
        stp_vec3 n = stp_normalize((stp_vec3){(float)room->values[STP_E57_NX][i],
                                              (float)room->values[STP_E57_NY][i],
                                              (float)room->values[STP_E57_NZ][i]});
        memcpy(r->cloud.set.normals + 3 * (first + i), &n, sizeof(n));
    }
}

static void store_colors(const reader* r, size_t first, size_t count, const buffers* room)
{
    uint8_t* out = r->cloud.set.colors + 4 * first;
    for (int channel = 0; channel < 3; ++channel) {
        double low = r->limits[STP_E57_RED + channel].low;
        double factor = 255.0 / (r->limits[STP_E57_RED + channel].high - low);
        const double* values = room->values[STP_E57_RED + channel];
        for (size_t i = 0; i < count; ++i) {
            out[4 * i + (size_t)channel] = (uint8_t)stp_quantize((values[i] - low) * factor, 255.0);
        }
    }
    bool may_fail = has(r, STP_E57_COLOR_INVALID);
    for (size_t i = 0; i < count; ++i) {
        if (may_fail && room->values[STP_E57_COLOR_INVALID][i] != 0.0) {
            memset(out + 4 * i, 255, 3);
        }
        out[4 * i + 3] = 255;
    }
}

static void store_intensities(const reader* r, size_t first, size_t count, const buffers* room)
{
    uint16_t* out = (uint16_t*)r->cloud.set.attributes[STP_ATTRIBUTE_INTENSITY] + first;
    stp_intensity_range range = r->limits[STP_E57_INTENSITY];
    double factor = stp_intensity_factor(range);
    bool may_fail = has(r, STP_E57_INTENSITY_INVALID);
    for (size_t i = 0; i < count; ++i) {
        bool fails = may_fail && room->values[STP_E57_INTENSITY_INVALID][i] != 0.0;
        double above = room->values[STP_E57_INTENSITY][i] - range.low;
        out[i] = fails ? 0 : (uint16_t)stp_quantize(above * factor, 65535.0);
    }
}

static void store_bytes(uint8_t* out, const double* values, size_t count, double shift)
{
    for (size_t i = 0; i < count && out != NULL; ++i) {
        out[i] = (uint8_t)stp_quantize(values[i] + shift, 255.0);
    }
}

// The first record of a cell wins, whichever thread comes first.
static void store_cells(const reader* r, size_t first, size_t count, const buffers* room)
{
    const stp_e57_scan* scan = r->scan;
    double row_low = scan->fields[STP_E57_ROW].low, column_low = scan->fields[STP_E57_COLUMN].low;
    for (size_t i = 0; i < count; ++i) {
        double row = room->values[STP_E57_ROW][i] - row_low;
        double column = room->values[STP_E57_COLUMN][i] - column_low;
        bool good = row >= 0.0 && column >= 0.0 && row < (double)scan->rows &&
                    column < (double)scan->columns && !stp_cloud_is_empty(&r->cloud, first + i);
        if (!good) {
            continue;
        }
        assert((uint64_t)column * scan->rows + (uint64_t)row < scan->rows * scan->columns);
        atomic_uint_least32_t* cell = &r->cells[(size_t)column * (size_t)scan->rows + (size_t)row];
        uint_least32_t old = atomic_load_explicit(cell, memory_order_relaxed);
        while (first + i < old &&
               !atomic_compare_exchange_weak(cell, &old, (uint_least32_t)(first + i))) {
        }
    }
}

static void store_run(const reader* r, size_t first, size_t count, buffers* room)
{
    assert(count <= RUN && first + count <= r->cloud.set.point_count);
    void* const* attributes = r->cloud.set.attributes;
    for (size_t i = 0; i < count; ++i) {
        double place[3] = {room->values[STP_E57_X][i], room->values[STP_E57_Y][i],
                           room->values[STP_E57_Z][i]};
        if (has(r, STP_E57_INVALID) && room->values[STP_E57_INVALID][i] != 0.0) {
            stp_cloud_leave_empty(&r->cloud, first + i);
        } else {
            room->not_finite += !stp_cloud_place(&r->cloud, first + i, place);
        }
    }
    if (has(r, STP_E57_NX) && has(r, STP_E57_NY) && has(r, STP_E57_NZ)) {
        store_normals(r, first, count, room);
    }
    if (r->cloud.set.colors != NULL) {
        store_colors(r, first, count, room);
    }
    if (attributes[STP_ATTRIBUTE_INTENSITY] != NULL) {
        store_intensities(r, first, count, room);
    }
    uint8_t* returns = attributes[STP_ATTRIBUTE_RETURN];
    uint8_t* counts = attributes[STP_ATTRIBUTE_RETURNS];
    double* times = attributes[STP_ATTRIBUTE_TIME];
    store_bytes(returns != NULL ? returns + first : NULL, room->values[STP_E57_RETURN], count, 1.0);
    store_bytes(counts != NULL ? counts + first : NULL, room->values[STP_E57_RETURNS], count, 0.0);
    if (times != NULL) {
        memcpy(times + first, room->values[STP_E57_TIME], count * sizeof(double));
    }
    if (r->cells != NULL) {
        store_cells(r, first, count, room);
    }
}

static void read_run(size_t begin, size_t end, uint32_t worker, void* user)
{
    reader* r = user;
    buffers* room = &r->rooms[worker];
    read_places(r, begin, end - begin, room);
    for (int slot = STP_E57_INTENSITY; slot < STP_E57_SLOTS; ++slot) {
        if (has(r, (stp_e57_slot)slot)) {
            read_field(r, (stp_e57_slot)slot, begin, end - begin, room);
        }
    }
    store_run(r, begin, end - begin, room);
    if (begin / RUN % RELEASE_EVERY == RELEASE_EVERY - 1) {
        stp_point_columns_release(r->cloud.import, &r->cloud.set);
    }
}

static bool has_limits(const stp_e57_field* f)
{
    return f->low < f->high;
}

static void measure_run(size_t begin, size_t end, uint32_t worker, void* user)
{
    reader* r = user;
    buffers* room = &r->rooms[worker];
    const double* invalid = room->values[STP_E57_INVALID];
    if (has(r, STP_E57_INVALID)) {
        read_field(r, STP_E57_INVALID, begin, end - begin, room);
    }
    for (int slot = STP_E57_INTENSITY; slot <= STP_E57_BLUE; ++slot) {
        if (!has(r, (stp_e57_slot)slot) || has_limits(&r->scan->fields[slot])) {
            continue;
        }
        read_field(r, (stp_e57_slot)slot, begin, end - begin, room);
        for (size_t i = 0; i < end - begin; ++i) {
            if (!has(r, STP_E57_INVALID) || invalid[i] == 0.0) {
                stp_range_add(room->values[slot][i], &room->low[slot], &room->high[slot]);
            }
        }
    }
}

// Limits of intensities and colours: those of the file, else by the values of valid records.
static void find_limits(reader* r)
{
    stp_context* context = r->cloud.import->context;
    double low[STP_E57_SLOTS], high[STP_E57_SLOTS], bright = -(double)INFINITY;
    stp_parallel_for(context, (size_t)r->scan->record_count, RUN, measure_run, r);
    for (int slot = STP_E57_INTENSITY; slot <= STP_E57_BLUE; ++slot) {
        low[slot] = (double)INFINITY;
        high[slot] = -(double)INFINITY;
        for (uint32_t i = 0; i < stp_context_thread_count(context); ++i) {
            low[slot] = fmin(low[slot], r->rooms[i].low[slot]);
            high[slot] = fmax(high[slot], r->rooms[i].high[slot]);
        }
        bright = slot >= STP_E57_RED ? fmax(bright, high[slot]) : bright;
    }
    for (int slot = STP_E57_INTENSITY; slot <= STP_E57_BLUE; ++slot) {
        const stp_e57_field* f = &r->scan->fields[slot];
        stp_intensity_range guessed =
            slot >= STP_E57_RED ? (stp_intensity_range){0.0, stp_color_white(bright, f->is_float)}
                                : stp_intensity_find_range(low[slot], high[slot]);
        r->limits[slot] = has_limits(f) ? (stp_intensity_range){f->low, f->high} : guessed;
    }
}

// The first valid positions choose the origin.
static void set_origin(reader* r)
{
    buffers* room = &r->rooms[0];
    stp_place_sample places = {0};
    double place[3];
    uint64_t count = r->scan->record_count;
    for (uint64_t first = 0; first < count && places.count == 0; first += RUN) {
        size_t run = count - first < RUN ? (size_t)(count - first) : RUN;
        read_places(r, first, run, room);
        for (size_t i = 0; i < run; ++i) {
            bool valid = !has(r, STP_E57_INVALID) || room->values[STP_E57_INVALID][i] == 0.0;
            for (int k = 0; k < 3; ++k) {
                place[k] = room->values[k][i];
            }
            if (valid) {
                stp_place_sample_add(&places, place);
            }
        }
    }
    stp_place_sample_choose(&places, place);
    stp_cloud_set_origin(&r->cloud, place);
}

static uint32_t list_attributes(const reader* r)
{
    return (uint32_t)has(r, STP_E57_INTENSITY) << STP_ATTRIBUTE_INTENSITY |
           (uint32_t)has(r, STP_E57_RETURN) << STP_ATTRIBUTE_RETURN |
           (uint32_t)has(r, STP_E57_RETURNS) << STP_ATTRIBUTE_RETURNS |
           (uint32_t)has(r, STP_E57_TIME) << STP_ATTRIBUTE_TIME;
}

static stp_result create_rooms(reader* r)
{
    stp_context* context = r->cloud.import->context;
    uint32_t workers = stp_context_thread_count(context);
    r->rooms = STP_NEW_ARRAY(context, buffers, workers);
    for (uint32_t i = 0; i < workers && r->rooms != NULL; ++i) {
        r->rooms[i].not_finite = 0;
        for (int slot = 0; slot < STP_E57_SLOTS; ++slot) {
            r->rooms[i].low[slot] = (double)INFINITY;
            r->rooms[i].high[slot] = -(double)INFINITY;
        }
    }
    return r->rooms != NULL ? STP_OK : stp_fail_memory(context);
}

static stp_result create_cells(reader* r)
{
    size_t count = (size_t)(r->scan->rows * r->scan->columns);
    r->cells = STP_NEW_ARRAY(r->cloud.import->context, atomic_uint_least32_t, count);
    for (size_t i = 0; i < count && r->cells != NULL; ++i) {
        atomic_init(&r->cells[i], STP_NONE);
    }
    return r->cells != NULL ? STP_OK : stp_fail_memory(r->cloud.import->context);
}

static stp_result add_grid_normals(reader* r)
{
    stp_context* context = r->cloud.import->context;
    size_t count = (size_t)(r->scan->rows * r->scan->columns);
    uint32_t* cells = STP_NEW_ARRAY(context, uint32_t, count);
    if (cells == NULL) {
        return stp_fail_memory(context);
    }
    for (size_t i = 0; i < count; ++i) {
        cells[i] = (uint32_t)atomic_load_explicit(&r->cells[i], memory_order_relaxed);
        assert(cells[i] == STP_NONE || cells[i] < r->cloud.set.point_count);
    }
    assert(r->scan->columns < STP_NONE && r->scan->rows < STP_NONE);
    const double* origin = r->cloud.origin;
    stp_scan_grid grid = {.columns = (uint32_t)r->scan->columns,
                          .rows = (uint32_t)r->scan->rows,
                          .cells = cells,
                          .scanner = {(float)-origin[0], (float)-origin[1], (float)-origin[2]}};
    stp_grid_normals(&r->cloud, &grid);
    stp_free(context, cells);
    return STP_OK;
}

static stp_result read_cloud(reader* r, uint32_t number)
{
    stp_import* import = r->e57->import;
    const stp_e57_scan* scan = r->scan;
    bool own_normals = has(r, STP_E57_NX) && has(r, STP_E57_NY) && has(r, STP_E57_NZ);
    bool grid = scan->rows * scan->columns > 0 && !own_normals;
    stp_point_columns_desc desc = {.normals = own_normals || grid,
                                   .colors = has(r, STP_E57_RED) && has(r, STP_E57_GREEN) &&
                                             has(r, STP_E57_BLUE),
                                   .attributes = list_attributes(r)};
    stp_result result = stp_cloud_create(&r->cloud, import, scan->record_count, &desc);
    result = result == STP_OK ? create_rooms(r) : result;
    result = result == STP_OK && grid ? create_cells(r) : result;
    if (result != STP_OK) {
        return result;
    }
    set_origin(r);
    find_limits(r);
    stp_parallel_for(import->context, (size_t)scan->record_count, RUN, read_run, r);
    for (uint32_t i = 0; i < stp_context_thread_count(import->context); ++i) {
        stp_losses_add(&import->losses, STP_LOSS_POINT, r->rooms[i].not_finite);
    }
    result = grid ? add_grid_normals(r) : STP_OK;
    char name[32];
    snprintf(name, sizeof(name), "scan %u", number);
    return result == STP_OK
               ? stp_cloud_finish(&r->cloud, scan->name != NULL ? scan->name : name, &scan->pose)
               : result;
}

stp_result stp_e57_read_records(const stp_e57* e57, uint32_t number, const stp_e57_scan* scan)
{
    reader r = {.e57 = e57, .scan = scan};
    stp_result result = read_cloud(&r, number);
    stp_cloud_destroy(&r.cloud);
    stp_free(e57->import->context, r.rooms);
    stp_free(e57->import->context, r.cells);
    return result;
}

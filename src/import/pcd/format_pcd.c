// SPDX-License-Identifier: MIT
//
// PCD, the format of the Point Cloud Library: ascii, binary and compressed. Empty cells of
// organised clouds are skipped. VIEWPOINT is ignored: points stay in their original frame. The
// default up axis is z, as in maps; camera frames use -y up.
#include "base/core/atomic_limits.h"
#include "base/io/bytes.h"
#include "import/pcd/pcd.h"
#include "import/reading/cloud.h"
#include "import/reading/place_sample.h"
#include "import/reading/scan_values.h"
#include "import/reading/surface.h"
#include "import/text/text_blocks.h"
#include "import/text/text_scan.h"

#include <assert.h>
#include <lzf.h>
#include <math.h>
#include <stdatomic.h>

#define GRAIN ((size_t)1 << 14)    ///< points
#define ROWS ((size_t)256)         ///< points whose fields are read one after the other
#define RELEASE_EVERY ((size_t)64) ///< tasks, after which pages are released
#define EXPANSION 100              ///< LZF makes at most 264 bytes of 3

enum { X, Y, Z, NX, NY, NZ, RGB, R, G, B, INTENSITY, LABEL, SLOTS };

// Names of fields, in any case.
static const struct {
    const char* name;
    int slot;
} slot_names[] = {{"x", X},
                  {"y", Y},
                  {"z", Z},
                  {"normal_x", NX},
                  {"normal_y", NY},
                  {"normal_z", NZ},
                  {"normalx", NX},
                  {"normaly", NY},
                  {"normalz", NZ},
                  {"nx", NX},
                  {"ny", NY},
                  {"nz", NZ},
                  {"rgb", RGB},
                  {"rgba", RGB},
                  {"red", R},
                  {"green", G},
                  {"blue", B},
                  {"r", R},
                  {"g", G},
                  {"b", B},
                  {"intensity", INTENSITY},
                  {"intensities", INTENSITY},
                  {"label", LABEL},
                  {"class", LABEL},
                  {"classification", LABEL}};

// A worker's results: the range of intensities, the brightest of separate colours, and empty cells.
typedef struct seen {
    double low, high, dark, bright;
    uint64_t empty;
} seen;

typedef struct reader {
    stp_import* import;
    stp_pcd pcd;
    const stp_pcd_field* slots[SLOTS]; ///< NULL: the file has none
    const unsigned char* base[SLOTS];  ///< binary: the field in the first point
    size_t stride[SLOTS];
    stp_cloud cloud;
    stp_intensity_range intensity;
    double white;  ///< value of white in separate fields of colours
    seen* workers; ///< one per worker
    stp_text_blocks blocks;
    uint8_t column_slots[STP_PCD_FIELDS]; ///< ascii: SLOTS for columns that are not kept
    atomic_uint_fast64_t bad_line;
} reader;

static int slot_named(const char* name)
{
    stp_text word = (stp_text)name, end = word + strlen(name);
    for (size_t k = 0; k < sizeof(slot_names) / sizeof(slot_names[0]); ++k) {
        if (stp_word_is(word, end, slot_names[k].name)) {
            return slot_names[k].slot;
        }
    }
    return SLOTS;
}

static void find_slots(reader* r)
{
    for (uint32_t i = 0; i < r->pcd.field_count; ++i) {
        const stp_pcd_field* f = &r->pcd.fields[i];
        int found = slot_named(f->name);
        bool fits = found < SLOTS && f->count == 1 && r->slots[found] == NULL &&
                    (found != RGB || f->size == 4);
        r->column_slots[i] = (uint8_t)(fits ? found : SLOTS);
        if (fits) {
            r->slots[found] = f;
        } else if (f->name[0] != '_') { // padding
            stp_losses_add(&r->import->losses, STP_LOSS_COLUMN, 1);
        }
    }
}

// Whether colours are in three fields; a packed field has priority.
static bool has_separate_colors(const reader* r)
{
    return r->slots[RGB] == NULL && r->slots[R] != NULL && r->slots[G] != NULL &&
           r->slots[B] != NULL;
}

static void store_packed(uint32_t rgb, uint8_t* to)
{
    const uint8_t color[4] = {(uint8_t)(rgb >> 16), (uint8_t)(rgb >> 8), (uint8_t)rgb, 255};
    memcpy(to, color, sizeof(color));
}

static void store_separate(const reader* r, const double rgb[3], uint8_t* to, seen* own)
{
    for (int k = 0; k < 3; ++k) {
        to[k] = (uint8_t)stp_quantize(rgb[k] * (255.0 / r->white), 255.0);
        stp_range_add(rgb[k], &own->dark, &own->bright);
    }
    to[3] = 255;
}

static void store_point(const reader* r, size_t cell, const double* v, uint32_t rgb, seen* own)
{
    const stp_point_set* set = &r->cloud.set;
    if (!stp_cloud_place(&r->cloud, cell, v)) {
        own->empty += 1;
        return;
    }
    if (set->normals != NULL) {
        stp_vec3 n = stp_normalize((stp_vec3){(float)v[NX], (float)v[NY], (float)v[NZ]});
        memcpy(set->normals + 3 * cell, &n, sizeof(n));
    }
    if (set->colors != NULL && r->slots[RGB] != NULL) {
        store_packed(rgb, set->colors + 4 * cell);
    } else if (set->colors != NULL) {
        store_separate(r, v + R, set->colors + 4 * cell, own);
    }
    uint16_t* intensities = set->attributes[STP_ATTRIBUTE_INTENSITY];
    if (intensities != NULL) {
        double above = v[INTENSITY] - r->intensity.low;
        intensities[cell] =
            (uint16_t)stp_quantize(above * stp_intensity_factor(r->intensity), 65535.0);
        stp_range_add(v[INTENSITY], &own->low, &own->high);
    }
    uint8_t* classes = set->attributes[STP_ATTRIBUTE_CLASS];
    if (classes != NULL) {
        classes[cell] = (uint8_t)stp_quantize(v[LABEL], 255.0);
    }
}

// Fields of many points other than the position, field by field; empty cells get them too.
static void store_columns(const reader* r, size_t first, size_t count, double v[SLOTS][ROWS],
                          seen* own)
{
    const stp_point_set* set = &r->cloud.set;
    assert(count <= ROWS && first + count <= set->point_count);
    for (size_t i = 0; i < count && set->normals != NULL; ++i) {
        stp_vec3 n = stp_normalize((stp_vec3){(float)v[NX][i], (float)v[NY][i], (float)v[NZ][i]});
        memcpy(set->normals + 3 * (first + i), &n, sizeof(n));
    }
    bool separate = has_separate_colors(r);
    const unsigned char* packed =
        set->colors != NULL && !separate ? r->base[RGB] + first * r->stride[RGB] : NULL;
    for (size_t i = 0; i < count && packed != NULL; ++i) {
        store_packed(stp_read_u32(packed + i * r->stride[RGB]), set->colors + 4 * (first + i));
    }
    for (size_t i = 0; i < count && separate; ++i) {
        if (!stp_cloud_is_empty(&r->cloud, first + i)) {
            store_separate(r, (double[3]){v[R][i], v[G][i], v[B][i]}, set->colors + 4 * (first + i),
                           own);
        }
    }
    uint16_t* intensities = set->attributes[STP_ATTRIBUTE_INTENSITY];
    double low = r->intensity.low, factor = stp_intensity_factor(r->intensity);
    for (size_t i = 0; i < count && intensities != NULL; ++i) {
        double value = v[INTENSITY][i];
        intensities[first + i] = (uint16_t)stp_quantize((value - low) * factor, 65535.0);
        if (!stp_cloud_is_empty(&r->cloud, first + i)) {
            stp_range_add(value, &own->low, &own->high);
        }
    }
    uint8_t* classes = set->attributes[STP_ATTRIBUTE_CLASS];
    for (size_t i = 0; i < count && classes != NULL; ++i) {
        classes[first + i] = (uint8_t)stp_quantize(v[LABEL][i], 255.0);
    }
}

static void read_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    reader* r = user;
    seen own = r->workers[worker];
    assert(begin % GRAIN == 0 && end <= r->pcd.point_count);
    if (begin / GRAIN % RELEASE_EVERY == RELEASE_EVERY - 1) {
        stp_point_columns_release(r->import, &r->cloud.set);
    }
    for (size_t first = begin; first < end; first += ROWS) {
        double v[SLOTS][ROWS];
        size_t count = end - first < ROWS ? end - first : ROWS;
        for (int slot = 0; slot < SLOTS; ++slot) {
            if (r->slots[slot] != NULL && slot != RGB) {
                stp_pcd_read_column(r->base[slot] + first * r->stride[slot], r->stride[slot],
                                    r->slots[slot], count, v[slot]);
            }
        }
        for (size_t i = 0; i < count; ++i) {
            double place[3] = {v[X][i], v[Y][i], v[Z][i]};
            own.empty += !stp_cloud_place(&r->cloud, first + i, place);
        }
        store_columns(r, first, count, v, &own);
    }
    r->workers[worker] = own;
}

// Widens a range by a sample of a field's values.
static void sample_field(const reader* r, int slot, double* low, double* high)
{
    enum { SAMPLES = 1024 };
    size_t count = (size_t)r->pcd.point_count, step = count / SAMPLES + 1;
    for (size_t i = 0; i < count && r->base[slot] != NULL; i += step) {
        stp_range_add(stp_pcd_value(r->base[slot] + i * r->stride[slot], r->slots[slot]), low,
                      high);
    }
}

static double white_of(const reader* r, double bright)
{
    bool fractions = has_separate_colors(r) && r->slots[R]->type == 'F';
    return stp_color_white(bright, fractions);
}

// Estimates the scales from a sample, so that most files are read only once.
static void guess_scales(reader* r)
{
    double low = 0.0, high = 0.0, dark = 0.0, bright = 0.0;
    sample_field(r, INTENSITY, &low, &high);
    for (int slot = R; slot <= B; ++slot) {
        sample_field(r, slot, &dark, &bright);
    }
    r->intensity = stp_intensity_find_range(low, high > 0.0 ? high : 1.0);
    r->white = white_of(r, bright);
}

static bool read_line(reader* r, stp_text at, size_t cell, uint32_t worker)
{
    double v[SLOTS + 1];
    uint32_t rgb = 0;
    for (uint32_t i = 0; i < r->pcd.field_count; ++i) {
        uint8_t slot = r->column_slots[i];
        for (uint32_t k = 0; k < r->pcd.fields[i].count; ++k) {
            at = stp_skip_blanks(at);
            stp_text next = *at != '\n' ? stp_scan_number(at, &v[slot]) : NULL;
            if (next == NULL || (!stp_is_blank(*next) && *next != '\n')) {
                return false;
            }
            rgb = slot == RGB ? stp_pcd_packed_color(at, next, v[slot]) : rgb;
            at = next;
        }
    }
    store_point(r, cell, v, rgb, &r->workers[worker]);
    return true;
}

static void read_blocks(size_t begin, size_t end, uint32_t worker, void* user)
{
    reader* r = user;
    uint64_t first = r->pcd.body_line, last = first + r->pcd.point_count;
    for (size_t i = begin; i < end; ++i) {
        const stp_text_block* b = &r->blocks.blocks[i];
        stp_text at = b->begin;
        for (uint64_t line = b->first_line; at < b->end && line < last; ++line) {
            if (line >= first && !read_line(r, at, (size_t)(line - first), worker)) {
                stp_atomic_min(&r->bad_line, line);
                break;
            }
            at = stp_next_line(at);
        }
        if (i % RELEASE_EVERY == RELEASE_EVERY - 1) {
            stp_point_columns_release(r->import, &r->cloud.set);
        }
    }
}

// Reads all points once. @return the range of their intensities, and the number of empty cells
static seen read_once(reader* r)
{
    stp_context* context = r->import->context;
    uint32_t workers = stp_context_thread_count(context);
    const double endless = (double)INFINITY;
    const seen none = {endless, -endless, endless, -endless, 0};
    seen all = none;
    for (uint32_t i = 0; i < workers; ++i) {
        r->workers[i] = none;
    }
    atomic_init(&r->bad_line, UINT64_MAX);
    if (r->pcd.encoding == STP_PCD_ASCII) {
        stp_parallel_for(context, r->blocks.count, 1, read_blocks, r);
    } else {
        stp_parallel_for(context, (size_t)r->pcd.point_count, GRAIN, read_rows, r);
    }
    for (uint32_t i = 0; i < workers; ++i) {
        all.low = fmin(all.low, r->workers[i].low);
        all.high = fmax(all.high, r->workers[i].high);
        all.bright = fmax(all.bright, r->workers[i].bright);
        all.empty += r->workers[i].empty;
    }
    return all;
}

static void sample_rows(const reader* r, stp_place_sample* places)
{
    size_t count = (size_t)r->pcd.point_count;
    // spread over the file; where none of those is finite, others
    for (size_t i = 0; i < count && (i < STP_PLACE_SAMPLES || places->count == 0); ++i) {
        size_t row = i < STP_PLACE_SAMPLES ? stp_place_sample_index((uint32_t)i, count) : i;
        double place[3];
        for (int k = 0; k < 3; ++k) {
            place[k] = stp_pcd_value(r->base[k] + row * r->stride[k], r->slots[k]);
        }
        stp_place_sample_add(places, place);
    }
}

static void sample_line(const reader* r, stp_text at, stp_place_sample* places)
{
    double v[SLOTS + 1] = {0};
    for (uint32_t f = 0; f < r->pcd.field_count && at != NULL; ++f) {
        for (uint32_t k = 0; k < r->pcd.fields[f].count && at != NULL; ++k) {
            at = stp_read_number(at, &v[r->column_slots[f]]);
        }
    }
    if (at != NULL) {
        stp_place_sample_add(places, (double[3]){v[X], v[Y], v[Z]});
    }
}

static void sample_lines(const reader* r, stp_place_sample* places)
{
    size_t count = (size_t)r->pcd.point_count;
    for (uint32_t i = 0; i < STP_PLACE_SAMPLES && i < count; ++i) {
        uint64_t line = r->pcd.body_line + stp_place_sample_index(i, count);
        sample_line(r, stp_line_cursor_at(&r->blocks, line).at, places);
    }
    // where none of those is finite, others
    stp_line_cursor cursor = stp_line_cursor_at(&r->blocks, r->pcd.body_line);
    for (size_t i = 0; i < count && places->count == 0; ++i) {
        sample_line(r, cursor.at, places);
        stp_line_cursor_next(&cursor);
    }
}

static void set_origin(reader* r)
{
    stp_place_sample places = {0};
    double middle[3];
    (r->pcd.encoding == STP_PCD_ASCII ? sample_lines : sample_rows)(r, &places);
    stp_place_sample_choose(&places, middle);
    stp_cloud_set_origin(&r->cloud, middle);
}

static stp_result fill_cloud(reader* r)
{
    stp_context* context = r->import->context;
    stp_point_columns_desc desc = {
        .normals = r->slots[NX] != NULL && r->slots[NY] != NULL && r->slots[NZ] != NULL,
        .colors = r->slots[RGB] != NULL || has_separate_colors(r),
        .attributes = (r->slots[INTENSITY] != NULL ? 1u << STP_ATTRIBUTE_INTENSITY : 0) |
                      (r->slots[LABEL] != NULL ? 1u << STP_ATTRIBUTE_CLASS : 0)};
    stp_result result = stp_cloud_create(&r->cloud, r->import, r->pcd.point_count, &desc);
    if (result != STP_OK) {
        return result;
    }
    r->workers = STP_NEW_ARRAY(context, seen, stp_context_thread_count(context));
    if (r->workers == NULL) {
        return stp_fail_memory(context);
    }
    if (r->pcd.point_count > 0) {
        set_origin(r);
    }
    guess_scales(r);
    seen all = read_once(r);
    assert(all.empty <= r->pcd.point_count);
    stp_intensity_range right = stp_intensity_find_range(all.low, all.high);
    double white = white_of(r, all.bright);
    if (right.low != r->intensity.low || right.high != r->intensity.high || white != r->white) {
        r->intensity = right;
        r->white = white;
        (void)read_once(r);
    }
    uint64_t bad = atomic_load(&r->bad_line);
    if (bad != UINT64_MAX) {
        return stp_fail(context, STP_ERROR_FORMAT,
                        "%s: line %llu: expected the numbers of %u fields", r->import->path,
                        (unsigned long long)bad + 1, r->pcd.field_count);
    }
    if (all.empty > 0) {
        stp_notice(context, "%s: %llu cells without a point are left out", r->import->path,
                   (unsigned long long)all.empty);
    }
    stp_affine pose = stp_affine_identity();
    return stp_cloud_finish(&r->cloud, NULL, &pose);
}

static stp_result fail_short(const reader* r, uint64_t held)
{
    return stp_fail(r->import->context, STP_ERROR_TRUNCATED,
                    "%s: its header says %llu points, but it ends after %llu", r->import->path,
                    (unsigned long long)r->pcd.point_count, (unsigned long long)held);
}

static stp_result read_text(reader* r)
{
    stp_import* import = r->import;
    stp_result result =
        stp_text_blocks_create(import->context, import->file.bytes, import->file.size, &r->blocks);
    if (result != STP_OK) {
        return result;
    }
    assert(r->blocks.line_count >= r->pcd.body_line && "the header's lines count, too");
    uint64_t held = r->blocks.line_count - r->pcd.body_line;
    return held < r->pcd.point_count ? fail_short(r, held) : fill_cloud(r);
}

static stp_result read_binary(reader* r)
{
    const stp_mapped_file* file = &r->import->file;
    uint64_t held = (file->size - r->pcd.body) / r->pcd.row_size;
    if (held < r->pcd.point_count) {
        return fail_short(r, held);
    }
    for (int i = 0; i < SLOTS; ++i) {
        if (r->slots[i] != NULL) {
            assert(r->slots[i]->offset + r->slots[i]->size <= r->pcd.row_size);
            r->base[i] = file->bytes + r->pcd.body + r->slots[i]->offset;
            r->stride[i] = r->pcd.row_size;
        }
    }
    return fill_cloud(r);
}

// After two sizes come all fields one after the other, compressed as one block.
static stp_result read_compressed(reader* r)
{
    stp_context* context = r->import->context;
    const stp_mapped_file* file = &r->import->file;
    const unsigned char* at = file->bytes + r->pcd.body;
    size_t left = file->size - r->pcd.body;
    uint64_t packed = left >= 8 ? stp_read_u32(at) : 0, size = left >= 8 ? stp_read_u32(at + 4) : 0;
    if (left < 8 || packed > left - 8) {
        return stp_fail(
            context, STP_ERROR_TRUNCATED,
            "%s: its header says %llu bytes of compressed points, but it ends after %zu",
            r->import->path, (unsigned long long)packed, left < 8 ? 0 : left - 8);
    }
    uint64_t count = r->pcd.point_count;
    if (count > size / r->pcd.row_size || count * r->pcd.row_size != size ||
        size / EXPANSION > packed) {
        return stp_fail(
            context, STP_ERROR_FORMAT,
            "%s: %llu points of %u bytes do not fit its %llu bytes of compressed points",
            r->import->path, (unsigned long long)count, r->pcd.row_size, (unsigned long long)size);
    }
    unsigned char* bytes = stp_alloc(context, (size_t)size);
    if (bytes == NULL) {
        return stp_fail_memory(context);
    }
    stp_result result = STP_OK;
    if (size > 0 &&
        lzf_decompress(at + 8, (unsigned)packed, bytes, (unsigned)size) != (unsigned)size) {
        result = stp_fail(context, STP_ERROR_FORMAT, "%s: its compressed points are damaged",
                          r->import->path);
    }
    for (int i = 0; i < SLOTS; ++i) {
        if (r->slots[i] != NULL) {
            assert(count * (r->slots[i]->offset + r->slots[i]->size) <= size);
            r->base[i] = bytes + (size_t)count * r->slots[i]->offset;
            r->stride[i] = r->slots[i]->size;
        }
    }
    result = result == STP_OK ? fill_cloud(r) : result;
    stp_free(context, bytes);
    return result;
}

static stp_result read_with(reader* r)
{
    stp_result result = stp_pcd_read_header(r->import, &r->pcd);
    if (result != STP_OK) {
        return result;
    }
    find_slots(r);
    if (r->slots[X] == NULL || r->slots[Y] == NULL || r->slots[Z] == NULL) {
        return stp_fail(r->import->context, STP_ERROR_FORMAT,
                        "%s: its points have no fields x, y and z", r->import->path);
    }
    if (r->import->desc.scan != NULL) {
        stp_pcd_describe(r->import, &r->pcd, r->column_slots, SLOTS, r->import->desc.scan);
    }
    return r->pcd.encoding == STP_PCD_ASCII    ? read_text(r)
           : r->pcd.encoding == STP_PCD_BINARY ? read_binary(r)
                                               : read_compressed(r);
}

static stp_result read(stp_import* import)
{
    reader r = {.import = import};
    stp_cloud_set_axes(import);
    stp_result result = read_with(&r);
    stp_cloud_destroy(&r.cloud);
    stp_text_blocks_destroy(&r.blocks);
    stp_free(import->context, r.workers);
    return result;
}

static bool detect(const unsigned char* bytes, size_t size)
{
    static const char first[] = "# .PCD v";
    return size >= sizeof(first) - 1 && memcmp(bytes, first, sizeof(first) - 1) == 0;
}

const stp_importer stp_importer_pcd = {
    .name = "pcd", .title = "PCD", .extensions = "pcd", .detect = detect, .read = read};

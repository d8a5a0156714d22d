// SPDX-License-Identifier: MIT
// Points of LAS files: from uncompressed records to blocks, and from blocks to the columns of a
// point set.
#include "base/io/bytes.h"
#include "import/las/las.h"

#include <assert.h>
#include <string.h>

enum { CLASS_MASK = 31 }; // the class in formats 0 to 5; the other bits are flags

// The first 20 bytes of formats 0 to 5, without position and intensity.
static void read_old_record(const unsigned char* p, stp_las_block* block, size_t i)
{
    block->return_number[i] = p[14] & 7;
    block->return_count[i] = p[14] >> 3 & 7;
    block->classes[i] = p[15] & CLASS_MASK;
    block->angle[i] = stp_las_angle((int8_t)p[16]);
    block->source[i] = stp_read_u16(p + 18);
}

// The first 22 bytes of formats 6 to 10, without position and intensity.
static void read_new_record(const unsigned char* p, stp_las_block* block, size_t i)
{
    block->return_number[i] = p[14] & 15;
    block->return_count[i] = p[14] >> 4;
    block->classes[i] = p[16];
    block->angle[i] = (int16_t)stp_read_u16(p + 18);
    block->source[i] = stp_read_u16(p + 20);
}

void stp_las_read_records(const stp_las* las, const unsigned char* bytes, size_t count,
                          stp_las_block* block, size_t first)
{
    stp_las_layout layout = las->layout;
    assert(first + count <= STP_LAS_BLOCK && layout.size <= las->record_size);
    for (size_t i = first; i < first + count; ++i, bytes += las->record_size) {
        for (size_t k = 0; k < 3; ++k) {
            block->position[k][i] = (int32_t)stp_read_u32(bytes + 4 * k);
        }
        block->intensity[i] = stp_read_u16(bytes + 12);
        if (las->format < 6) {
            read_old_record(bytes, block, i);
        } else {
            read_new_record(bytes, block, i);
        }
        if (layout.time != STP_LAS_NO_FIELD) {
            block->time[i] = stp_read_u64(bytes + layout.time);
        }
        for (size_t k = 0; k < 3 && layout.rgb != STP_LAS_NO_FIELD; ++k) {
            block->rgb[k][i] = stp_read_u16(bytes + layout.rgb + 2 * k);
        }
        if (layout.nir != STP_LAS_NO_FIELD) {
            block->nir[i] = stp_read_u16(bytes + layout.nir);
        }
    }
}

stp_point_columns_desc stp_las_columns(const stp_las* las, uint32_t point_count)
{
    unsigned attributes = (1u << STP_ATTRIBUTES) - 1;
    if (las->layout.time == STP_LAS_NO_FIELD) {
        attributes &= ~(1u << STP_ATTRIBUTE_TIME);
    }
    if (las->layout.nir == STP_LAS_NO_FIELD) {
        attributes &= ~(1u << STP_ATTRIBUTE_NEAR_INFRARED);
    }
    return (stp_point_columns_desc){.point_count = point_count,
                                    .colors = las->layout.rgb != STP_LAS_NO_FIELD,
                                    .attributes = attributes};
}

// Subtracts integers first, so that no digit is lost far from the file's own origin.
static void store_positions(const stp_las* las, const stp_las_block* block, size_t count, float* to)
{
    for (size_t k = 0; k < 3; ++k) {
        const int32_t* from = block->position[k];
        double scale = las->scale[k];
        int64_t origin = las->origin[k];
        for (size_t i = 0; i < count; ++i) {
            to[3 * i + k] = (float)((double)(from[i] - origin) * scale);
        }
    }
}

static unsigned store_colors(const stp_las_block* block, size_t count, bool wide, uint8_t* to)
{
    unsigned shift = wide ? 8 : 0, all = 0;
    for (size_t i = 0; i < count; ++i) {
        unsigned r = block->rgb[0][i], g = block->rgb[1][i], b = block->rgb[2][i];
        all |= r | g | b;
        to[4 * i] = (uint8_t)(r >> shift);
        to[4 * i + 1] = (uint8_t)(g >> shift);
        to[4 * i + 2] = (uint8_t)(b >> shift);
        to[4 * i + 3] = 255;
    }
    return (all != 0 ? STP_LAS_SEEN_COLOR : 0) | (all > 255 ? STP_LAS_SEEN_WIDE : 0);
}

// Stores a column of values unchanged. @return whether any of them is not zero
static bool store_values(void* column, size_t first, const void* values, size_t count, size_t size)
{
    const unsigned char* from = values;
    unsigned char any = 0;
    assert(size > 0 && size <= sizeof(uint64_t));
    memcpy((unsigned char*)column + first * size, from, count * size);
    for (size_t i = 0; i < count * size; ++i) {
        any |= from[i];
    }
    return any != 0;
}

unsigned stp_las_store_block(const stp_las* las, const stp_las_block* block, size_t count,
                             bool wide, stp_point_set* set, size_t first)
{
    const void* values[STP_ATTRIBUTES] = {
        [STP_ATTRIBUTE_INTENSITY] = block->intensity,
        [STP_ATTRIBUTE_CLASS] = block->classes,
        [STP_ATTRIBUTE_RETURN] = block->return_number,
        [STP_ATTRIBUTE_RETURNS] = block->return_count,
        [STP_ATTRIBUTE_SCAN_ANGLE] = block->angle,
        [STP_ATTRIBUTE_SOURCE] = block->source,
        [STP_ATTRIBUTE_TIME] = block->time,
        [STP_ATTRIBUTE_NEAR_INFRARED] = block->nir,
    };
    unsigned seen = 0;
    assert(count <= STP_LAS_BLOCK && first + count <= set->point_count);
    store_positions(las, block, count, set->positions + 3 * first);
    if (set->colors != NULL) {
        seen = store_colors(block, count, wide, set->colors + 4 * first);
    }
    for (unsigned i = 0; i < STP_ATTRIBUTES; ++i) {
        size_t size = stp_attribute_size((stp_attribute)i);
        if (set->attributes[i] != NULL &&
            store_values(set->attributes[i], first, values[i], count, size)) {
            seen |= 1u << i;
        }
    }
    return seen;
}

// SPDX-License-Identifier: MIT
// Items of the pool, and their uploads; includes splats and points.
#include "draw/gl/upload.h"

#include "base/core/context.h"
#include "base/splats/coverage.h"
#include "base/splats/light_normal.h"
#include "base/splats/splat_codes.h"
#include "store/bytes/columns.h"
#include "store/file/point_attributes.h"

#include <assert.h>
#include <string.h>

static uint32_t point_chunks(const stp_store_point_set* points)
{
    return (uint32_t)(((uint64_t)points->point_count + UPLOAD_POINTS - 1) / UPLOAD_POINTS);
}

stp_result stp_gl_entries_create(stp_gl_renderer* r)
{
    const stp_store_directory* d = r->directory;
    stp_gl_entries* entries = &r->entries;
    entries->sets = STP_NEW_ARRAY(r->base.context, uint32_t, (size_t)d->set_count + 1);
    entries->point_sets = STP_NEW_ARRAY(r->base.context, uint32_t, (size_t)d->point_set_count + 1);
    if (entries->sets == NULL || entries->point_sets == NULL) {
        return stp_fail_memory(r->base.context);
    }
    uint64_t count = 0;
    for (uint32_t i = 0; i < d->set_count; ++i) {
        entries->sets[i] = (uint32_t)count;
        count += 2 * (uint64_t)stp_store_describe_splat_set(r->store, i)->octave_count;
    }
    entries->meshes = (uint32_t)count;
    count += d->mesh_count;
    entries->textures = (uint32_t)count;
    count += 2 * (uint64_t)d->texture_count;
    for (uint32_t i = 0; i < d->point_set_count; ++i) {
        entries->point_sets[i] = (uint32_t)count;
        count += point_chunks(stp_store_describe_point_set(r->store, i));
    }
    if (count >= POOL_NONE) {
        return stp_fail(r->base.context, STP_ERROR_LIMIT, "gl: the scene has too many parts");
    }
    entries->count = (uint32_t)count;
    entries->boxes =
        STP_NEW_ARRAY(r->base.context, stp_gl_octave_box, (size_t)entries->meshes / 2 + 1);
    return entries->boxes != NULL ? STP_OK : stp_fail_memory(r->base.context);
}

void stp_gl_entries_destroy(stp_gl_renderer* r)
{
    stp_free(r->base.context, r->entries.sets);
    stp_free(r->base.context, r->entries.point_sets);
    stp_free(r->base.context, r->entries.boxes);
}

stp_gl_upload stp_gl_upload_begin(stp_gl_renderer* r, uint32_t entry, uint64_t words, bool urgent,
                                  stp_gl_source** source)
{
    const uint64_t bytes = words * sizeof(uint32_t);
    // at least one item is always uploaded
    if (!urgent && r->upload_bytes > 0 && r->frame.uploaded_bytes > 0 &&
        r->frame.uploaded_bytes + bytes > r->upload_bytes) {
        r->frame.coming += 1;
        return GL_UPLOAD_LATER;
    }
    if (!stp_gl_pool_take(&r->pool, entry, words)) {
        return GL_UPLOAD_NO_ROOM;
    }
    *source = stp_gl_conversions_begin(&r->conversions, &r->pool, entry, words);
    if (*source == NULL) {
        return stp_gl_upload_end(r, entry, STP_ERROR_OUT_OF_MEMORY);
    }
    r->frame.uploaded_bytes += bytes;
    return GL_UPLOAD_THERE;
}

stp_gl_upload stp_gl_upload_end(stp_gl_renderer* r, uint32_t entry, stp_result result)
{
    result = result == STP_OK ? stp_gl_conversions_end(&r->conversions, &r->pool) : result;
    if (result == STP_OK) {
        return GL_UPLOAD_THERE;
    }
    stp_gl_conversions_drop(&r->conversions, &r->pool);
    if (stp_gl_pool_has(&r->pool, entry)) {
        stp_gl_pool_drop(&r->pool, entry);
    }
    r->failure = result;
    return GL_UPLOAD_FAILED;
}

static stp_gl_octave_box bound_places(const stp_splats* splats, uint32_t begin, uint32_t end)
{
    stp_gl_octave_box box = {.low = {UINT16_MAX, UINT16_MAX, UINT16_MAX}};
    bool tells = splats->shapes != NULL && (splats->columns & STP_SPLATS_REPLACED) != 0;
    for (size_t i = begin; i < end; ++i) {
        const uint16_t* p = splats->positions + 3 * i;
        for (int k = 0; k < 3; ++k) {
            box.low[k] = p[k] < box.low[k] ? p[k] : box.low[k];
            box.high[k] = p[k] > box.high[k] ? p[k] : box.high[k];
        }
        uint16_t larger = splats->shapes != NULL ? splats->shapes[i] & 0xFFFu : 0;
        box.largest = larger > box.largest ? larger : box.largest;
        box.replaced = box.replaced || (tells && stp_shape_is_replaced(splats->shapes[i]));
    }
    return box;
}

static void write_places(const stp_gl_source* source, const stp_gl_piece* piece, uint32_t* words)
{
    const stp_splats* splats = &source->of.octave.splats;
    for (size_t i = piece->begin; i < piece->end; ++i) {
        const uint16_t* p = splats->positions + 3 * i;
        const uint8_t* n = (const uint8_t*)splats->normals + 2 * i;
        *words++ = (uint32_t)p[0] | (uint32_t)p[1] << 16;
        *words++ = (uint32_t)p[2] | (uint32_t)n[0] << 16 | (uint32_t)n[1] << 24;
    }
}

/// Four splats to a word: the units.
static void write_materials(const stp_gl_source* source, const stp_gl_piece* piece, uint32_t* words)
{
    const stp_gl_octave_source* of = &source->of.octave;
    const uint32_t* ends = of->splats.octave_ends;
    size_t first = of->octave > 0 ? ends[of->octave - 1] : 0, end = ends[of->octave];
    for (size_t unit = piece->begin; unit < piece->end; ++unit) {
        uint32_t word = 0;
        for (size_t k = 0, i = first + 4 * unit; k < 4 && i + k < end; ++k) {
            word |= (uint32_t)of->splats.materials[i + k] << (8 * k);
        }
        *words++ = word;
    }
}

/// Writes shape, range and errors of each splat, if the set has them.
static void write_options(const stp_gl_source* source, const stp_gl_piece* piece, uint32_t* words)
{
    const stp_splats* splats = &source->of.octave.splats;
    for (size_t i = piece->begin; i < piece->end; ++i) {
        if (splats->shapes != NULL) {
            *words++ = splats->shapes[i];
        }
        if (splats->ranges != NULL) {
            *words++ = splats->ranges[i];
        }
        if (splats->errors != NULL) {
            *words++ = splats->errors[i];
        }
    }
}

uint32_t stp_gl_option_words(const stp_splats* splats)
{
    return ((splats->columns & STP_SPLATS_SHAPES) != 0 ? 1u : 0u) +
           ((splats->columns & STP_SPLATS_RANGES) != 0 ? 1u : 0u) +
           ((splats->columns & STP_SPLATS_ERRORS) != 0 ? 1u : 0u);
}

static void write_colors(const stp_gl_source* source, const stp_gl_piece* piece, uint32_t* words)
{
    const stp_splats* splats = &source->of.octave.splats;
    for (size_t i = piece->begin; i < piece->end; ++i) {
        const uint8_t* c = splats->colors + 3 * i;
        uint8_t coverage = splats->coverages != NULL ? splats->coverages[i] : STP_COVERAGE_WHOLE;
        coverage = splats->plain_coverages ? stp_coverage_of_plain[coverage] : coverage;
        *words++ =
            (uint32_t)c[0] | (uint32_t)c[1] << 8 | (uint32_t)c[2] << 16 | (uint32_t)coverage << 24;
    }
}

/// Writes turns and spread of each splat.
static void write_lights(const stp_gl_source* source, const stp_gl_piece* piece, uint32_t* words)
{
    const stp_gl_octave_source* of = &source->of.octave;
    stp_light_normals lights = stp_light_normals_of(&of->splats, of->octave);
    for (size_t i = piece->begin; i < piece->end; ++i) {
        const uint8_t* turn = (const uint8_t*)lights.turns + 2 * i;
        *words++ = (uint32_t)turn[0] | (uint32_t)turn[1] << 8 | (uint32_t)lights.spreads[i] << 16;
    }
}

static stp_result add_colors(stp_gl_renderer* r, const stp_gl_octave_source* of)
{
    stp_gl_conversions* c = &r->conversions;
    size_t first = stp_store_colors_begin(&of->splats, of->octave);
    size_t end = of->splats.octave_ends[of->octave];
    bool lit = stp_light_normals_of(&of->splats, of->octave).turns != NULL;
    stp_result result =
        stp_gl_conversions_add_range(c, &r->pool, write_colors, first, first + end, 1);
    return result == STP_OK && lit
               ? stp_gl_conversions_add_range(c, &r->pool, write_lights, 0, end, 1)
               : result;
}

static stp_result add_places(stp_gl_renderer* r, const stp_gl_octave_source* of, uint32_t begin,
                             uint32_t end)
{
    stp_gl_conversions* c = &r->conversions;
    uint32_t options = stp_gl_option_words(&of->splats);
    stp_result result = stp_gl_conversions_add_range(c, &r->pool, write_places, begin, end, 2);
    result = result == STP_OK ? stp_gl_conversions_add_range(c, &r->pool, write_materials, 0,
                                                             ((size_t)end - begin + 3) / 4, 1)
                              : result;
    return result == STP_OK && options > 0
               ? stp_gl_conversions_add_range(c, &r->pool, write_options, begin, end, options)
               : result;
}

stp_gl_upload stp_gl_upload_octave(stp_gl_renderer* r, uint32_t set, uint32_t octave, bool colors,
                                   bool urgent)
{
    uint32_t entry = stp_gl_octave_entry(r, set, octave, colors);
    if (stp_gl_pool_has(&r->pool, entry)) {
        stp_gl_pool_use(&r->pool, entry);
        return GL_UPLOAD_THERE;
    }
    const stp_splats* known = stp_store_describe_splat_set(r->store, set);
    assert(octave < known->octave_count);
    uint32_t end = known->octave_ends[octave];
    uint32_t begin = octave > 0 ? known->octave_ends[octave - 1] : 0, count = end - begin;
    uint64_t options = (uint64_t)stp_gl_option_words(known) * count;
    uint64_t of_colors = (uint64_t)end * (stp_has_light_normals(known, octave) ? 2 : 1);
    uint64_t words = colors ? of_colors : 2 * (uint64_t)count + (count + 3) / 4 + options;
    stp_gl_source* source;
    stp_gl_upload begun = stp_gl_upload_begin(r, entry, words, urgent, &source);
    if (begun != GL_UPLOAD_THERE) {
        return begun;
    }
    stp_gl_octave_source* of = &source->of.octave;
    of->octave = octave;
    stp_result result = stp_store_get_splat_set_prefix(r->store, set, octave + 1, &of->splats);
    if (result == STP_OK && of->splats.octave_count <= octave) { // partial file: it never arrives
        stp_gl_conversions_cancel(&r->conversions, &r->pool);
        r->frame.uploaded_bytes -= words * sizeof(uint32_t);
        return GL_UPLOAD_LATER;
    }
    if (result == STP_OK && !colors) {
        r->entries.boxes[entry / 2] = bound_places(&of->splats, begin, end);
    }
    if (result == STP_OK) {
        result = colors ? add_colors(r, of) : add_places(r, of, begin, end);
    }
    return stp_gl_upload_end(r, entry, result);
}

static void write_positions(const stp_gl_source* source, const stp_gl_piece* piece, uint32_t* words)
{
    const stp_store_point_set* points = &source->of.points.points;
    const float away[3] = {2.0f * (float)HIDDEN_PLACE, 2.0f * (float)HIDDEN_PLACE,
                           2.0f * (float)HIDDEN_PLACE};
    for (size_t i = piece->begin; i < piece->end; ++i, words += 3) {
        bool hidden = source->of.points.hides && points->colors[4 * i + 3] == 0;
        memcpy(words, hidden ? away : points->positions + 3 * i, sizeof(away));
    }
}

static void write_point_colors(const stp_gl_source* source, const stp_gl_piece* piece,
                               uint32_t* words)
{
    memcpy(words, source->of.points.points.colors + 4 * piece->begin,
           4 * (piece->end - piece->begin));
}

static void write_point_normals(const stp_gl_source* source, const stp_gl_piece* piece,
                                uint32_t* words)
{
    memcpy(words, source->of.points.points.normals + 2 * piece->begin,
           4 * (piece->end - piece->begin));
}

stp_gl_upload stp_gl_upload_points(stp_gl_renderer* r, uint32_t point_set, uint32_t chunk,
                                   bool urgent)
{
    uint32_t entry = r->entries.point_sets[point_set] + chunk;
    if (stp_gl_pool_has(&r->pool, entry)) {
        stp_gl_pool_use(&r->pool, entry);
        return GL_UPLOAD_THERE;
    }
    stp_store_point_set points;
    r->failure = stp_store_get_point_set(r->store, point_set, &points);
    if (r->failure != STP_OK) {
        return GL_UPLOAD_FAILED;
    }
    size_t begin = (size_t)chunk * UPLOAD_POINTS, end = begin + UPLOAD_POINTS;
    end = end < points.point_count ? end : points.point_count;
    assert(begin <= end && "a chunk of the set");
    bool colors = points.colors != NULL, normals = points.normals != NULL;
    uint64_t each = 3u + (colors ? 1u : 0u) + (normals ? 1u : 0u);
    stp_gl_source* source;
    stp_gl_upload begun = stp_gl_upload_begin(r, entry, each * (end - begin), urgent, &source);
    if (begun != GL_UPLOAD_THERE) {
        return begun;
    }
    source->of.points = (stp_gl_points_source){
        .points = points, .hides = stp_store_get_coloring(r->store)->hides && colors};
    stp_gl_conversions* c = &r->conversions;
    stp_result result = stp_gl_conversions_add_range(c, &r->pool, write_positions, begin, end, 3);
    if (result == STP_OK && colors) {
        result = stp_gl_conversions_add_range(c, &r->pool, write_point_colors, begin, end, 1);
    }
    if (result == STP_OK && normals) {
        result = stp_gl_conversions_add_range(c, &r->pool, write_point_normals, begin, end, 1);
    }
    return stp_gl_upload_end(r, entry, result);
}

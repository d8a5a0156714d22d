// SPDX-License-Identifier: MIT
// Items of the pool, and their uploads; includes splats and textures.
#include "draw/gl/upload.h"

#include "base/core/context.h"
#include "base/splats/coverage.h"
#include "base/splats/light_normal.h"
#include "base/splats/splat_codes.h"
#include "raster/cutout.h"
#include "store/bytes/columns.h"
#include "store/file/point_attributes.h"

#include <assert.h>

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

stp_gl_writer stp_gl_writer_begin(stp_gl_renderer* r, uint32_t entry, uint64_t words)
{
    assert(stp_gl_pool_has(&r->pool, entry) && "room was taken first");
    return (stp_gl_writer){.pool = &r->pool, .address = stp_gl_address(r, entry), .left = words};
}

static void send(stp_gl_writer* w)
{
    if (w->used > 0 && !w->failed) {
        assert(w->used <= w->room && w->room <= w->left && "no more than announced");
        stp_gl_pool_send(w->pool, &w->part, w->address, w->used);
        w->address += w->used;
        w->left -= w->used;
        w->used = 0;
    }
}

void stp_gl_writer_turn(stp_gl_writer* writer)
{
    assert(writer->failed || writer->used == writer->room);
    send(writer);
    uint64_t room = writer->left < POOL_PART_WORDS ? writer->left : POOL_PART_WORDS;
    if (room == 0 || !stp_gl_pool_write(writer->pool, room, &writer->part)) {
        writer->failed = true;
        return;
    }
    writer->words = writer->part.memory;
    writer->room = (uint32_t)room;
}

/// Sends the rest. @return false if the context is lost, or words are missing
static bool end_writer(stp_gl_writer* writer)
{
    send(writer);
    return !writer->failed && writer->left == 0;
}

stp_gl_upload stp_gl_upload_begin(stp_gl_renderer* r, uint32_t entry, uint64_t words, bool urgent)
{
    // at least one item is always uploaded
    if (!urgent && r->upload_bytes > 0 && r->pool.uploaded_bytes > 0 &&
        r->pool.uploaded_bytes + words * sizeof(uint32_t) > r->upload_bytes) {
        r->frame.coming += 1;
        return GL_UPLOAD_LATER;
    }
    return stp_gl_pool_take(&r->pool, entry, words) ? GL_UPLOAD_THERE : GL_UPLOAD_NO_ROOM;
}

stp_gl_upload stp_gl_upload_end(stp_gl_renderer* r, uint32_t entry, stp_gl_writer* writer,
                                bool good)
{
    bool written = end_writer(writer);
    if (good && written) {
        return GL_UPLOAD_THERE;
    }
    stp_gl_pool_drop(&r->pool, entry);
    if (good) { // otherwise already logged
        r->failure = stp_fail(r->base.context, STP_ERROR_UNSUPPORTED,
                              "gl: the graphics context was lost while data was uploaded");
    }
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

static void write_places(const stp_splats* splats, uint32_t begin, uint32_t end, stp_gl_writer* w)
{
    for (size_t i = begin; i < end; ++i) {
        const uint16_t* p = splats->positions + 3 * i;
        const uint8_t* n = (const uint8_t*)splats->normals + 2 * i;
        stp_gl_write(w, (uint32_t)p[0] | (uint32_t)p[1] << 16);
        stp_gl_write(w, (uint32_t)p[2] | (uint32_t)n[0] << 16 | (uint32_t)n[1] << 24);
    }
    for (size_t i = begin; i < end; i += 4) {
        uint32_t word = 0;
        for (size_t k = 0; k < 4 && i + k < end; ++k) {
            word |= (uint32_t)splats->materials[i + k] << (8 * k);
        }
        stp_gl_write(w, word);
    }
}

/// Writes shape, range and errors of each splat, if the set has them.
static void write_options(const stp_splats* splats, uint32_t begin, uint32_t end, stp_gl_writer* w)
{
    for (size_t i = begin; i < end; ++i) {
        if (splats->shapes != NULL) {
            stp_gl_write(w, splats->shapes[i]);
        }
        if (splats->ranges != NULL) {
            stp_gl_write(w, splats->ranges[i]);
        }
        if (splats->errors != NULL) {
            stp_gl_write(w, splats->errors[i]);
        }
    }
}

uint32_t stp_gl_option_words(const stp_splats* splats)
{
    return ((splats->columns & STP_SPLATS_SHAPES) != 0 ? 1u : 0u) +
           ((splats->columns & STP_SPLATS_RANGES) != 0 ? 1u : 0u) +
           ((splats->columns & STP_SPLATS_ERRORS) != 0 ? 1u : 0u);
}

static void write_colors(const stp_splats* splats, uint64_t begin, uint32_t count, stp_gl_writer* w)
{
    for (uint64_t i = begin; i < begin + count; ++i) {
        const uint8_t* c = splats->colors + 3 * i;
        uint8_t coverage = splats->coverages != NULL ? splats->coverages[i] : STP_COVERAGE_WHOLE;
        coverage = splats->plain_coverages ? stp_coverage_of_plain[coverage] : coverage;
        stp_gl_write(w, (uint32_t)c[0] | (uint32_t)c[1] << 8 | (uint32_t)c[2] << 16 |
                            (uint32_t)coverage << 24);
    }
}

/// Writes turns and spread of each splat, if the octave has them.
static void write_lights(const stp_splats* splats, uint32_t octave, uint32_t count,
                         stp_gl_writer* w)
{
    stp_light_normals lights = stp_light_normals_of(splats, octave);
    for (size_t i = 0; lights.turns != NULL && i < count; ++i) {
        const uint8_t* turn = (const uint8_t*)lights.turns + 2 * i;
        stp_gl_write(w, (uint32_t)turn[0] | (uint32_t)turn[1] << 8 |
                            (uint32_t)lights.spreads[i] << 16);
    }
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
    stp_gl_upload result = stp_gl_upload_begin(r, entry, words, urgent);
    if (result != GL_UPLOAD_THERE) {
        return result;
    }
    stp_gl_writer writer = stp_gl_writer_begin(r, entry, words);
    stp_splats splats;
    stp_result got = stp_store_get_splat_set_prefix(r->store, set, octave + 1, &splats);
    bool good = got == STP_OK;
    r->failure = good ? r->failure : got;
    if (good && splats.octave_count <= octave) { // partial file: it never arrives
        stp_gl_pool_drop(&r->pool, entry);
        return GL_UPLOAD_LATER;
    }
    if (good && colors) {
        write_colors(&splats, stp_store_colors_begin(&splats, octave), end, &writer);
        write_lights(&splats, octave, end, &writer);
    } else if (good) {
        write_places(&splats, begin, end, &writer);
        write_options(&splats, begin, end, &writer);
        r->entries.boxes[entry / 2] = bound_places(&splats, begin, end);
    }
    return stp_gl_upload_end(r, entry, &writer, good);
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
    uint64_t each = 3u + (points.colors != NULL ? 1u : 0u) + (points.normals != NULL ? 1u : 0u);
    stp_gl_upload result = stp_gl_upload_begin(r, entry, each * (end - begin), urgent);
    if (result != GL_UPLOAD_THERE) {
        return result;
    }
    stp_gl_writer writer = stp_gl_writer_begin(r, entry, each * (end - begin));
    bool hides = stp_store_get_coloring(r->store)->hides && points.colors != NULL;
    for (size_t i = begin; i < end; ++i) {
        bool hidden = hides && points.colors[4 * i + 3] == 0;
        for (size_t k = 0; k < 3; ++k) {
            stp_gl_write_float(&writer,
                               hidden ? 2.0f * (float)HIDDEN_PLACE : points.positions[3 * i + k]);
        }
    }
    for (size_t i = begin; i < end && points.colors != NULL; ++i) {
        uint32_t word;
        memcpy(&word, points.colors + 4 * i, sizeof(word));
        stp_gl_write(&writer, word);
    }
    for (size_t i = begin; i < end && points.normals != NULL; ++i) {
        uint32_t word;
        memcpy(&word, points.normals + 2 * i, sizeof(word));
        stp_gl_write(&writer, word);
    }
    return stp_gl_upload_end(r, entry, &writer, true);
}

/// Size in words of the alpha cutoffs of levels from `first`.
static uint64_t count_cutoffs(const stp_texture_pyramid* pyramid, uint32_t first)
{
    uint32_t count = pyramid->cutoff_levels;
    return first < count ? (uint64_t)(count - first) * STP_CUTOUT_STEPS : 0;
}

/// First level that fits into half a page together with all coarser ones, or the coarsest, and
/// their size in words.
static uint32_t choose_level(const stp_gl_renderer* r, const stp_texture_pyramid* pyramid,
                             uint64_t* words)
{
    uint32_t first = 0;
    do {
        *words = TEXTURE_HEADER;
        for (uint32_t i = first; i < pyramid->level_count; ++i) {
            *words += (uint64_t)pyramid->width[i] * pyramid->height[i];
        }
        *words += count_cutoffs(pyramid, first);
    } while (*words > (UINT64_C(1) << r->pool.page_shift) / 2 && ++first < pyramid->level_count);
    assert(pyramid->level_count > 0 && pyramid->level_count <= STP_TEXTURE_LEVELS);
    return first < pyramid->level_count ? first : pyramid->level_count - 1;
}

static void write_texture(const stp_texture_pyramid* pyramid, uint32_t first, stp_gl_writer* w)
{
    uint64_t cutoffs = count_cutoffs(pyramid, first);
    uint32_t flags =
        (pyramid->linear ? TEXTURE_LINEAR : 0u) | (pyramid->nearest ? TEXTURE_NEAREST : 0u) |
        (uint32_t)pyramid->wrap_u * TEXTURE_WRAP_U | (uint32_t)pyramid->wrap_v * TEXTURE_WRAP_V |
        (cutoffs > 0 ? TEXTURE_CUTOUT : 0u) |
        (uint32_t)(cutoffs / STP_CUTOUT_STEPS) << TEXTURE_CUTOFF_SHIFT |
        (first > 0 ? TEXTURE_REDUCED : 0u);
    uint32_t place = TEXTURE_HEADER, count = pyramid->level_count - first;
    stp_gl_write(w, flags);
    stp_gl_write(w, count);
    for (uint32_t i = first; i < pyramid->level_count; ++i) {
        stp_gl_write(w, pyramid->width[i]);
        stp_gl_write(w, pyramid->height[i]);
        stp_gl_write(w, place);
        place += pyramid->width[i] * pyramid->height[i];
    }
    assert(first < pyramid->level_count && TEXTURE_SIZES + 3 * count <= TEXTURE_HEADER);
    for (uint32_t i = TEXTURE_SIZES + 3 * count; i < TEXTURE_HEADER; ++i) {
        stp_gl_write(w, 0);
    }
    for (uint32_t i = first; i < pyramid->level_count; ++i) {
        size_t texels = (size_t)pyramid->width[i] * pyramid->height[i];
        for (size_t k = 0; k < texels; ++k) {
            uint32_t word;
            memcpy(&word, pyramid->texels[i] + 4 * k, sizeof(word));
            stp_gl_write(w, word);
        }
    }
    for (uint64_t k = 0; k < cutoffs; ++k) {
        stp_gl_write_float(w, pyramid->cutoffs[(uint64_t)first * STP_CUTOUT_STEPS + k]);
    }
}

_Static_assert(STP_CUTOUT_STEPS == TEXTURE_CUTOFFS, "as shaders have it");
_Static_assert(TEXTURE_SIZES + 3 * STP_TEXTURE_LEVELS <= TEXTURE_HEADER, "room for all levels");

/// Whether the alpha of a texture cuts anything out.
static bool is_cutout(const stp_gl_renderer* r, uint32_t texture)
{
    for (uint32_t i = 0; i < r->directory->material_count; ++i) {
        const stp_store_material* m = &r->directory->materials[i];
        if (m->alpha == STP_STORE_MASK && m->base_color_texture.texture == texture) {
            return true;
        }
    }
    return false;
}

static stp_gl_upload upload_texels(stp_gl_renderer* r, uint32_t texture, bool data,
                                   const stp_store_texture* source)
{
    uint32_t entry = r->entries.textures + 2 * texture + (data ? 1u : 0u);
    stp_texture_pyramid pyramid;
    r->failure = stp_texture_pyramid_create(r->base.context, source->texels, source->width,
                                            source->height, data, &pyramid);
    if (r->failure != STP_OK) {
        return GL_UPLOAD_FAILED;
    }
    pyramid.wrap_u = (stp_texture_wrap)source->wrap_u;
    pyramid.wrap_v = (stp_texture_wrap)source->wrap_v;
    pyramid.nearest = source->nearest != 0;
    if (!data && is_cutout(r, texture)) {
        r->failure = stp_cutout_prepare(r->base.context, &pyramid);
        if (r->failure != STP_OK) {
            stp_texture_pyramid_destroy(r->base.context, &pyramid);
            return GL_UPLOAD_FAILED;
        }
    }
    uint64_t words;
    uint32_t first = choose_level(r, &pyramid, &words);
    stp_gl_upload result = stp_gl_upload_begin(r, entry, words, true);
    if (result == GL_UPLOAD_THERE) {
        stp_gl_writer writer = stp_gl_writer_begin(r, entry, words);
        write_texture(&pyramid, first, &writer);
        result = stp_gl_upload_end(r, entry, &writer, true);
    }
    stp_texture_pyramid_destroy(r->base.context, &pyramid);
    return result;
}

stp_gl_upload stp_gl_upload_texture(stp_gl_renderer* r, uint32_t texture, bool data)
{
    uint32_t entry = r->entries.textures + 2 * texture + (data ? 1u : 0u);
    if (stp_gl_pool_has(&r->pool, entry)) {
        stp_gl_pool_use(&r->pool, entry);
        return GL_UPLOAD_THERE;
    }
    stp_store_texture source;
    uint8_t* decoded; // texels are not needed after the upload
    r->failure = stp_store_load_texture(r->store, texture, &source, &decoded);
    stp_gl_upload result =
        r->failure == STP_OK ? upload_texels(r, texture, data, &source) : GL_UPLOAD_FAILED;
    stp_free(r->base.context, decoded);
    return result;
}

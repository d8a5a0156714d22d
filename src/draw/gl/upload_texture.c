// SPDX-License-Identifier: MIT
// Uploads textures to the pool: a header, the levels of the pyramid, and alpha cutoffs.
#include "base/core/context.h"
#include "draw/gl/upload.h"
#include "raster/cutout.h"

#include <assert.h>
#include <string.h>

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

/// `place`: the first level.
static void write_header(const stp_gl_source* source, const stp_gl_piece* piece, uint32_t* words)
{
    const stp_texture_pyramid* pyramid = &source->of.texture;
    const uint32_t first = (uint32_t)piece->place, count = pyramid->level_count - first;
    uint64_t cutoffs = count_cutoffs(pyramid, first);
    uint32_t place = TEXTURE_HEADER, used = TEXTURE_SIZES;
    assert(first < pyramid->level_count && TEXTURE_SIZES + 3 * count <= TEXTURE_HEADER);
    memset(words, 0, TEXTURE_HEADER * sizeof(*words));
    words[0] = (pyramid->linear ? TEXTURE_LINEAR : 0u) | (pyramid->nearest ? TEXTURE_NEAREST : 0u) |
               (uint32_t)pyramid->wrap_u * TEXTURE_WRAP_U |
               (uint32_t)pyramid->wrap_v * TEXTURE_WRAP_V | (cutoffs > 0 ? TEXTURE_CUTOUT : 0u) |
               (uint32_t)(cutoffs / STP_CUTOUT_STEPS) << TEXTURE_CUTOFF_SHIFT |
               (first > 0 ? TEXTURE_REDUCED : 0u);
    words[1] = count;
    for (uint32_t i = first; i < pyramid->level_count; ++i) {
        words[used++] = pyramid->width[i];
        words[used++] = pyramid->height[i];
        words[used++] = place;
        place += pyramid->width[i] * pyramid->height[i];
    }
}

/// Texels of a level, in rows. `place`: the level.
static void write_texels(const stp_gl_source* source, const stp_gl_piece* piece, uint32_t* words)
{
    const stp_texture_pyramid* pyramid = &source->of.texture;
    size_t row = 4 * (size_t)pyramid->width[piece->place];
    memcpy(words, pyramid->texels[piece->place] + row * piece->begin,
           row * (piece->end - piece->begin));
}

static void write_cutoffs(const stp_gl_source* source, const stp_gl_piece* piece, uint32_t* words)
{
    memcpy(words, source->of.texture.cutoffs + piece->begin,
           (piece->end - piece->begin) * sizeof(float));
}

static stp_result add_texture(stp_gl_renderer* r, const stp_texture_pyramid* pyramid,
                              uint32_t first)
{
    stp_gl_conversions* c = &r->conversions;
    const stp_gl_piece header = {
        .convert = write_header, .end = 1, .place = first, .words = TEXTURE_HEADER};
    stp_result result = stp_gl_conversions_add(c, &r->pool, header);
    for (uint32_t i = first; i < pyramid->level_count; ++i) {
        uint32_t width = pyramid->width[i], height = pyramid->height[i];
        uint32_t most = width < GL_PIECE_WORDS ? GL_PIECE_WORDS / width : 1;
        for (uint32_t y = 0; y < height && result == STP_OK; y += most) {
            uint32_t rows = height - y < most ? height - y : most;
            const stp_gl_piece piece = {.convert = write_texels,
                                        .begin = y,
                                        .end = y + rows,
                                        .place = i,
                                        .words = rows * width};
            result = stp_gl_conversions_add(c, &r->pool, piece);
        }
    }
    size_t begin = (size_t)first * STP_CUTOUT_STEPS;
    return result == STP_OK
               ? stp_gl_conversions_add_range(c, &r->pool, write_cutoffs, begin,
                                              begin + (size_t)count_cutoffs(pyramid, first), 1)
               : result;
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
    stp_gl_source* uploaded;
    stp_gl_upload got = stp_gl_upload_begin(r, entry, words, true, &uploaded);
    if (got == GL_UPLOAD_THERE) {
        uploaded->of.texture = pyramid;
        stp_result result = add_texture(r, &pyramid, first);
        // texels do not stay
        result = result == STP_OK ? stp_gl_conversions_send(&r->conversions, &r->pool) : result;
        got = stp_gl_upload_end(r, entry, result);
    }
    stp_texture_pyramid_destroy(r->base.context, &pyramid);
    return got;
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

// SPDX-License-Identifier: MIT
//
// Material libraries of OBJ files. Colours are treated as sRGB; `Ns` is converted to a roughness,
// `d` and `map_d` to transparency; the physical extension (Pm, Pr) has priority. `Tr` is 1 - d, but
// MeshLab, OpenMVS and others write `Tr 1` for opaque materials, so that alone hides nothing, and `d`
// has priority. Everything else, such as `illum` and the specular colour, is ignored.
#include "import/obj/obj.h"
#include "import/reading/surface.h"

#include <assert.h>
#include <math.h>
#include <string.h>

typedef struct mtl {
    stp_import* import;
    stp_lookup* names;
    stp_pictures pictures;
    stp_text end;
    stp_material material; ///< the one being read
    const char* name;      ///< NULL before the first `newmtl`
    const char* alpha_map; ///< file name from map_d
    bool has_roughness;
    bool has_opacity;   ///< the material has `d`
    bool has_heights;   ///< the material has a map of heights
    float transparency; ///< of `Tr`; negative: none
} mtl;

// A file name and its options.
typedef struct map_options {
    float scale[2], offset[2];
    stp_wrap wrap;
    const char* name;
} map_options;

static stp_text read_values(stp_text at, float* values, int limit, int* count)
{
    *count = 0;
    while (*count < limit) {
        double number;
        stp_text next = stp_read_number(at, &number);
        if (next == NULL) {
            break;
        }
        at = next;
        values[(*count)++] = isfinite(number) ? (float)number : 0.0f;
    }
    return at;
}

static void read_color(stp_text at, float out[3])
{
    float rgb[3];
    int count;
    (void)read_values(at, rgb, 3, &count);
    for (int i = 0; i < 3 && count > 0; ++i) {
        out[i] = stp_srgb_to_linear(rgb[i < count ? i : 0]);
    }
}

// Options begin with '-' and have a known number of words; the file name is the rest of the line.
static stp_text skip_option(stp_text at, stp_text word, map_options* options)
{
    assert(*at == '-' && at < word);
    static const struct {
        const char* name;
        int words;
    } known[] = {{"-blendu", 1}, {"-blendv", 1}, {"-cc", 1},     {"-clamp", 1}, {"-bm", 1},
                 {"-boost", 1},  {"-mm", 2},     {"-texres", 1}, {"-type", 1},  {"-imfchan", 1}};
    float values[3];
    int count;
    if (stp_word_is(at, word, "-s") || stp_word_is(at, word, "-o") || stp_word_is(at, word, "-t")) {
        stp_text next = read_values(word, values, 3, &count);
        float* target = stp_word_is(at, word, "-s")   ? options->scale
                        : stp_word_is(at, word, "-o") ? options->offset
                                                      : NULL;
        for (int i = 0; target != NULL && i < count && i < 2; ++i) {
            target[i] = values[i];
        }
        return next;
    }
    for (size_t i = 0; i < sizeof(known) / sizeof(known[0]); ++i) {
        if (stp_word_is(at, word, known[i].name)) {
            stp_text value = stp_skip_blanks(word);
            stp_text next = value;
            for (int k = 0; k < known[i].words; ++k) {
                next = stp_skip_word(stp_skip_blanks(next));
            }
            if (stp_word_is(at, word, "-clamp")) {
                options->wrap = stp_word_is(value, next, "on") ? STP_WRAP_CLAMP : STP_WRAP_REPEAT;
            }
            return next;
        }
    }
    return NULL;
}

static stp_result copy_rest(mtl* m, stp_text at, const char** text)
{
    at = stp_skip_blanks(at);
    assert(at < m->end && m->end[-1] == '\n');
    stp_text end = memchr(at, '\n', (size_t)(m->end - at));
    while (end > at && stp_is_blank(end[-1])) {
        --end;
    }
    if (end - at >= 2 && *at == '"' && end[-1] == '"') {
        at += 1;
        end -= 1;
    }
    size_t length = (size_t)(end - at);
    *text = stp_arena_copy_text(&m->import->scene->text, (const char*)at,
                                length < 4096 ? length : 4096);
    return *text != NULL ? STP_OK : stp_fail_memory(m->import->context);
}

static stp_result read_map(mtl* m, stp_text at, map_options* options)
{
    *options = (map_options){.scale = {1, 1}, .wrap = STP_WRAP_REPEAT};
    for (;;) {
        at = stp_skip_blanks(at);
        stp_text next = *at == '-' ? skip_option(at, stp_skip_word(at), options) : NULL;
        if (next == NULL) {
            return copy_rest(m, at, &options->name);
        }
        at = next;
    }
}

static stp_result read_texture(mtl* m, stp_text at, stp_texture_use* use)
{
    map_options options;
    stp_result result = read_map(m, at, &options);
    if (result != STP_OK || options.name[0] == '\0') {
        return result;
    }
    result = stp_pictures_read(&m->pictures, m->name, options.name, options.wrap, &use->texture);
    // the file's v runs upwards: v_file = 1 - v, and the result is turned back likewise
    use->transform[0][0] = options.scale[0];
    use->transform[0][2] = options.offset[0];
    use->transform[1][1] = options.scale[1];
    use->transform[1][2] = 1.0f - options.scale[1] - options.offset[1];
    return result;
}

// map_d: the alpha of its picture, or the red channel if that picture is opaque, becomes the alpha
// of the base colour's picture, which must have the same size.
static stp_result apply_alpha_map(mtl* m)
{
    stp_scene* scene = m->import->scene;
    uint32_t color = m->material.base_color_texture.texture, alpha;
    if (m->alpha_map == NULL || color == STP_NONE) {
        return STP_OK;
    }
    assert(color < scene->texture_count);
    stp_wrap wrap = scene->textures[color].wrap_u;
    stp_result result = stp_pictures_read(&m->pictures, m->name, m->alpha_map, wrap, &alpha);
    if (result != STP_OK || alpha == STP_NONE) {
        return result;
    }
    stp_texture merged = scene->textures[color];
    merged.encoded = NULL; // neither picture is the merged one
    merged.encoded_size = 0;
    merged.encoding = STP_TEXTURE_TEXELS;
    const stp_texture* mask = &scene->textures[alpha];
    if (mask->width != merged.width || mask->height != merged.height) {
        stp_warn(m->import->context,
                 "%s: %s: \"%s\" is left out: its size differs from that of the colours",
                 m->import->path, m->name, m->alpha_map);
        return STP_OK;
    }
    size_t texels = (size_t)merged.width * merged.height;
    bool has_alpha = false;
    for (size_t i = 0; i < texels && !has_alpha; ++i) {
        has_alpha = mask->texels[4 * i + 3] != 255;
    }
    m->material.alpha_mode = STP_ALPHA_MASK;
    if (alpha == color && has_alpha) {
        return STP_OK;
    }
    const uint8_t *colors = merged.texels, *values = mask->texels;
    merged.texels = STP_NEW_ARRAY(m->import->context, uint8_t, 4 * texels);
    if (merged.texels == NULL) {
        return stp_fail_memory(m->import->context);
    }
    for (size_t i = 0; i < 4 * texels; i += 4) {
        memcpy(merged.texels + i, colors + i, 3);
        merged.texels[i + 3] = has_alpha ? values[i + 3] : values[i];
    }
    return stp_scene_add_texture(scene, &merged, &m->material.base_color_texture.texture);
}

static stp_result end_material(mtl* m)
{
    if (m->name == NULL) {
        return STP_OK;
    }
    size_t length = strlen(m->name);
    if (stp_lookup_find(m->names, m->name, length, STP_NONE) != STP_NONE) {
        return STP_OK; // the first definition of a name wins
    }
    if (m->has_heights && m->material.normal_texture.texture == STP_NONE) {
        stp_losses_add(&m->import->losses, STP_LOSS_HEIGHT_MAP, 1);
    }
    stp_result result = apply_alpha_map(m);
    if (result != STP_OK) {
        return result;
    }
    stp_material* material = &m->material;
    if (!m->has_opacity && m->transparency >= 0.0f && m->transparency < 1.0f) {
        material->base_color[3] = 1.0f - m->transparency;
    }
    if (material->base_color[3] < 1.0f && material->alpha_mode == STP_ALPHA_OPAQUE) {
        material->alpha_mode = STP_ALPHA_BLEND;
    }
    material->name = m->name;
    uint32_t index, kept;
    result = stp_scene_add_material(m->import->scene, material, &index);
    return result == STP_OK ? stp_lookup_add(m->names, m->name, length, index, &kept) : result;
}

static stp_result begin_material(mtl* m, stp_text at)
{
    stp_result result = end_material(m);
    m->material = stp_material_plain();
    m->alpha_map = NULL;
    m->has_roughness = m->has_opacity = m->has_heights = false;
    m->transparency = -1.0f;
    return result == STP_OK ? copy_rest(m, at, &m->name) : result;
}

static void read_numbers(mtl* m, stp_text at, stp_text word)
{
    float value;
    int count;
    (void)read_values(word, &value, 1, &count);
    if (count == 0) {
        return;
    }
    stp_material* material = &m->material;
    float unit = stp_clamp(value, 0.0f, 1.0f);
    if (stp_word_is(at, word, "d")) {
        material->base_color[3] = unit;
        m->has_opacity = true;
    } else if (stp_word_is(at, word, "tr")) {
        m->transparency = unit;
    } else if (stp_word_is(at, word, "pm")) {
        material->metallic = unit;
    } else if (stp_word_is(at, word, "pr")) {
        material->roughness = unit;
        m->has_roughness = true;
    } else if (stp_word_is(at, word, "ns") && !m->has_roughness && value >= 0.0f) {
        // a Blinn-Phong exponent n has about the highlight of roughness alpha = sqrt(2 / (n + 2)) =
        // r^2
        material->roughness = sqrtf(sqrtf(2.0f / (value + 2.0f)));
    }
}

static stp_result read_line(mtl* m, stp_text at)
{
    at = stp_skip_blanks(at);
    stp_text word = stp_skip_word(at);
    if (stp_word_is(at, word, "newmtl")) {
        return begin_material(m, word);
    }
    if (m->name == NULL) {
        return STP_OK;
    }
    if (stp_word_is(at, word, "kd")) {
        read_color(word, m->material.base_color);
    } else if (stp_word_is(at, word, "ke")) {
        read_color(word, m->material.emissive);
    } else if (stp_word_is(at, word, "map_kd")) {
        return read_texture(m, word, &m->material.base_color_texture);
    } else if (stp_word_is(at, word, "map_ke")) {
        return read_texture(m, word, &m->material.emissive_texture);
    } else if (stp_word_is(at, word, "map_bump") || stp_word_is(at, word, "bump")) {
        m->has_heights = true;
    } else if (stp_word_is(at, word, "norm") || stp_word_is(at, word, "map_kn")) {
        return read_texture(m, word, &m->material.normal_texture);
    } else if (stp_word_is(at, word, "map_d")) {
        map_options options;
        stp_result result = read_map(m, word, &options);
        m->alpha_map = result == STP_OK && options.name[0] != '\0' ? options.name : NULL;
        return result;
    } else {
        read_numbers(m, at, word);
    }
    return STP_OK;
}

static stp_result read_lines(mtl* m, stp_text at)
{
    stp_result result = STP_OK;
    while (at < m->end && result == STP_OK) {
        result = read_line(m, at);
        at = (stp_text)memchr(at, '\n', (size_t)(m->end - at)) + 1;
    }
    return result == STP_OK ? end_material(m) : result;
}

stp_result stp_mtl_parse(stp_import* import, const unsigned char* bytes, size_t size,
                         stp_lookup* names)
{
    size_t mark = stp_text_mark(bytes, size);
    unsigned char* text = stp_alloc(import->context, size - mark + 1);
    if (text == NULL) {
        return stp_fail_memory(import->context);
    }
    size -= mark;
    if (size != 0) {
        memcpy(text, bytes + mark, size);
        if (stp_whole_lines(text, size) == 0) {
            stp_text_end_lines(text, size);
        }
    }
    text[size] = '\n';
    mtl m = {.import = import,
             .names = names,
             .pictures = stp_pictures_create(import),
             .end = text + size + 1};
    stp_result result = read_lines(&m, text);
    stp_pictures_destroy(&m.pictures);
    stp_free(import->context, text);
    return result;
}

stp_result stp_mtl_read(stp_import* import, const char* path, stp_lookup* names)
{
    stp_mapped_file file;
    stp_result result = stp_file_map(import->context, path, &file);
    if (result == STP_OK) {
        result = stp_mtl_parse(import, file.bytes, file.size, names);
        stp_file_unmap(&file);
    }
    return result;
}

// SPDX-License-Identifier: MIT
#include "program/drawing/draw_options.h"

#include "lod/method.h"
#include "program/options/cloud_style.h"
#include "program/options/cue_names.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { HYBRID_ON, HYBRID_NODES, HYBRID_OFF };
enum { PIXEL_FILTER_AUTO, PIXEL_FILTER_ON, PIXEL_FILTER_OFF };
enum { TRANSPARENCY_AUTO, TRANSPARENCY_LAYERS, TRANSPARENCY_PATTERN, TRANSPARENCY_NEAREST };

static size_t copy_options(option* table, size_t used, const option* from)
{
    for (; from != NULL && from->name != NULL; ++from) {
        assert(used + 1 < OPTION_TABLE_ROOM && "OPTION_TABLE_ROOM is too small");
        table[used++] = *from;
    }
    table[used] = (option){0};
    return used;
}

static size_t add_quality_options(option* table, size_t used, draw_options* o)
{
    const option list[] = {
        {.name = "json",
         .help = "print figures as one JSON object",
         .value = &o->json,
         .group = "Output"},
        {.name = "fov",
         .type = OPTION_NUMBER,
         .argument = "DEG",
         .words = "0.001..179.9",
         .help =
             "vertical field of view; default that of the view; of standard views 40, with --eye "
             "or --target 60",
         .value = &o->fov,
         .group = "Camera",
         .rare = true},
        {.name = "budget-ms",
         .type = OPTION_NUMBER,
         .argument = "MS",
         .words = "0.1..1e6",
         .help = "choose the splat size so that a frame takes MS milliseconds: from 1 pixel up "
                 "to 8 (--controller paper), or up to 24 if 8 is not enough; then the CPU draws "
                 "fewer pixels, and enlarges the picture",
         .value = &o->budget_ms,
         .group = "Quality"},
        {.name = "controller",
         .type = OPTION_CHOICE,
         .argument = "NAME",
         .words = "predict|paper",
         .help = "control of --budget-ms: predict (a cost model) or paper (Brandt 4.3); default "
                 "predict",
         .value = &o->controller,
         .rare = true},
        {.name = "prefix",
         .type = OPTION_PARTIAL_FILE,
         .argument = "SIZE|P%",
         .help = "draw as if the .stip file ended after this many bytes (64K) or this share of "
                 "it (5%)",
         .value = &o->partial_file,
         .rare = true},
        {.name = "method",
         .type = OPTION_CHOICE,
         .argument = "NAME",
         .words = TOOL_METHOD_WORDS,
         .help = "method to draw if the file has several; default the first, combined with psp "
                 "where few splats suffice if the first is blue",
         .value = &o->method,
         .given = &o->has_method,
         .rare = true},
        {.name = "hybrid",
         .type = OPTION_CHOICE,
         .words = "on|nodes|off",
         .help = "on: draw triangles where splats are too coarse, and large triangles beside "
                 "small splats (spt); nodes: draw each node by triangles or by splats; off: draw "
                 "only splats, however near; default on",
         .value = &o->hybrid,
         .rare = true},
        {0},
    };
    return copy_options(table, used, list);
}

static size_t add_effect_options(option* table, size_t used, draw_options* o)
{
    const option list[] = {
        {.name = "splat-texture",
         .type = OPTION_TEXT,
         .argument = "FILE.png",
         .help = "opacity map for --filter textured, mapped to each splat's ellipse: the alpha "
                 "of a picture, or its brightness if it is opaque; default a Gaussian",
         .value = &o->splat_texture,
         .group = "Effects",
         .rare = true},
        {.name = "transparency",
         .type = OPTION_CHOICE,
         .argument = "NAME",
         .words = "auto|layers|pattern|nearest",
         .help =
             "transparent surfaces: layers (all, sorted), nearest (one layer, as opaque as all) or "
             "pattern (dithered); default auto: layers, but nearest in fly without "
             "--budget-ms; --budget-ms draws nearest, then pattern, in place of layers where those "
             "take too long",
         .value = &o->transparency,
         .rare = true},
        {.name = "pixel-filter",
         .type = OPTION_CHOICE,
         .argument = "NAME",
         .words = "auto|on|off",
         .help = "calm what aliases: each pixel of a picture with one sample becomes a mean of "
                 "itself and its neighbours; default auto: on with --budget-ms and in fly, "
                 "but not with --reference",
         .value = &o->pixel_filter,
         .rare = true},
        OPTION_CUES(&o->cues),
        {0},
    };
    return copy_options(table, used, list);
}

static size_t add_eye_options(option* table, size_t used, draw_options* o)
{
    const option list[] = {
        {.name = "stereo",
         .help = "draw the views of two eyes side by side; --size is the size of both together",
         .value = &o->stereo,
         .group = "Eyes",
         .rare = true},
        {.name = "ipd",
         .type = OPTION_NUMBER,
         .argument = "M",
         .words = "0.0001..1000",
         .help = "distance between the eyes in metres (in scene units if the unit is not known); "
                 "default 0.064",
         .value = &o->ipd,
         .rare = true},
        {.name = "fovea",
         .type = OPTION_TEXT,
         .argument = "R:S,R:S",
         .help = "foveated splat size: factor S at radius R (in half diagonals from the centre), "
                 "linear between these and 0:1, constant beyond the last; with --stereo in each "
                 "eye",
         .value = &o->fovea,
         .rare = true},
        {.name = "fovea-center",
         .type = OPTION_TEXT,
         .argument = "X,Y",
         .help = "gaze position for --fovea: right and down from the centre, in half diagonals",
         .value = &o->fovea_center,
         .rare = true},
        {0},
    };
    return copy_options(table, used, list);
}

static size_t add_machine_options(option* table, size_t used, draw_options* o)
{
    const option list[] = {
        {.name = "backend",
         .type = OPTION_CHOICE,
         .argument = "NAME",
         .words = "auto|cpu|gl",
         .help = "renderer: cpu, gl (OpenGL 4.5) or auto (gl if there is a GPU, else cpu); "
                 "default auto",
         .value = &o->backend,
         .group = "Machine",
         .rare = true},
        OPTION_GL_SPLATS(&o->gl_splats),
        OPTION_THREADS(&o->threads),
        OPTION_MEMORY(&o->memory),
        {0},
    };
    return copy_options(table, used, list);
}

const option* draw_options_table(option* table, const option* own, draw_options* options)
{
    const option first[] = {
        {.name = "size",
         .type = OPTION_PIXELS,
         .argument = "WxH",
         .help = "size of the picture in pixels; default 1920x1080",
         .value = options->size,
         .group = "Picture"},
        {0},
    };
    const option points[] = {OPTION_POINT_SIZE(&options->point_size, "adaptive"), {0}};
    option colors[POINT_COLOR_OPTION_ROOM], show[SHOW_OPTION_ROOM], drawing[DRAWING_OPTION_ROOM];
    size_t used = copy_options(table, 0, first);
    used = copy_options(table, used, own);
    used = add_quality_options(table, used, options);
    used = copy_options(table, used, point_color_options_table(colors, &options->colors));
    used = copy_options(table, used, points);
    used = copy_options(table, used, show_options_table(show, &options->show));
    used = copy_options(table, used, drawing_options_table(drawing, &options->settings));
    used = add_effect_options(table, used, options);
    used = add_eye_options(table, used, options);
    add_machine_options(table, used, options);
    return table;
}

/// Splits two numbers at a separator. @return the text after the separator, or NULL on a syntax
/// error
static const char* read_pair(const char* text, char between, float pair[2])
{
    for (int i = 0; i < 2; ++i) {
        char* end;
        if (strchr("+-.0123456789", *text) == NULL || *text == 0) {
            return NULL;
        }
        pair[i] = strtof(text, &end);
        if (end == text || (i == 0 && *end != between)) {
            return NULL;
        }
        text = end + (i == 0);
    }
    return text;
}

/// @return false if the text is not a list of zones
static bool parse_fovea(const draw_options* o, stp_fovea* fovea)
{
    *fovea = (stp_fovea){0};
    for (const char* at = o->fovea; at != NULL;) {
        float pair[2];
        at = fovea->count < STP_FOVEA_ZONES ? read_pair(at, ':', pair) : NULL;
        if (at == NULL || !(pair[0] >= 0.0f && pair[0] <= 2.0f) ||
            !(pair[1] >= 0.125f && pair[1] <= 64.0f) || (*at != ',' && *at != 0)) {
            return false;
        }
        fovea->zones[fovea->count++] = (stp_fovea_zone){pair[0], pair[1]};
        at = *at == ',' ? at + 1 : NULL;
    }
    return stp_fovea_is_valid(fovea);
}

static bool parse_fovea_center(const draw_options* o, stp_fovea* fovea)
{
    if (o->fovea_center == NULL) {
        return true;
    }
    const char* end = read_pair(o->fovea_center, ',', fovea->center);
    return end != NULL && *end == 0 && fabsf(fovea->center[0]) <= 1.0f &&
           fabsf(fovea->center[1]) <= 1.0f;
}

/// @return 0, or 2 (message printed)
static int check_eyes(const draw_options* o)
{
    stp_fovea fovea;
    if (!parse_fovea(o, &fovea)) {
        return tool_usage_error(
            "--fovea must be R:S,R:S, with at most %d zones with ascending radii from 0 "
            "to 2 and factors from 0.125 to 64, not %s",
            STP_FOVEA_ZONES, o->fovea);
    }
    if (!parse_fovea_center(o, &fovea)) {
        return tool_usage_error("--fovea-center must be X,Y, both from -1 to 1, not %s",
                                o->fovea_center);
    }
    if (o->fovea_center != NULL && o->fovea == NULL) {
        return tool_usage_error("--fovea-center requires --fovea");
    }
    bool counts = o->settings.quality.splat_count > 0;
    if (o->fovea != NULL && (counts || o->settings.quality.reference)) {
        return tool_usage_error("--fovea and %s exclude each other",
                                counts ? "--splats" : "--reference");
    }
    if (o->ipd > 0.0 && !o->stereo) {
        return tool_usage_error("--ipd requires --stereo");
    }
    if (o->stereo && o->size[0] % 2 != 0) {
        return tool_usage_error("--stereo needs an even width, not %u", o->size[0]);
    }
    return 0;
}

int draw_options_check(const draw_options* o)
{
    const stp_quality* q = &o->settings.quality;
    const stp_draw_style* style = &o->settings.style;
    bool sized = q->splat_size > 0.0f, counts = q->splat_count > 0;
    if (sized && counts) {
        return tool_usage_error("--splat-size and --splats exclude each other");
    }
    if (o->budget_ms > 0.0 && (sized || counts || q->reference)) {
        return tool_usage_error("--budget-ms and %s exclude each other", q->reference
                                                                             ? "--reference"
                                                                         : sized ? "--splat-size"
                                                                                 : "--splats");
    }
    if (style->splat_shape != STP_SPLAT_DISK && style->filter != STP_FILTER_NONE) {
        return tool_usage_error("--splat-shape square and --filter exclude each other");
    }
    if (o->splat_texture != NULL && style->filter != STP_FILTER_TEXTURED) {
        return tool_usage_error("--splat-texture requires --filter textured");
    }
    cloud_point_size size;
    if (o->point_size != NULL && !cloud_style_read_size(o->point_size, &size)) {
        return cloud_style_refuse_size(o->point_size);
    }
    uint32_t cues_off;
    if (!cue_names_parse(o->cues, &cues_off)) {
        return cue_names_refuse(o->cues);
    }
    if (style->filter != STP_FILTER_NONE &&
        (o->colors.color == POINT_COLOR_ELEVATION || o->colors.color == POINT_COLOR_NORMAL)) {
        return tool_usage_error("--filter and --color %s exclude each other",
                                point_color_name(o->colors.color));
    }
    int code = point_colors_check(&o->colors);
    code = code != 0 ? code : show_options_check(&o->show);
    return code != 0 ? code : check_eyes(o);
}

static bool fixes_points(const draw_options* o)
{
    cloud_point_size size;
    return o->point_size != NULL && cloud_style_read_size(o->point_size, &size) && size.width > 0.0;
}

stp_quality draw_options_quality(const draw_options* o)
{
    // only sets of blue and stochastic have point attributes and sizes; psp would be drawn beside
    // blue where few splats suffice. A file without blue draws its first method
    bool points = point_colors_need_points(&o->colors) || fixes_points(o);
    uint32_t by_default = points ? STP_METHOD_BLUE : 0;
    stp_quality quality = o->settings.quality;
    quality.method = o->has_method ? stp_methods[o->method].id : by_default;
    quality.splats_only = o->hybrid == HYBRID_OFF;
    quality.nodes_only = o->hybrid == HYBRID_NODES;
    quality.points_apart = points;
    bool cues = cue_names_parse(o->cues, &quality.cues_off);
    bool zones = parse_fovea(o, &quality.fovea);
    bool center = parse_fovea_center(o, &quality.fovea);
    assert(cues && zones && center && "draw_options_check was called");
    (void)cues;
    (void)zones;
    (void)center;
    return quality;
}

int tool_check_method(uint32_t id, const stp_store* store, const char* path)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    if (id == 0 || d->set_count == 0 || d->methods[stp_store_find_method(d, id)].id == id) {
        return 0;
    }
    const char* name = stp_method_by_id(id)->name;
    return tool_error("%s: has splats by %s, not by %s (build it with --method %s)", path,
                      d->methods[0].name, name, name);
}

int draw_options_check_method(const draw_options* o, const stp_store* store, const char* path)
{
    return tool_check_method(o->has_method ? stp_methods[o->method].id : 0, store, path);
}

const char* draw_options_method(const draw_options* o, const stp_store* store)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    uint32_t id = o->has_method ? stp_methods[o->method].id : 0;
    return d->set_count > 0 ? d->methods[stp_store_find_method(d, id)].name : NULL;
}

const char* draw_options_coarse_method(const draw_options* o, const stp_store* store)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    const stp_quality quality = draw_options_quality(o);
    uint32_t method = stp_select_coarse_method(d, &quality);
    return method < stp_store_offered_methods(d) ? d->methods[method].name : NULL;
}

stp_draw_style draw_options_style(const draw_options* o)
{
    static const stp_transparency transparencies[] = {
        [TRANSPARENCY_LAYERS] = STP_TRANSPARENCY_LAYERS,
        [TRANSPARENCY_PATTERN] = STP_TRANSPARENCY_PATTERN,
        [TRANSPARENCY_NEAREST] = STP_TRANSPARENCY_NEAREST,
    };
    bool decides = o->budget_ms > 0.0 && o->controller == STP_CONTROLLER_PREDICT; // for each frame
    bool moves = o->in_motion && !decides;
    int by_default = moves ? TRANSPARENCY_NEAREST : TRANSPARENCY_LAYERS;
    stp_draw_style style = o->settings.style;
    style.transparency =
        transparencies[o->transparency == TRANSPARENCY_AUTO ? by_default : o->transparency];
    bool filters = (o->in_motion || o->budget_ms > 0.0) && !o->settings.quality.reference;
    style.pixel_filter =
        o->pixel_filter == PIXEL_FILTER_AUTO ? filters : o->pixel_filter == PIXEL_FILTER_ON;
    return style;
}

stp_view draw_options_view(const draw_options* o)
{
    return (stp_view){.width = o->size[0] != 0 ? o->size[0] : 1920,
                      .height = o->size[1] != 0 ? o->size[1] : 1080,
                      .fov_degrees = o->fov};
}

double draw_options_eye_distance(const draw_options* o, const stp_store* store)
{
    double unit = stp_store_get_directory(store)->unit_metres;
    double metres = o->ipd > 0.0 ? o->ipd : 0.064;
    return !o->stereo ? 0.0 : unit > 0.0 ? metres / unit : metres;
}

static bool asks_for_splats(const draw_options* o)
{
    const stp_quality* q = &o->settings.quality;
    return q->splat_size > 0.0f || q->splat_count > 0 || o->budget_ms > 0.0 ||
           o->settings.style.splat_scale > 0.0f || o->fovea != NULL ||
           point_colors_need_points(&o->colors) || fixes_points(o) ||
           q->policy != STP_POLICY_INSERTION;
}

bool draw_options_leave_quality(const draw_options* o)
{
    return !asks_for_splats(o) && !o->settings.quality.reference &&
           o->settings.style.supersample == 0;
}

/// If no option refers to splats, a picture should be ready soon.
scene_use draw_options_use(const draw_options* o)
{
    scene_use use = scene_use_of_method(o->has_method ? stp_methods[o->method].id : 0);
    if (o->settings.quality.reference) {
        return SCENE_FOR_ORIGINALS;
    }
    return use == SCENE_FOR_METHODS || asks_for_splats(o) ? use : SCENE_FOR_A_PICTURE;
}

// SPDX-License-Identifier: MIT
#include "program/drawing/draw_options.h"

#include "lod/method.h"
#include "program/options/cloud_style.h"
#include "program/options/cue_names.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LIGHT_SUN, LIGHT_HEAD };
enum { CAPS_ON, CAPS_OFF };
enum { HYBRID_ON, HYBRID_NODES, HYBRID_OFF };
enum { CLUSTERS_ON, CLUSTERS_OFF };
enum { TRANSPARENCY_AUTO, TRANSPARENCY_LAYERS, TRANSPARENCY_PATTERN };

static size_t copy_options(option* table, size_t used, const option* from)
{
    for (; from != NULL && from->name != NULL; ++from) {
        assert(used + 1 < DRAW_OPTION_ROOM && "DRAW_OPTION_ROOM is too small");
        table[used++] = *from;
    }
    table[used] = (option){0};
    return used;
}

static size_t add_quality_options(option* table, size_t used, draw_options* o)
{
    const option list[] = {
        {.name = "splat-size",
         .type = OPTION_NUMBER,
         .argument = "PX",
         .words = "1..64",
         .help = "splat size in pixels; default 1",
         .value = &o->splat_size,
         .given = &o->has_splat_size},
        {.name = "epsilon",
         .type = OPTION_NUMBER,
         .argument = "PX",
         .words = "1..64",
         .help = "same as --splat-size: the allowed error of point trees (spt)",
         .value = &o->splat_size,
         .given = &o->has_splat_size},
        {.name = "splats",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "1..4294967294",
         .help = "draw exactly N splats, or all if there are fewer (spt: at most N); triangles "
                 "are used only for objects that no splats represent, for example with --hide",
         .value = &o->splats,
         .given = &o->has_splats},
        {.name = "budget-ms",
         .type = OPTION_NUMBER,
         .argument = "MS",
         .words = "0.1..1e6",
         .help = "choose the splat size so that a frame takes MS milliseconds: from 1 pixel up "
                 "to 8 (--controller paper), or up to 24 if 8 is not enough",
         .value = &o->budget_ms,
         .given = &o->has_budget},
        {.name = "controller",
         .type = OPTION_CHOICE,
         .argument = "NAME",
         .words = "predict|paper",
         .help = "control of --budget-ms: predict (a cost model) or paper (Brandt 4.3); default "
                 "predict",
         .value = &o->controller},
        {.name = "splat-scale",
         .type = OPTION_NUMBER,
         .argument = "F",
         .words = "0.01..100",
         .help = "scale factor of the drawn splats: 0.3 shows how they are distributed",
         .value = &o->splat_scale},
        {.name = "method",
         .type = OPTION_CHOICE,
         .argument = "NAME",
         .words = TOOL_METHOD_WORDS,
         .help = "method to draw if the file has several; default the first, combined with psp "
                 "where few splats suffice if the first is blue",
         .value = &o->method,
         .given = &o->has_method},
        {.name = "hybrid",
         .type = OPTION_CHOICE,
         .words = "on|nodes|off",
         .help = "on: draw triangles where splats are too coarse, and large triangles beside "
                 "small splats (spt); nodes: draw each node by triangles or by splats; off: draw "
                 "only splats, however near",
         .value = &o->hybrid},
        {.name = "normal-clusters",
         .type = OPTION_CHOICE,
         .words = "on|off",
         .help = "spt: skip groups of splats that face away; default on",
         .value = &o->normal_clusters},
        OPTION_CUES(&o->cues),
        {.name = "policy",
         .type = OPTION_CHOICE,
         .argument = "NAME",
         .words = "insertion|paper|switch",
         .help = "number of splats per node: insertion (insertion radius), paper (the estimate "
                 "of Brandt 4.1) or switch (no blending between levels); default insertion",
         .value = &o->policy},
        {.name = "reference",
         .help = "draw only original triangles and points",
         .value = &o->reference},
        {.name = "prefix",
         .type = OPTION_PARTIAL_FILE,
         .argument = "SIZE|P%",
         .help = "draw as if the .stip file ended after this many bytes (64K) or this share of "
                 "it (5%)",
         .value = &o->partial_file},
        {0},
    };
    return copy_options(table, used, list);
}

static size_t add_effect_options(option* table, size_t used, draw_options* o)
{
    const option list[] = {
        {.name = "filter",
         .type = OPTION_CHOICE,
         .argument = "NAME",
         .words = "none|ewa|blend|textured",
         .help = "none: show the nearest splat; ewa: blend overlapping splats, weighted by "
                 "distance from their centres; blend: faster and less exact, in one pass (OpenGL "
                 "only); textured: weighted by --splat-texture; default none",
         .value = &o->filter},
        {.name = "splat-texture",
         .type = OPTION_TEXT,
         .argument = "FILE.png",
         .help = "opacity map for --filter textured, mapped to each splat's ellipse: the alpha "
                 "of a picture, or its brightness if it is opaque; default a Gaussian",
         .value = &o->splat_texture},
        {.name = "splat-shape",
         .type = OPTION_CHOICE,
         .argument = "SHAPE",
         .words = "disk|square",
         .help = "shape of unfiltered splats: disk (disks and ellipses in the surface) or square "
                 "(on the screen, like hardware points); default disk",
         .value = &o->splat_shape},
        OPTION_POINT_SIZE(&o->point_size),
        {.name = "transparency",
         .type = OPTION_CHOICE,
         .argument = "NAME",
         .words = "auto|layers|pattern",
         .help =
             "transparent surfaces: layers (sorted, without noise) or pattern (dithered, in one "
             "pass); default auto: pattern with --budget-ms and in flights, else layers",
         .value = &o->transparency},
        {.name = "eye-dome",
         .type = OPTION_NUMBER,
         .argument = "[STRENGTH]",
         .words = "off|0..100",
         .fallback = "1",
         .help = "strength of eye-dome lighting, which darkens surfaces behind nearer edges; 0 "
                 "or off: none; default 1 if the scene has only points, else off",
         .value = &o->eye_dome,
         .given = &o->has_eye_dome},
        {.name = "ambient-occlusion",
         .type = OPTION_NUMBER,
         .argument = "[RADIUS]",
         .words = "0.1..12",
         .fallback = "4",
         .help = "ambient occlusion: darken enclosed surfaces within a radius in percent of the "
                 "picture's height; default 4",
         .value = &o->ambient_occlusion},
        {.name = "caps",
         .type = OPTION_CHOICE,
         .argument = "on|off",
         .words = "on|off",
         .help = "fill solids where sections cut them; open surfaces stay open; default on",
         .value = &o->caps},
        {0},
    };
    return copy_options(table, used, list);
}

static size_t add_eye_options(option* table, size_t used, draw_options* o)
{
    const option list[] = {
        {.name = "fovea",
         .type = OPTION_TEXT,
         .argument = "R:S,R:S",
         .help = "foveated splat size: factor S at radius R (in half diagonals from the centre), "
                 "linear between these and 0:1, constant beyond the last; with --stereo in each "
                 "eye",
         .value = &o->fovea},
        {.name = "fovea-center",
         .type = OPTION_TEXT,
         .argument = "X,Y",
         .help = "gaze position for --fovea: right and down from the centre, in half diagonals",
         .value = &o->fovea_center},
        {.name = "stereo",
         .help = "draw the views of two eyes side by side; --size is the size of both together",
         .value = &o->stereo},
        {.name = "ipd",
         .type = OPTION_NUMBER,
         .argument = "M",
         .words = "0.0001..1000",
         .help = "distance between the eyes in metres (in scene units if the unit is not known); "
                 "default 0.064",
         .value = &o->ipd,
         .given = &o->has_ipd},
        {0},
    };
    return copy_options(table, used, list);
}

static size_t add_picture_options(option* table, size_t used, draw_options* o)
{
    const option list[] = {
        {.name = "size",
         .type = OPTION_PIXELS,
         .argument = "WxH",
         .help = "size of the picture in pixels; default 1920x1080",
         .value = o->size},
        {.name = "fov",
         .type = OPTION_NUMBER,
         .argument = "DEG",
         .words = "1..179",
         .help = "vertical field of view; default that of the view, or 60",
         .value = &o->fov,
         .given = &o->has_fov},
        {.name = "backend",
         .type = OPTION_CHOICE,
         .argument = "NAME",
         .words = "auto|cpu|gl",
         .help = "renderer: cpu, gl (OpenGL 4.5) or auto (gl if there is a GPU, else cpu); "
                 "default auto",
         .value = &o->backend},
        OPTION_GL_SPLATS(&o->gl_splats),
        {.name = "supersample",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "1..16",
         .help = "N x N samples per pixel; default 1",
         .value = &o->supersample},
        {.name = "light",
         .type = OPTION_CHOICE,
         .argument = "NAME",
         .words = "sun|head",
         .help = "light from above the viewer's left shoulder (sun), or from the viewer (head); "
                 "default sun",
         .value = &o->light},
        {.name = "background",
         .type = OPTION_COLOR,
         .argument = "COLOR",
         .help = "background colour: a CSS name such as white, or hexadecimal such as #dfe3e8; "
                 "default none (transparent)",
         .value = o->background,
         .given = &o->has_background},
        OPTION_THREADS(&o->threads),
        OPTION_MEMORY(&o->memory),
        {.name = "json", .help = "print figures as one JSON object", .value = &o->json},
        {0},
    };
    return copy_options(table, used, list);
}

const option* draw_options_table(option* table, const option* own, draw_options* options)
{
    size_t used = copy_options(table, 0, own);
    used = add_quality_options(table, used, options);
    used = add_effect_options(table, used, options);
    option colors[POINT_COLOR_OPTION_ROOM];
    used = copy_options(table, used, point_color_options_table(colors, &options->colors));
    used = add_eye_options(table, used, options);
    option show[SHOW_OPTION_ROOM];
    used = copy_options(table, used, show_options_table(show, &options->show));
    add_picture_options(table, used, options);
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
    if (o->fovea != NULL && (o->has_splats || o->reference)) {
        return tool_usage_error("--fovea and %s exclude each other",
                                o->has_splats ? "--splats" : "--reference");
    }
    if (o->has_ipd && !o->stereo) {
        return tool_usage_error("--ipd requires --stereo");
    }
    if (o->stereo && o->size[0] % 2 != 0) {
        return tool_usage_error("--stereo needs an even width, not %u", o->size[0]);
    }
    return 0;
}

int draw_options_check(const draw_options* o)
{
    if (o->has_splat_size && o->has_splats) {
        return tool_usage_error("--splat-size and --splats exclude each other");
    }
    if (o->has_budget && (o->has_splat_size || o->has_splats || o->reference)) {
        return tool_usage_error("--budget-ms and %s exclude each other",
                                o->reference        ? "--reference"
                                : o->has_splat_size ? "--splat-size"
                                                    : "--splats");
    }
    if (o->splat_shape != STP_SPLAT_DISK && o->filter != STP_FILTER_NONE) {
        return tool_usage_error("--splat-shape square and --filter exclude each other");
    }
    if (o->splat_texture != NULL && o->filter != STP_FILTER_TEXTURED) {
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
    if (o->filter != STP_FILTER_NONE &&
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
    stp_quality quality = {.method = o->has_method ? stp_methods[o->method].id : by_default,
                           .splat_size = (float)o->splat_size,
                           .splat_count = o->splats,
                           .policy = (stp_policy)o->policy,
                           .splats_only = o->hybrid == HYBRID_OFF,
                           .nodes_only = o->hybrid == HYBRID_NODES,
                           .all_sides = o->normal_clusters == CLUSTERS_OFF,
                           .points_apart = points,
                           .reference = o->reference};
    (void)cue_names_parse(o->cues, &quality.cues_off);
    (void)parse_fovea(o, &quality.fovea);
    (void)parse_fovea_center(o, &quality.fovea);
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
    return method != STP_STORE_NONE ? d->methods[method].name : NULL;
}

stp_draw_style draw_options_style(const draw_options* o)
{
    bool moves = o->has_budget || o->in_motion;
    bool pattern =
        o->transparency == TRANSPARENCY_AUTO ? moves : o->transparency == TRANSPARENCY_PATTERN;
    stp_draw_style style = {.splat_scale = (float)o->splat_scale,
                            .supersample = (uint32_t)o->supersample,
                            .headlight = o->light == LIGHT_HEAD,
                            .background = o->has_background,
                            .filter = (stp_filter)o->filter,
                            .splat_shape = (stp_splat_shape)o->splat_shape,
                            .eye_dome = (float)o->eye_dome,
                            .ambient_occlusion = (float)(0.01 * o->ambient_occlusion),
                            .transparency =
                                pattern ? STP_TRANSPARENCY_PATTERN : STP_TRANSPARENCY_LAYERS,
                            .ghost = (float)o->show.ghost_share,
                            .caps = o->caps == CAPS_ON};
    if (style.background) {
        memcpy(style.background_color, o->background, sizeof(o->background));
    }
    return style;
}

stp_view draw_options_view(const draw_options* o)
{
    return (stp_view){.width = o->size[0] != 0 ? o->size[0] : 1920,
                      .height = o->size[1] != 0 ? o->size[1] : 1080,
                      .fov_degrees = o->has_fov ? o->fov : 0.0};
}

double draw_options_eye_distance(const draw_options* o, const stp_store* store)
{
    double unit = stp_store_get_directory(store)->unit_metres;
    double metres = o->has_ipd ? o->ipd : 0.064;
    return !o->stereo ? 0.0 : unit > 0.0 ? metres / unit : metres;
}

static bool asks_for_splats(const draw_options* o)
{
    return o->has_splat_size || o->has_splats || o->has_budget || o->splat_scale > 0.0 ||
           o->fovea != NULL || point_colors_need_points(&o->colors) || fixes_points(o) ||
           o->policy != STP_POLICY_INSERTION;
}

bool draw_options_leave_quality(const draw_options* o)
{
    return !asks_for_splats(o) && !o->reference && o->supersample == 0;
}

/// If no option refers to splats, a picture should be ready soon.
scene_use draw_options_use(const draw_options* o)
{
    scene_use use = scene_use_of_method(o->has_method ? stp_methods[o->method].id : 0);
    if (o->reference) {
        return SCENE_FOR_ORIGINALS;
    }
    return use == SCENE_FOR_METHODS || asks_for_splats(o) ? use : SCENE_FOR_A_PICTURE;
}

// SPDX-License-Identifier: MIT
#include "program/options/point_colors.h"

#include "program/options/cloud_style.h"
#include "program/options/tool.h"

#include <assert.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    HEIGHTS_MAX = 50000,
    COLORS_MAX = 1000,   ///< splats of a set whose colours are compared, and more of the octave
    COLOR_SETS_MAX = 64, ///< sets whose colours are compared: the last ones, which are coarse
    CLASSES = 256
};

static const stp_attribute attributes[POINT_COLORS] = {
    [POINT_COLOR_AUTO] = STP_ATTRIBUTES,
    [POINT_COLOR_RGB] = STP_ATTRIBUTES,
    [POINT_COLOR_INTENSITY] = STP_ATTRIBUTE_INTENSITY,
    [POINT_COLOR_ELEVATION] = STP_ATTRIBUTES,
    [POINT_COLOR_CLASS] = STP_ATTRIBUTE_CLASS,
    [POINT_COLOR_RETURN] = STP_ATTRIBUTE_RETURN,
    [POINT_COLOR_RETURNS] = STP_ATTRIBUTE_RETURNS,
    [POINT_COLOR_SCAN_ANGLE] = STP_ATTRIBUTE_SCAN_ANGLE,
    [POINT_COLOR_SOURCE] = STP_ATTRIBUTE_SOURCE,
    [POINT_COLOR_TIME] = STP_ATTRIBUTE_TIME,
    [POINT_COLOR_NEAR_INFRARED] = STP_ATTRIBUTE_NEAR_INFRARED,
    [POINT_COLOR_NORMAL] = STP_ATTRIBUTES,
};

stp_attribute point_color_attribute(int color)
{
    assert(color >= 0 && color < POINT_COLORS);
    return attributes[color];
}

const char* point_color_name(int color)
{
    static const char* const names[POINT_COLORS] = {
        "auto",    "rgb",        "intensity", "elevation", "class",         "return",
        "returns", "scan-angle", "source",    "time",      "near-infrared", "normal"};
    assert(color >= 0 && color < POINT_COLORS);
    return names[color];
}

const option* point_color_options_table(option* table, point_color_options* o)
{
    const option list[POINT_COLOR_OPTION_ROOM] = {
        {.name = "color",
         .type = OPTION_CHOICE,
         .argument = "NAME",
         .words = POINT_COLOR_WORDS,
         .help = "colour points by an attribute: a continuous scale from violet to yellow, or "
                 "distinct colours (class, return, returns, source); elevation and normal also "
                 "apply to meshes; rgb: their own colours; default auto: rgb, or elevation for "
                 "points or heights (HGT) without colours",
         .value = &o->color,
         .group = "Points"},
        {.name = "range",
         .type = OPTION_TEXT,
         .argument = "LO,HI",
         .help = "values at the ends of the colour scale; default the 2nd and 98th percentile; "
                 "elevations are in scene units",
         .value = &o->range,
         .rare = true},
        {.name = "classes",
         .type = OPTION_TEXT,
         .argument = "N,N",
         .help = "draw only points of these classes, by number (ASPRS: 2 ground, 6 building)",
         .value = &o->classes,
         .rare = true},
        {0},
    };
    memcpy(table, list, sizeof(list));
    return table;
}

/// Whether a colour uses the continuous scale, which has a range.
static bool has_range(int color)
{
    stp_attribute attribute = attributes[color];
    return color == POINT_COLOR_ELEVATION ||
           (attribute != STP_ATTRIBUTES && !stp_attribute_is_distinct(attribute));
}

static bool read_range(const char* text, double range[2])
{
    for (int i = 0; i < 2; ++i) {
        char* end;
        if (*text == '\0' || strchr("+-.0123456789", *text) == NULL) {
            return false;
        }
        range[i] = strtod(text, &end);
        if (end == text || !isfinite(range[i]) || *end != (i == 0 ? ',' : '\0')) {
            return false;
        }
        text = end + 1;
    }
    return range[0] < range[1];
}

/// Marks the classes of a list. @return false if the text is not a list of classes
static bool read_classes(const char* text, uint8_t shown[CLASSES])
{
    memset(shown, 0, CLASSES);
    for (bool more = true; more;) {
        char* end;
        if (*text < '0' || *text > '9') {
            return false;
        }
        errno = 0;
        unsigned long number = strtoul(text, &end, 10);
        if (errno != 0 || number >= CLASSES || (*end != ',' && *end != '\0')) {
            return false;
        }
        shown[number] = 1;
        more = *end == ',';
        text = end + 1;
    }
    return true;
}

bool point_colors_read_range(const char* text, double* low, double* high)
{
    double range[2];
    bool read = read_range(text, range);
    if (read) {
        *low = range[0];
        *high = range[1];
    }
    return read;
}

bool point_colors_read_classes(const char* text, uint8_t shown[CLASSES])
{
    return read_classes(text, shown);
}

int point_colors_check(const point_color_options* o)
{
    double range[2];
    uint8_t shown[CLASSES];
    if (o->range != NULL && !has_range(o->color)) {
        return tool_usage_error("--range requires --color intensity, elevation, time, scan-angle "
                                "or near-infrared");
    }
    if (o->range != NULL && !read_range(o->range, range)) {
        return tool_usage_error("--range must be LO,HI with the lower number first, not %s",
                                o->range);
    }
    if (o->classes != NULL && !read_classes(o->classes, shown)) {
        return tool_usage_error("--classes must be N,N with numbers from 0 to 255, not %s",
                                o->classes);
    }
    return 0;
}

bool point_colors_need_points(const point_color_options* o)
{
    return attributes[o->color] != STP_ATTRIBUTES || o->classes != NULL;
}

/// Whether any set of a method, or any point set, has values of an attribute.
static bool is_drawn(const stp_store* store, uint32_t method, bool reference, stp_attribute a)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    uint32_t bit = stp_attribute_bit(a);
    if (reference) {
        for (uint32_t i = 0; i < d->point_set_count; ++i) {
            if ((stp_store_point_attributes(store, i) & bit) != 0) {
                return true;
            }
        }
        return false;
    }
    assert(d->method_count == 0 || method < d->method_count);
    const stp_store_method* m = d->method_count > 0 ? &d->methods[method] : NULL;
    for (uint32_t i = 0; m != NULL && i < m->set_count; ++i) {
        uint32_t set = m->first_set + i;
        if (stp_store_describe_splat_set(store, set)->count != 0 &&
            (stp_store_octave_attributes(store, set, 0) & bit) != 0) {
            return true;
        }
    }
    return false;
}

/// Whether the splats of a method, or else the original points, have all requested attributes.
static bool draws_all(const point_color_options* o, const stp_store* store, uint32_t method,
                      bool reference)
{
    stp_attribute a = attributes[o->color];
    return (a == STP_ATTRIBUTES || is_drawn(store, method, reference, a)) &&
           (o->classes == NULL || is_drawn(store, method, reference, STP_ATTRIBUTE_CLASS));
}

uint32_t point_colors_find_method(const point_color_options* o, const stp_store* store,
                                  uint32_t preferred)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    uint32_t found = preferred < d->method_count && draws_all(o, store, preferred, false)
                         ? preferred
                         : STP_STORE_NONE;
    for (uint32_t m = 0; m < stp_store_offered_methods(d) && found == STP_STORE_NONE; ++m) {
        found = draws_all(o, store, m, false) ? m : found;
    }
    return found;
}

bool point_colors_has_originals(const point_color_options* o, const stp_store* store)
{
    return draws_all(o, store, 0, true);
}

/// Reports a missing attribute and lists the available ones.
static stp_result refuse(stp_context* context, const stp_store* store, const char* path,
                         stp_attribute attribute)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    char list[256] = "";
    for (uint32_t i = 0; i < d->attribute_count; ++i) {
        size_t used = strlen(list);
        snprintf(list + used, sizeof(list) - used, "%s%s", i == 0 ? "" : ", ",
                 stp_attribute_name((stp_attribute)d->attributes[i].attribute));
    }
    return stp_fail(context, STP_ERROR_ARGUMENT, "%s: its points have no %s (%s%s)", path,
                    stp_attribute_name(attribute),
                    d->attribute_count > 0 ? "they have " : "they have no attributes", list);
}

static stp_result check_attribute(stp_context* context, const stp_store* store, const char* path,
                                  uint32_t method, bool reference, stp_attribute attribute)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    if (stp_store_find_attribute(store, attribute) == NULL) {
        return refuse(context, store, path, attribute);
    }
    if (!is_drawn(store, method, reference, attribute)) {
        return stp_fail(context, STP_ERROR_ARGUMENT,
                        "%s: splats by %s have no %s, because each represents several points "
                        "(use --method blue or stochastic, or --reference)",
                        path, d->method_count > 0 ? d->methods[method].name : "no method",
                        stp_attribute_name(attribute));
    }
    return STP_OK;
}

static int compare_heights(const void* a, const void* b)
{
    double x = *(const double*)a, y = *(const double*)b;
    return (x > y) - (x < y);
}

/// The set that shows the whole scene: the root's, or that of its only child, and so on.
static uint32_t find_whole_set(const stp_store_directory* d, uint32_t method, stp_affine* placed)
{
    uint32_t node = d->root, set = STP_STORE_NONE;
    *placed = stp_affine_identity();
    while (d->method_count > 0) {
        const stp_store_node* n = &d->nodes[node];
        set = stp_store_set_of(d, method, node);
        if (set != STP_STORE_NONE || n->edge_count != 1 || n->part_count != 0) {
            break;
        }
        const stp_store_edge* edge = &d->edges[n->first_edge];
        *placed = stp_affine_multiply(*placed, edge->transform);
        node = edge->node; // below its parent
    }
    return set;
}

stp_result point_colors_elevations(stp_context* context, stp_store* store, uint32_t method,
                                   double range[2])
{
    const stp_store_directory* d = stp_store_get_directory(store);
    range[0] = 0.0;
    range[1] = 1.0;
    if (d->root == STP_STORE_NONE || stp_boxd_is_empty(d->nodes[d->root].bounds)) {
        return STP_OK;
    }
    range[0] = d->nodes[d->root].bounds.min.y;
    range[1] = d->nodes[d->root].bounds.max.y;
    stp_affine placed;
    uint32_t set = find_whole_set(d, method, &placed);
    if (set == STP_STORE_NONE || stp_store_is_partial(store)) {
        return STP_OK;
    }
    stp_splats splats;
    uint32_t octaves = stp_store_octaves_for(stp_store_describe_splat_set(store, set), HEIGHTS_MAX);
    stp_result result = stp_store_get_splat_set_prefix(store, set, octaves, &splats);
    uint32_t count = result == STP_OK ? splats.count : 0;
    count = count < HEIGHTS_MAX ? count : HEIGHTS_MAX;
    double* heights = STP_NEW_ARRAY(context, double, (size_t)count + 1);
    if (result == STP_OK && heights == NULL) {
        result = stp_fail_memory(context);
    }
    if (result == STP_OK && count > 0) {
        for (size_t i = 0; i < count; ++i) {
            heights[i] = stp_affine_point(&placed, stp_splat_place(&splats, i)).y;
        }
        qsort(heights, count, sizeof(*heights), compare_heights);
        range[0] = heights[count / 50];
        range[1] = heights[count - 1 - count / 50];
    }
    stp_free(context, heights);
    stp_store_release_splat_set(store, set);
    return result;
}

bool point_colors_is_terrain(const stp_store_directory* d)
{
    bool heights = d->source_count > 0;
    for (uint32_t i = 0; i < d->source_count && heights; ++i) {
        heights = d->sources[i].format != NULL && strcmp(d->sources[i].format, "hgt") == 0;
    }
    return heights;
}

/// Whether the coarsest splats of a set are white: what points without colours become.
static stp_result are_white(stp_store* store, uint32_t set, bool* white)
{
    stp_splats splats;
    uint32_t octaves = stp_store_octaves_for(stp_store_describe_splat_set(store, set), COLORS_MAX);
    stp_result result = stp_store_get_splat_set_prefix(store, set, octaves, &splats);
    size_t count = result == STP_OK ? 3 * (size_t)splats.count : 0;
    for (size_t i = 0; i < count && *white; ++i) {
        *white = splats.colors[i] == 255;
    }
    stp_store_release_splat_set(store, set);
    return result;
}

stp_result point_colors_choose(stp_store* store, uint32_t method, int* color)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    if (*color != POINT_COLOR_AUTO) {
        return STP_OK;
    }
    *color = point_colors_is_terrain(d) ? POINT_COLOR_ELEVATION : POINT_COLOR_RGB;
    if (d->method_count == 0 || !cloud_style_is_cloud(store)) {
        return STP_OK;
    }
    const stp_store_method* m = &d->methods[method];
    uint32_t last = m->set_count > COLOR_SETS_MAX ? m->set_count - COLOR_SETS_MAX : 0;
    bool white = m->set_count > 0;
    stp_result result = STP_OK;
    for (uint32_t i = m->set_count; i > last && white && result == STP_OK; --i) {
        result = are_white(store, m->first_set + i - 1, &white);
    }
    if (white && result == STP_OK) {
        *color = POINT_COLOR_ELEVATION;
    }
    return result;
}

static stp_result find_pixels(const point_color_options* o, stp_context* context, stp_store* store,
                              uint32_t method, point_coloring* c)
{
    if (o->color == POINT_COLOR_NORMAL) {
        c->pixels = STP_DRAW_NORMALS;
    } else if (o->color == POINT_COLOR_ELEVATION) {
        c->pixels = STP_DRAW_ELEVATION;
        if (o->range == NULL) {
            return point_colors_elevations(context, store, method, c->elevation);
        }
        (void)read_range(o->range, c->elevation);
    }
    return STP_OK;
}

stp_result point_colors_find(const point_color_options* o, stp_context* context, stp_store* store,
                             const char* path, uint32_t method, bool reference,
                             point_coloring* coloring)
{
    stp_attribute attribute = attributes[o->color];
    stp_store_coloring* points = &coloring->points;
    *coloring = (point_coloring){.pixels = STP_DRAW_OWN_COLORS};
    stp_result result = STP_OK;
    if (o->classes != NULL) {
        points->hides = true;
        (void)read_classes(o->classes, points->shown);
        result = check_attribute(context, store, path, method, reference, STP_ATTRIBUTE_CLASS);
    }
    if (result == STP_OK && attribute != STP_ATTRIBUTES) {
        result = check_attribute(context, store, path, method, reference, attribute);
    }
    if (result != STP_OK) {
        return result;
    }
    if (attribute != STP_ATTRIBUTES) {
        const stp_store_attribute* figures = stp_store_find_attribute(store, attribute);
        double range[2] = {figures->low_percentile, figures->high_percentile};
        if (o->range != NULL) {
            (void)read_range(o->range, range);
        }
        points->by_attribute = true;
        points->attribute = attribute;
        points->low = range[0];
        points->high = range[1];
    }
    return find_pixels(o, context, store, method, coloring);
}

bool point_colors_describe(const point_color_options* o, const point_coloring* c, json_t* object)
{
    bool elevation = o->color == POINT_COLOR_ELEVATION;
    double low = elevation ? c->elevation[0] : c->points.low;
    double high = elevation ? c->elevation[1] : c->points.high;
    json_t* range = has_range(o->color) ? json_pack("[f, f]", low, high) : json_null();
    bool set = json_object_set_new(object, "color", json_string(point_color_name(o->color))) == 0;
    return json_object_set_new(object, "range", range) == 0 && set;
}

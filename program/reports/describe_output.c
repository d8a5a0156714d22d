// SPDX-License-Identifier: MIT
#include "base/core/printable.h"
#include "base/math/color.h"
#include "import/reading/scan_info.h"
#include "program/reports/describe.h"
#include "store/file/point_attributes.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

json_t* describe_json_text(const char* text)
{
    if (text == NULL) {
        return json_null();
    }
    json_t* json = json_string(text);
    char* copy = json == NULL ? malloc(strlen(text) + 1) : NULL;
    if (copy != NULL) {
        size_t i = 0;
        for (; text[i] != 0; ++i) {
            copy[i] = (unsigned char)text[i] < 0x80 ? text[i] : '?';
        }
        copy[i] = 0;
        json = json_string(copy);
        free(copy);
    }
    return json;
}

static json_t* count_json(uint64_t count)
{
    return json_integer(count > INT64_MAX ? INT64_MAX : (json_int_t)count);
}

static void set_count(json_t* object, const char* key, uint64_t count)
{
    (void)json_object_set_new(object, key, count_json(count));
}

static void set_level_figures(json_t* json, const scene_figures* f)
{
    const char* keys[] = {"levels", "level_triangles", "level_bytes"};
    const uint64_t counts[] = {f->levels.levels, f->levels.triangles, f->levels.bytes};
    for (int i = 0; i < 3; ++i) {
        (void)json_object_set_new(json, keys[i],
                                  f->has_level_figures ? count_json(counts[i]) : json_null());
    }
}

static json_t* vector_json(stp_vec3d v)
{
    return json_pack("[f, f, f]", v.x, v.y, v.z);
}

static json_t* bounds_json(const stp_store_summary* summary)
{
    stp_boxd box = summary->bounds;
    if (stp_boxd_is_empty(box)) {
        return json_null();
    }
    return json_pack("{s:o, s:o}", "min", vector_json(box.min), "max", vector_json(box.max));
}

static void set_figures(json_t* object, const stp_store_figures* figures)
{
#define X(name) set_count(object, #name, figures->name);
    STP_STORE_FIGURES(X)
#undef X
}

static json_t* parts_json(const stp_store_summary* summary)
{
    json_t* parts = json_array();
    for (uint32_t i = 0; i < summary->part_count; ++i) {
        json_t* entry = json_object();
        (void)json_object_set_new(entry, "name", describe_json_text(summary->parts[i].name));
        set_figures(entry, &summary->parts[i].figures);
        (void)json_array_append_new(parts, entry);
    }
    return parts;
}

static json_t* unit_json(double metres)
{
    const char* name = describe_unit(metres);
    if (name != NULL || metres <= 0.0) {
        return describe_json_text(name);
    }
    char text[64];
    snprintf(text, sizeof(text), "%.9g m", metres);
    return json_string(text);
}

static json_t* sources_json(const stp_store_directory* d)
{
    json_t* sources = json_array();
    for (uint32_t i = 0; i < d->source_count; ++i) {
        json_t* entry = json_object();
        (void)json_object_set_new(entry, "path", describe_json_text(d->sources[i].path));
        (void)json_object_set_new(entry, "format", describe_json_text(d->sources[i].format));
        set_count(entry, "bytes", d->sources[i].bytes);
        (void)json_object_set_new(entry, "coordinate_system",
                                  describe_json_text(d->sources[i].coordinate_system));
        stp_system_identity identity = stp_system_identify(d->sources[i].coordinate_system);
        (void)json_object_set_new(
            entry, "coordinate_system_name",
            describe_json_text(identity.name[0] != '\0' ? identity.name : NULL));
        (void)json_object_set_new(entry, "epsg",
                                  identity.epsg != 0 ? json_integer(identity.epsg) : json_null());
        (void)json_object_set_new(entry, "unit", unit_json(d->unit_metres));
        (void)json_array_append_new(sources, entry);
    }
    return sources;
}

// How many points have which value of an attribute.
static json_t* values_json(const stp_store_directory* d, uint32_t attribute)
{
    json_t* values = json_array();
    for (uint32_t i = 0; i < d->attribute_value_count; ++i) {
        const stp_store_attribute_value* v = &d->attribute_values[i];
        if (v->attribute != attribute) {
            continue;
        }
        json_t* entry = json_object();
        set_count(entry, "value", v->value);
        (void)json_object_set_new(entry, "name", describe_json_text(stp_class_name(v->value)));
        set_count(entry, "count", v->count);
        (void)json_array_append_new(values, entry);
    }
    return values;
}

static json_t* attributes_json(const stp_store_directory* d)
{
    json_t* attributes = json_array();
    for (uint32_t i = 0; i < d->attribute_count; ++i) {
        const stp_store_attribute* a = &d->attributes[i];
        json_t* entry = json_pack(
            "{s:s, s:f, s:f, s:f, s:f}", "name", stp_attribute_name((stp_attribute)a->attribute),
            "min", a->low, "max", a->high, "p2", a->low_percentile, "p98", a->high_percentile);
        set_count(entry, "count", a->count);
        if (a->attribute == STP_ATTRIBUTE_CLASS) {
            (void)json_object_set_new(entry, "classes", values_json(d, a->attribute));
        }
        (void)json_array_append_new(attributes, entry);
    }
    return attributes;
}

static json_t* views_json(const stp_store_directory* d)
{
    json_t* views = json_array();
    for (uint32_t i = 0; i < d->view_count; ++i) {
        (void)json_array_append_new(views, describe_json_text(d->views[i].name));
    }
    return views;
}

json_t* describe_json(const scene_figures* f)
{
    const stp_store_directory* d = f->directory;
    bool stored = f->format_version != 0;
    json_t* json = json_object();
    json_t* methods = json_array();
    for (uint32_t i = 0; f->summary.figures.unique_surfels != 0 && i < stp_store_offered_methods(d);
         ++i) {
        (void)json_array_append_new(methods, json_string(d->methods[i].name));
    }
    (void)json_object_set_new(json, "format_version",
                              stored ? count_json(f->format_version) : json_null());
    (void)json_object_set_new(json, "format_minor",
                              stored ? count_json(f->format_minor) : json_null());
    set_count(json, "file_bytes", f->file_bytes);
    if (stored) {
        (void)json_object_set_new(json, "truncated", json_boolean(f->file_bytes < f->whole_bytes));
        set_count(json, "whole_bytes", f->whole_bytes);
        (void)json_object_set_new(json, "default_color",
                                  json_string(f->by_elevation ? "elevation" : "rgb"));
    }
    (void)json_object_set_new(json, "methods", methods);
    set_figures(json, &f->summary.figures);
    set_level_figures(json, f);
    set_count(json, "materials", f->summary.material_count);
    set_count(json, "textures", f->summary.texture_count);
    set_count(json, "single_sided_materials", f->sides.materials);
    set_count(json, "single_sided_triangles", f->sides.triangles);
    set_count(json, "inverted_meshes", f->sides.inverted);
    char up[2] = {d->up, 0};
    (void)json_object_set_new(json, "bounds", bounds_json(&f->summary));
    (void)json_object_set_new(json, "unit", unit_json(d->unit_metres));
    (void)json_object_set_new(json, "up", json_string(up));
    (void)json_object_set_new(json, "position_error",
                              f->position_error > 0.0 ? json_real(f->position_error) : json_null());
    (void)json_object_set_new(json, "sources", sources_json(d));
    (void)json_object_set_new(json, "attributes", attributes_json(d));
    (void)json_object_set_new(json, "views", views_json(d));
    (void)json_object_set_new(json, "parts", parts_json(&f->summary));
    return json;
}

const char* describe_count(uint64_t count, char out[32])
{
    static const char units[] = "kMGTPE";
    if (count < 1000) {
        snprintf(out, 32, "%u", (unsigned)count);
    } else if (count < 100000) {
        snprintf(out, 32, "%u,%03u", (unsigned)(count / 1000), (unsigned)(count % 1000));
    } else {
        double value = (double)count;
        int unit = -1;
        while (value >= 999.5 && unit < 5) {
            value /= 1000.0;
            unit += 1;
        }
        int digits = value < 9.995 ? 2 : value < 99.95 ? 1 : 0;
        assert(unit >= 0 && "smaller counts are printed in full");
        snprintf(out, 32, "%.*f %c", digits, value, units[unit]);
    }
    return out;
}

const char* describe_bytes(uint64_t bytes, char out[32])
{
    static const char* const units[] = {"B", "KB", "MB", "GB", "TB", "PB", "EB"};
    double value = (double)bytes;
    int unit = 0;
    while (value >= 999.5 && unit < 6) {
        value /= 1000.0;
        unit += 1;
    }
    int digits = unit == 0 ? 0 : value < 9.995 ? 2 : value < 99.95 ? 1 : 0;
    snprintf(out, 32, "%.*f %s", digits, value, units[unit]);
    return out;
}

void describe_text(const char* text)
{
    size_t size = text != NULL ? 4 * strlen(text) + 1 : 0;
    char* shown = size > 1 ? malloc(size) : NULL;
    if (shown != NULL) {
        stp_make_printable(text, shown, size);
        fputs(shown, stdout);
    }
    free(shown);
}

// A line below the table: the total, and the unique count if it differs.
static void print_count(const char* label, uint64_t total, uint64_t unique)
{
    char a[32], b[32];
    if (total == 0 && unique == 0) {
        return;
    }
    printf("  %-12s %10s", label, describe_count(total, a));
    if (unique != total) {
        printf("  (%s unique)", describe_count(unique, b));
    }
    printf("\n");
}

static void print_bytes(const char* label, uint64_t bytes, uint64_t count, const char* each)
{
    char text[32];
    if (bytes != 0) {
        printf("  %-12s %10s", label, describe_bytes(bytes, text));
        if (count != 0) {
            printf("  (%.1f bytes per %s)", (double)bytes / (double)count, each);
        }
        printf("\n");
    }
}

// Maximum distance of stored points from the input's.
static void print_exactness(const scene_figures* f)
{
    static const struct {
        double metres;
        const char* name;
    } units[] = {{1.0, "m"}, {1e-3, "mm"}, {1e-6, "um"}, {1e-9, "nm"}};
    double error = f->position_error * f->directory->unit_metres;
    int unit = 0;
    if (!(f->position_error > 0.0)) {
        return;
    }
    while (unit < 3 && error < 0.1 * units[unit].metres) {
        unit += 1;
    }
    if (f->directory->unit_metres > 0.0) {
        printf("  %-12s exact to %.2g %s\n", "positions", error / units[unit].metres,
               units[unit].name);
    } else {
        printf("  %-12s exact to %.2g (no unit)\n", "positions", f->position_error);
    }
}

static void print_place(const scene_figures* f)
{
    const char* unit = describe_unit(f->directory->unit_metres);
    stp_boxd box = f->summary.bounds;
    if (!stp_boxd_is_empty(box)) {
        printf("  %-12s %.6g x %.6g x %.6g%s%s, from (%.6g, %.6g, %.6g)\n", "size",
               box.max.x - box.min.x, box.max.y - box.min.y, box.max.z - box.min.z,
               unit != NULL ? " " : "", unit != NULL ? unit : "", box.min.x, box.min.y, box.min.z);
    }
    if (unit == NULL && f->directory->unit_metres > 0.0) {
        printf("  %-12s %.9g m\n", "unit", f->directory->unit_metres);
    } else {
        printf("  %-12s %s\n", "unit", unit != NULL ? unit : "unknown");
    }
    printf("  %-12s %c\n", "up", f->directory->up);
    if (f->by_elevation) {
        printf("  %-12s none in the file, so drawn by elevation (--color)\n", "colours");
    }
    print_exactness(f);
}

static void print_lists(const stp_store_directory* d)
{
    char text[32];
    for (uint32_t i = 0; i < d->source_count; ++i) {
        printf("  %-12s ", i == 0 ? "sources" : "");
        describe_text(d->sources[i].path);
        printf(" (");
        describe_text(d->sources[i].format != NULL ? d->sources[i].format : "unknown");
        printf(", %s)\n", describe_bytes(d->sources[i].bytes, text));
        if (d->sources[i].coordinate_system != NULL) {
            printf("  %-12s ", "");
            describe_text(d->sources[i].coordinate_system);
            printf("\n");
        }
    }
    for (uint32_t i = 0; i < d->attribute_count; ++i) {
        const stp_store_attribute* a = &d->attributes[i];
        printf("  %-12s %s %.9g to %.9g\n", i == 0 ? "attributes" : "",
               stp_attribute_name((stp_attribute)a->attribute), a->low, a->high);
    }
    for (uint32_t i = 0; i < d->attribute_value_count; ++i) {
        const stp_store_attribute_value* v = &d->attribute_values[i];
        const char* name = stp_class_name(v->value);
        printf("  %-12s %3u %s: %s\n", i == 0 ? "classes" : "", v->value, name != NULL ? name : "",
               describe_count(v->count, text));
    }
    for (uint32_t i = 0; i < d->view_count; ++i) {
        printf(i == 0 ? "  %-12s " : ", ", "views");
        describe_text(d->views[i].name != NULL ? d->views[i].name : "(no name)");
    }
    printf(d->view_count != 0 ? "\n" : "");
}

static void print_levels(const stp_store_level_figures* levels)
{
    char bytes[32], triangles[32], count[32];
    if (levels->levels != 0) {
        printf("  %-12s %10s  (%s levels of %s triangles)\n", "levels",
               describe_bytes(levels->bytes, bytes), describe_count(levels->levels, count),
               describe_count(levels->triangles, triangles));
    }
}

static void print_sides(const stp_store_side_figures* sides)
{
    char triangles[32], count[32];
    if (sides->triangles != 0) {
        printf("  %-12s %10s  triangles of %s single-sided materials: drawn from the front only\n",
               "one side", describe_count(sides->triangles, triangles),
               describe_count(sides->materials, count));
    }
    if (sides->inverted != 0) {
        printf("  %-12s %10s  closed meshes face inwards: --back-faces on shows their outside\n",
               "inverted", describe_count(sides->inverted, count));
    }
}

void describe_print(const char* path, const scene_figures* f)
{
    const stp_store_figures* figures = &f->summary.figures;
    char text[32];
    describe_text(path);
    printf(": %s", describe_bytes(f->file_bytes, text));
    if (f->format_version != 0) {
        printf(", .stip version %u.%u", f->format_version, f->format_minor);
        if (f->file_bytes < f->whole_bytes) {
            printf(", truncated: the first part of %s", describe_bytes(f->whole_bytes, text));
        }
    }
    printf("\n\n");
    describe_print_table(&f->summary);
    printf("\n");
    print_count("nodes", figures->nodes, figures->unique_nodes);
    print_count("instances", figures->instances, figures->instances);
    print_count("materials", f->summary.material_count, f->summary.material_count);
    print_sides(&f->sides);
    print_bytes("splats", figures->splat_bytes, figures->unique_surfels, "splat");
    print_bytes("geometry", figures->triangle_bytes, figures->unique_triangles, "triangle");
    print_levels(&f->levels);
    print_bytes("point sets", figures->point_bytes, figures->unique_points, "point");
    print_bytes("textures", figures->texture_bytes, 0, "");
    print_place(f);
    print_lists(f->directory);
}

// SPDX-License-Identifier: MIT
#include "describe.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Names come from input files and may hold any bytes; JSON wants UTF-8.
static json_t* text_json(const char* text)
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

static json_t* vector_json(stp_vec3d v)
{
    return json_pack("[f, f, f]", v.x, v.y, v.z);
}

static json_t* bounds_json(const stp_store_directory* d)
{
    if (d->root == STP_STORE_NONE || stp_boxd_is_empty(d->nodes[d->root].bounds)) {
        return json_null();
    }
    stp_boxd box = d->nodes[d->root].bounds;
    return json_pack("{s:o, s:o}", "min", vector_json(box.min), "max", vector_json(box.max));
}

static json_t* parts_json(const scene_figures* f)
{
    json_t* parts = json_array();
    for (size_t i = 0; i < f->part_count; ++i) {
        const part_figures* part = &f->parts[i];
        json_t* entry = json_object();
        (void)json_object_set_new(entry, "name", text_json(part->name));
        set_count(entry, "objects", part->objects);
        set_count(entry, "instances", part->instances);
        set_count(entry, "triangles", part->triangles);
        set_count(entry, "points", part->points);
        (void)json_array_append_new(parts, entry);
    }
    return parts;
}

static json_t* sources_json(const stp_store_directory* d)
{
    json_t* sources = json_array();
    for (uint32_t i = 0; i < d->source_count; ++i) {
        json_t* entry = json_object();
        (void)json_object_set_new(entry, "path", text_json(d->sources[i].path));
        (void)json_object_set_new(entry, "format", text_json(d->sources[i].format));
        set_count(entry, "bytes", d->sources[i].bytes);
        (void)json_array_append_new(sources, entry);
    }
    return sources;
}

static json_t* views_json(const stp_store_directory* d)
{
    json_t* views = json_array();
    for (uint32_t i = 0; i < d->view_count; ++i) {
        (void)json_array_append_new(views, text_json(d->views[i].name));
    }
    return views;
}

static json_t* unit_json(double metres)
{
    const char* name = describe_unit(metres);
    if (name != NULL || metres <= 0.0) {
        return text_json(name);
    }
    char text[64];
    snprintf(text, sizeof(text), "%.9g m", metres);
    return json_string(text);
}

json_t* describe_json(const scene_figures* f)
{
    const stp_store_directory* d = f->directory;
    json_t* json = json_object();
    json_t* methods = json_array();
    if (f->unique_surfels != 0) {
        (void)json_array_append_new(methods, json_string("blue"));
    }
    (void)json_object_set_new(json, "format_version",
                              f->format_version != 0 ? count_json(f->format_version) : json_null());
    set_count(json, "file_bytes", f->file_bytes);
    (void)json_object_set_new(json, "methods", methods);
    const struct {
        const char* key;
        uint64_t count;
    } counts[] = {
        {"nodes", f->nodes},
        {"unique_nodes", f->unique_nodes},
        {"objects", f->objects},
        {"instances", f->instances},
        {"triangles", f->triangles},
        {"unique_triangles", f->unique_triangles},
        {"points", f->points},
        {"unique_points", f->unique_points},
        {"surfels", f->surfels},
        {"unique_surfels", f->unique_surfels},
        {"splat_bytes", f->splat_bytes},
        {"triangle_bytes", f->triangle_bytes},
        {"point_bytes", f->point_bytes},
        {"texture_bytes", f->texture_bytes},
        {"materials", d->material_count},
        {"textures", d->texture_count},
    };
    for (size_t i = 0; i < sizeof(counts) / sizeof(counts[0]); ++i) {
        set_count(json, counts[i].key, counts[i].count);
    }
    char up[2] = {d->up, 0};
    (void)json_object_set_new(json, "bounds", bounds_json(d));
    (void)json_object_set_new(json, "unit", unit_json(d->unit_metres));
    (void)json_object_set_new(json, "up", json_string(up));
    (void)json_object_set_new(json, "sources", sources_json(d));
    (void)json_object_set_new(json, "views", views_json(d));
    (void)json_object_set_new(json, "parts", parts_json(f));
    return json;
}

// 1234567 as 1,234,567.
static const char* group(uint64_t count, char out[32])
{
    char digits[24];
    int length = snprintf(digits, sizeof(digits), "%llu", (unsigned long long)count), at = 0;
    for (int i = 0; i < length; ++i) {
        if (i > 0 && (length - i) % 3 == 0) {
            out[at++] = ',';
        }
        out[at++] = digits[i];
    }
    out[at] = 0;
    return out;
}

static const char* bytes_text(uint64_t bytes, char out[32])
{
    static const char* const units[] = {"bytes", "KB", "MB", "GB", "TB"};
    double value = (double)bytes;
    int unit = 0;
    while (value >= 1000.0 && unit < 4) {
        value /= 1000.0;
        unit += 1;
    }
    snprintf(out, 32,
             unit == 0       ? "%.0f %s"
             : value < 100.0 ? "%.1f %s"
                             : "%.0f %s",
             value, units[unit]);
    return out;
}

// A line of the table: total, and what is unique where that differs.
static void print_count(const char* label, uint64_t total, uint64_t unique)
{
    char a[32], b[32];
    if (total == 0 && unique == 0) {
        return;
    }
    printf("  %-12s %15s", label, group(total, a));
    if (unique != total) {
        printf("   (%s unique)", group(unique, b));
    }
    printf("\n");
}

static void print_bytes(const char* label, uint64_t bytes, uint64_t count, const char* each)
{
    char text[32];
    if (bytes != 0) {
        printf("  %-12s %15s", label, bytes_text(bytes, text));
        if (count != 0) {
            printf("   (%.1f bytes a %s)", (double)bytes / (double)count, each);
        }
        printf("\n");
    }
}

// Text from the file, without bytes that could steer a terminal.
static void print_text(const char* text)
{
    for (; text != NULL && *text != 0; ++text) {
        unsigned char c = (unsigned char)*text;
        putchar(c < 0x20 || c == 0x7f ? '?' : c);
    }
}

static void print_place(const stp_store_directory* d)
{
    const char* unit = describe_unit(d->unit_metres);
    if (d->root != STP_STORE_NONE) {
        stp_boxd box = d->nodes[d->root].bounds;
        printf("  %-12s %.6g x %.6g x %.6g%s%s, from (%.6g, %.6g, %.6g)\n", "size",
               box.max.x - box.min.x, box.max.y - box.min.y, box.max.z - box.min.z,
               unit != NULL ? " " : "", unit != NULL ? unit : "", box.min.x, box.min.y, box.min.z);
    }
    if (unit == NULL && d->unit_metres > 0.0) {
        printf("  %-12s %.9g m\n", "unit", d->unit_metres);
    } else {
        printf("  %-12s %s\n", "unit", unit != NULL ? unit : "unknown");
    }
    printf("  %-12s %c\n", "up", d->up);
}

static void print_lists(const scene_figures* f)
{
    const stp_store_directory* d = f->directory;
    char text[32];
    for (uint32_t i = 0; i < d->source_count; ++i) {
        printf("  %-12s ", i == 0 ? "sources" : "");
        print_text(d->sources[i].path);
        printf(" (%s, %s)\n", d->sources[i].format != NULL ? d->sources[i].format : "unknown",
               bytes_text(d->sources[i].bytes, text));
    }
    for (uint32_t i = 0; i < d->view_count; ++i) {
        printf("  %-12s ", i == 0 ? "views" : "");
        print_text(d->views[i].name != NULL ? d->views[i].name : "(no name)");
        printf("\n");
    }
    for (size_t i = 0; f->part_count > 1 && i < f->part_count && i < 20; ++i) {
        printf("  %-12s %15s triangles   ", i == 0 ? "parts" : "",
               group(f->parts[i].triangles, text));
        print_text(f->parts[i].name != NULL ? f->parts[i].name : "(no name)");
        printf("\n");
    }
    if (f->part_count > 20) {
        printf("  %-12s and %zu more (all with --json)\n", "", f->part_count - 20);
    }
}

void describe_print(const char* path, const scene_figures* f)
{
    char text[32];
    print_text(path);
    printf(": %s", bytes_text(f->file_bytes, text));
    if (f->format_version != 0) {
        printf(", .stip version %u", f->format_version);
    }
    printf("\n");
    print_count("triangles", f->triangles, f->unique_triangles);
    print_count("points", f->points, f->unique_points);
    print_count("surfels", f->surfels, f->unique_surfels);
    print_count("nodes", f->nodes, f->unique_nodes);
    print_count("objects", f->objects, f->objects);
    print_count("instances", f->instances, f->instances);
    print_count("materials", f->directory->material_count, f->directory->material_count);
    print_bytes("splats", f->splat_bytes, f->unique_surfels, "surfel");
    print_bytes("geometry", f->triangle_bytes, f->unique_triangles, "triangle");
    print_bytes("point sets", f->point_bytes, f->unique_points, "point");
    print_bytes("textures", f->texture_bytes, 0, "");
    print_place(f->directory);
    print_lists(f);
}

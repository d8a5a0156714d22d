// SPDX-License-Identifier: MIT
#include "program/options/command.h"
#include "program/reports/describe.h"
#include "program/reports/reports.h"

#include <stdio.h>
#include <string.h>

// Describes scans by the figures that describe_json prints for any model: one object per scan.
// Bounds use the scene's axes, as for an imported model.
static void make_figures(const stp_scene* scene, const stp_scan_info* info,
                         stp_store_directory* directory, stp_store_source* source,
                         scene_figures* figures)
{
    const stp_source* read = &scene->sources[0];
    *source = (stp_store_source){.path = read->path,
                                 .format = read->format,
                                 .bytes = read->bytes,
                                 .coordinate_system = read->coordinate_system};
    *directory = (stp_store_directory){.sources = source,
                                       .source_count = 1,
                                       .unit_metres = scene->unit_metres,
                                       .up = scene->up[0]};
    *figures = (scene_figures){.directory = directory, .file_bytes = read->bytes};
    stp_boxd box = stp_boxd_empty();
    if (info->has_box) {
        stp_boxd_add(&box, (stp_vec3d){info->low[0], info->low[1], info->low[2]});
        stp_boxd_add(&box, (stp_vec3d){info->high[0], info->high[1], info->high[2]});
        box = stp_affine_box(&scene->objects[0].transform, box);
    }
    uint64_t scans = info->scan_count;
    figures->summary.bounds = box;
    figures->summary.figures = (stp_store_figures){.objects = scans,
                                                   .unique_objects = scans,
                                                   .instances = scans,
                                                   .points = info->point_count,
                                                   .unique_points = info->point_count};
}

static json_t* numbers_json(const double v[3])
{
    return json_pack("[f, f, f]", v[0], v[1], v[2]);
}

static json_t* fields_json(const stp_scan_info* info)
{
    json_t* list = json_array();
    for (uint32_t i = 0; i < info->field_count; ++i) {
        const stp_scan_field* f = &info->fields[i];
        json_t* entry = json_pack("{s:o, s:s, s:I, s:b, s:b}", "name", describe_json_text(f->name),
                                  "type", f->type, "count", (json_int_t)f->count, "kept",
                                  (int)f->kept, "extra", (int)f->extra);
        (void)json_array_append_new(list, entry);
    }
    return list;
}

static json_t* system_json(const stp_scene* scene)
{
    const char* text = scene->sources[0].coordinate_system;
    if (text == NULL) {
        return json_null();
    }
    stp_system_identity identity = stp_system_identify(text);
    json_t* json = json_object();
    (void)json_object_set_new(json, "name",
                              describe_json_text(identity.name[0] != '\0' ? identity.name : NULL));
    (void)json_object_set_new(json, "epsg",
                              identity.epsg != 0 ? json_integer(identity.epsg) : json_null());
    (void)json_object_set_new(json, "text", describe_json_text(text));
    return json;
}

static void set_compression(json_t* json, const stp_scan_info* info)
{
    (void)json_object_set_new(
        json, "compressor", info->compressed ? describe_json_text(info->compressor) : json_null());
    if (info->chunk_count > 0) {
        (void)json_object_set_new(json, "chunks", json_integer((json_int_t)info->chunk_count));
        (void)json_object_set_new(json, "chunk_points",
                                  json_integer((json_int_t)info->chunk_points));
    }
    (void)json_object_set_new(json, "copc",
                              info->copc
                                  ? json_pack("{s:I, s:I}", "nodes", (json_int_t)info->copc_nodes,
                                              "levels", (json_int_t)info->copc_levels)
                                  : json_null());
}

json_t* scan_report_json(const stp_scene* scene, const stp_scan_info* info)
{
    json_t* json = json_object();
    (void)json_object_set_new(json, "format", json_string(info->format));
    (void)json_object_set_new(json, "version", describe_json_text(info->version));
    (void)json_object_set_new(json, "point_format",
                              info->point_format >= 0 ? json_integer(info->point_format)
                                                      : json_null());
    (void)json_object_set_new(json, "points", json_integer((json_int_t)info->point_count));
    (void)json_object_set_new(json, "scans", json_integer((json_int_t)info->scan_count));
    (void)json_object_set_new(json, "record_bytes", json_integer(info->record_bytes));
    (void)json_object_set_new(json, "attributes", fields_json(info));
    (void)json_object_set_new(json, "bounds",
                              info->has_box
                                  ? json_pack("{s:o, s:o}", "min", numbers_json(info->low), "max",
                                              numbers_json(info->high))
                                  : json_null());
    if (info->has_steps) {
        (void)json_object_set_new(json, "scale", numbers_json(info->scale));
        (void)json_object_set_new(json, "offset", numbers_json(info->offset));
    }
    set_compression(json, info);
    (void)json_object_set_new(json, "coordinate_system", system_json(scene));
    return json;
}

static void print_fields(const stp_scan_info* info, bool extra)
{
    const char* label = extra ? "extra bytes" : "attributes";
    for (uint32_t i = 0; i < info->field_count; ++i) {
        const stp_scan_field* f = &info->fields[i];
        if (f->extra != extra) {
            continue;
        }
        printf("  %-12s ", label);
        describe_text(f->name);
        printf(": %s", f->type);
        if (f->count != 1) {
            printf(" x %u", f->count);
        }
        printf("%s\n", f->kept ? "" : " (not kept)");
        label = "";
    }
    if (extra && info->unnamed > 0) {
        printf("  %-12s and %u more\n", label, info->unnamed);
    }
}

void scan_report_print_fields(const stp_scan_info* info)
{
    print_fields(info, false);
    print_fields(info, true);
}

static void print_vector(const char* label, const double v[3])
{
    printf("  %-12s %.15g %.15g %.15g\n", label, v[0], v[1], v[2]);
}

static void print_system(const stp_scene* scene)
{
    const char* unit = describe_unit(scene->unit_metres);
    const char* text = scene->sources[0].coordinate_system;
    stp_system_identity identity = stp_system_identify(text);
    printf("  %-12s ", "system");
    if (text == NULL) {
        printf("not named\n");
    } else {
        describe_text(identity.name);
        if (identity.epsg != 0) {
            printf(identity.name[0] != '\0' ? " (EPSG:%u)" : "EPSG:%u", identity.epsg);
        }
        printf("\n");
    }
    if (unit == NULL && scene->unit_metres > 0.0) {
        printf("  %-12s %.9g m\n", "unit", scene->unit_metres);
    } else {
        printf("  %-12s %s\n", "unit", unit != NULL ? unit : "unknown");
    }
    printf("  %-12s %s\n", "up", scene->up);
}

static void print_text(const char* path, const stp_scene* scene, const stp_scan_info* info)
{
    char text[32];
    describe_text(path);
    printf(": %s, %s %s", describe_bytes(scene->sources[0].bytes, text), info->format,
           info->version);
    if (info->point_format >= 0) {
        printf(", point format %d", info->point_format);
    }
    printf(info->copc ? ", COPC\n\n" : "\n\n");
    printf("  %-12s %llu\n", "points", (unsigned long long)info->point_count);
    if (info->scan_count != 1) {
        printf("  %-12s %llu\n", "scans", (unsigned long long)info->scan_count);
    }
    if (info->record_bytes > 0) {
        printf("  %-12s %u bytes\n", "record", info->record_bytes);
    }
    if (info->has_box) {
        print_vector("from", info->low);
        print_vector("to", info->high);
    }
    if (info->has_steps) {
        print_vector("scale", info->scale);
        print_vector("offset", info->offset);
    }
    print_system(scene);
    if (info->compressed) {
        printf("  %-12s ", "compressor");
        describe_text(info->compressor);
        printf("\n");
    }
    if (info->chunk_count > 0) {
        printf("  %-12s %llu", "chunks", (unsigned long long)info->chunk_count);
        printf(", of up to %s points\n", describe_count(info->chunk_points, text));
    }
    if (info->copc) {
        printf("  %-12s %llu on %u levels\n", "octree nodes", (unsigned long long)info->copc_nodes,
               info->copc_levels);
    }
    scan_report_print_fields(info);
}

int scan_report_print(const char* path, const stp_scene* scene, const stp_scan_info* info,
                      bool json)
{
    if (!json) {
        print_text(path, scene, info);
        return 0;
    }
    stp_store_directory directory;
    stp_store_source source;
    scene_figures figures;
    make_figures(scene, info, &directory, &source, &figures);
    json_t* object = describe_json(&figures);
    if (object == NULL) {
        return tool_error("out of memory");
    }
    (void)json_object_set_new(object, "scan", scan_report_json(scene, info));
    return tool_print_json(object);
}

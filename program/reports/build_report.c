// SPDX-License-Identifier: MIT
#include "program/options/tool.h"
#include "program/reports/reports.h"

#include <stdio.h>

static json_t* seconds_json(const stp_build_report* r)
{
    return json_pack("{s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f}", "methods", r->methods_s,
                     "import", r->import_s, "partition", r->partition_s, "capture", r->capture_s,
                     "order", r->order_s, "finish", r->finish_s, "surfel_threads",
                     r->splat_thread_s, "clusters", r->clusters_s + r->levels_s, "write",
                     r->write_s, "total", r->total_s);
}

static void print_seconds(const stp_build_report* r)
{
    printf("  %-12s %.2f s (import %.2f, partition %.2f, capture %.2f, order %.2f, finish %.2f, "
           "methods %.2f, clusters %.2f, write %.2f)\n",
           "built in", r->total_s, r->import_s, r->partition_s, r->capture_s, r->order_s,
           r->finish_s, r->methods_s, r->clusters_s + r->levels_s, r->write_s);
    if (r->sets_found + r->meshes_found > 0) {
        printf("  %-12s %u of %u splat sets, %u of %u meshes", "unchanged", r->sets_found,
               r->sets_found + r->sets_made, r->meshes_found, r->meshes_found + r->meshes_made);
        uint32_t nodes = r->levels_found + r->levels_made;
        printf(nodes > 0 ? ", levels of %u of %u nodes\n" : "\n", r->levels_found, nodes);
    }
}

static json_t* report_json(const stp_context* context, const stp_build_report* report,
                           uint64_t peak_bytes, uint64_t input_bytes, const scene_figures* figures)
{
    json_t* json = describe_json(figures);
    (void)json_object_set_new(json, "seconds", seconds_json(report));
    (void)json_object_set_new(json, "peak_bytes", json_integer((json_int_t)peak_bytes));
    (void)json_object_set_new(json, "input_bytes", json_integer((json_int_t)input_bytes));
    (void)json_object_set_new(json, "triangles_alone_would_do",
                              json_boolean(build_sizes_needs_no_splats(figures)));
    (void)json_object_set_new(json, "threads", json_integer(stp_context_thread_count(context)));
    (void)json_object_set_new(json, "candidates", json_integer((json_int_t)report->candidates));
    (void)json_object_set_new(
        json, "unchanged",
        json_pack("{s:I, s:I, s:I, s:I, s:I, s:I}", "surfel_sets", (json_int_t)report->sets_found,
                  "surfel_sets_made", (json_int_t)report->sets_made, "meshes",
                  (json_int_t)report->meshes_found, "meshes_made", (json_int_t)report->meshes_made,
                  "level_nodes", (json_int_t)report->levels_found, "level_nodes_made",
                  (json_int_t)report->levels_made));
    return json;
}

int build_report_print(stp_context* context, const char* path, const stp_build_report* report,
                       uint64_t input_bytes, bool as_json)
{
    uint64_t peak_bytes = stp_context_peak_bytes(context);
    stp_store* store = NULL;
    stp_store_open_desc desc = {.summary_only = true};
    if (stp_store_open_with(context, path, &desc, &store) != STP_OK) {
        return 1;
    }
    scene_figures figures;
    int code = 0;
    if (describe_store(context, store, &figures) != STP_OK) {
        code = 1;
    } else if (as_json) {
        json_t* json = report_json(context, report, peak_bytes, input_bytes, &figures);
        code = json != NULL ? tool_print_json(json) : tool_error("out of memory");
    } else if (!tool_settings_get()->quiet) {
        describe_print(path, &figures);
        print_seconds(report);
        build_sizes_print(input_bytes, &figures);
    }
    describe_destroy(&figures);
    stp_store_close(store);
    return code;
}

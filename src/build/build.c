// SPDX-License-Identifier: MIT
#include "build/build.h"

#include "base/clock.h"
#include "build/census.h"
#include "build/content.h"
#include "build/meshes.h"
#include "build/shadings.h"

#include <string.h>

#define DEFAULT_THRESHOLD 1000u // triangles (Brandt 5.2)

// Everything a build makes on its way, in the order it is made.
typedef struct build {
    stp_context* context;
    const stp_build_desc* desc;
    stp_build_report* report;
    stp_scene* scene;
    stp_shading_set shadings;
    stp_surfels surfels; ///< of the root; count 0: none
    stp_store_census census;
    stp_build_content content;
} build;

// An output that cannot be written should be known before the work, not after it.
static stp_result try_output(stp_context* context, const char* path)
{
    stp_file_writer* writer = NULL;
    stp_result result = stp_file_writer_open(context, path, &writer);
    if (result == STP_OK) {
        stp_file_writer_abort(writer);
    }
    return result;
}

static stp_result import_inputs(build* b)
{
    double start = stp_clock_ms();
    stp_result result = stp_scene_create(b->context, &b->scene);
    for (size_t i = 0; result == STP_OK && i < b->desc->input_count; ++i) {
        const char* input = b->desc->inputs[i];
        result = b->desc->generate != NULL && strncmp(input, "scene:", 6) == 0
                     ? b->desc->generate(b->scene, input, b->desc->generate_user)
                     : stp_import_file(b->scene, input, &b->desc->import);
    }
    double imported = stp_clock_ms();
    b->report->import_s = (imported - start) * 1e-3;
    if (result == STP_OK) {
        result = stp_progress(b->context, "partition", 0.0);
    }
    if (result == STP_OK) {
        result = stp_scene_finish(b->scene);
    }
    if (result == STP_OK) {
        result = stp_build_census(b->scene, &b->census);
    }
    b->report->partition_s = (stp_clock_ms() - imported) * 1e-3;
    return result;
}

// Whether a node is worth surfels: it has more triangles than the threshold, or is a point cloud.
static bool wants_surfels(const build* b, uint32_t node)
{
    if (node == STP_NONE) {
        return false;
    }
    uint64_t threshold = b->desc->threshold != 0 ? b->desc->threshold : DEFAULT_THRESHOLD;
    const stp_node* n = &b->scene->nodes[node];
    return n->triangle_count > threshold || n->point_count != 0;
}

static stp_result make_surfels(build* b)
{
    stp_result result = stp_make_shadings(b->scene, &b->shadings);
    if (result != STP_OK || !wants_surfels(b, b->scene->root)) {
        return result;
    }
    stp_blue_report report;
    result = stp_blue_make(b->scene, b->scene->root, b->shadings.of_material, &b->desc->blue,
                           &b->surfels, &report);
    b->report->capture_s = report.capture_ms * 1e-3;
    b->report->order_s = report.order_ms * 1e-3;
    b->report->finish_s = report.finish_ms * 1e-3;
    b->report->candidates = report.candidate_count;
    return result;
}

static stp_result write_file(build* b)
{
    double start = stp_clock_ms();
    stp_result result = stp_progress(b->context, "write", 0.0);
    if (result == STP_OK) {
        const stp_surfels* surfels = b->surfels.count != 0 ? &b->surfels : NULL;
        result = stp_build_content_create(b->scene, surfels, &b->content);
    }
    if (result == STP_OK) {
        stp_store_directory* d = &b->content.content.directory;
        d->shadings = b->shadings.shadings;
        d->shading_count = b->shadings.count;
        d->build_json = b->desc->parameters_json;
        b->content.content.census = &b->census;
        result = stp_code_meshes(b->scene, &b->content);
    }
    if (result == STP_OK) {
        result = stp_store_write(b->context, &b->content.content, b->desc->output);
    }
    b->report->write_s = (stp_clock_ms() - start) * 1e-3;
    return result;
}

stp_result stp_build(stp_context* context, const stp_build_desc* desc, stp_build_report* report)
{
    stp_build_report unwanted;
    report = report != NULL ? report : &unwanted;
    *report = (stp_build_report){0};
    double start = stp_clock_ms();
    build b = {.context = context, .desc = desc, .report = report};
    stp_result result = try_output(context, desc->output);
    result = result != STP_OK ? result : import_inputs(&b);
    result = result != STP_OK ? result : make_surfels(&b);
    result = result != STP_OK ? result : write_file(&b);
    stp_build_content_destroy(&b.content);
    stp_store_census_destroy(context, &b.census);
    stp_surfels_destroy(context, &b.surfels);
    stp_free(context, b.shadings.of_material);
    stp_scene_destroy(b.scene);
    report->total_s = (stp_clock_ms() - start) * 1e-3;
    return result;
}

// SPDX-License-Identifier: MIT
// Progressive Splatting (Wu, Zhang, Kobbelt 2005): speed of merging the points of a bumpy ball to a
// hundredth, with the paper's normal metric ("L2,1") and with the metric of the method's sets; and
// the stored bytes per operator that splits a splat.
#include "base/core/clock.h"
#include "base/splats/octahedral.h"
#include "base/splats/progressive.h"
#include "lab/bench/bench.h"
#include "lod/psp/psp_set.h"
#include "lod/set_columns.h"
#include "store/sets/sets_internal.h"
#include "store/writer/writer.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { POINTS = 1000000, QUICK_POINTS = 100000, SHARE = 100, REPEATS = 3 };
#define CELL 1.2  // area per sample, in units of the squared coverage radius
#define AREA 12.6 // approximate surface area of the ball

/// Points spread evenly on the ball, and the same as a set of samples.
typedef struct ball {
    stp_context* context;
    float *positions, *normals, *areas;
    stp_splats samples;
} ball;

static stp_vec3d ball_point(uint32_t i, uint32_t count)
{
    double z = 1.0 - 2.0 * ((double)i + 0.5) / count, around = 2.399963229728653 * i;
    double x = sqrt(1.0 - z * z) * cos(around), y = sqrt(1.0 - z * z) * sin(around);
    double away = 1.0 + 0.05 * sin(9.0 * x) * sin(11.0 * y) * sin(10.0 * z) +
                  0.01 * sin(40.0 * x + 3.0 * y) * cos(37.0 * z);
    return (stp_vec3d){away * x, away * y, away * z};
}

/// Normals and colours are those of a sphere; positions have the bumps.
static void fill_points(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    ball* b = user;
    stp_splats* s = &b->samples;
    for (size_t i = begin; i < end; ++i) {
        stp_vec3d p = ball_point((uint32_t)i, s->count);
        stp_vec3 n = stp_to_float(stp_normalized(p)), at = stp_to_float(p);
        const float place[3] = {at.x, at.y, at.z}, normal[3] = {n.x, n.y, n.z};
        for (size_t k = 0; k < 3; ++k) {
            b->positions[3 * i + k] = place[k];
            b->normals[3 * i + k] = normal[k];
            s->positions[3 * i + k] = stp_splats_grid_place(place[k], -1.25f, s->step);
            s->colors[3 * i + k] = (uint8_t)(127.5f + 100.0f * normal[k]);
        }
        stp_octahedral_encode(n, s->normals + 2 * i);
        b->areas[i] = (float)(AREA / s->count);
        s->coverages[i] = 255;
        s->materials[i] = 0;
    }
}

static stp_result make_ball(ball* b, uint32_t count)
{
    b->positions = STP_NEW_ARRAY(b->context, float, 3 * (size_t)count);
    b->normals = STP_NEW_ARRAY(b->context, float, 3 * (size_t)count);
    b->areas = STP_NEW_ARRAY(b->context, float, count);
    b->samples = (stp_splats){
        .count = count,
        .columns = STP_SPLATS_FLAT_COLORS,
        .origin = {-1.25f, -1.25f, -1.25f},
        .step = 0x1p-14f,
        .octave_count = 1,
        .octave_ends = {count},
        .table = {.size = 1, .count = {count}, .radius = {(float)sqrt(AREA / CELL / count)}}};
    b->samples.step = 0x1p-14f;
    stp_result result = stp_splats_make_columns(b->context, &b->samples);
    if (result != STP_OK || b->positions == NULL || b->normals == NULL || b->areas == NULL) {
        return result == STP_OK ? stp_fail_memory(b->context) : result;
    }
    stp_parallel_for(b->context, count, 4096, fill_points, b);
    return STP_OK;
}

static void destroy_ball(ball* b)
{
    stp_free(b->context, b->positions);
    stp_free(b->context, b->normals);
    stp_free(b->context, b->areas);
    stp_splats_destroy(b->context, &b->samples);
    *b = (ball){.context = b->context};
}

/// Stored bytes of a set per operator; each operator splits a splat into two.
static stp_result count_bytes(stp_context* context, const stp_splats* set, double* each)
{
    char path[4096];
    const char* folder = getenv("TMPDIR");
    snprintf(path, sizeof(path), "%s/stipple-psp-XXXXXX", folder != NULL ? folder : "/tmp");
    int descriptor = mkstemp(path);
    if (descriptor < 0) {
        return stp_fail(context, STP_ERROR_IO, "%s: cannot be created", path);
    }
    static const stp_shading shading = {.roughness = 1.0f};
    const stp_store_method method = {
        .name = "psp", .id = STP_METHOD_PSP, .columns = set->columns, .set_count = 1};
    const stp_store_content content = {.directory = {.root = STP_STORE_NONE,
                                                     .shading_count = 1,
                                                     .shadings = &shading,
                                                     .set_count = 1,
                                                     .methods = &method,
                                                     .method_count = 1,
                                                     .up = 'y'},
                                       .sets = set};
    stp_store* store = NULL;
    stp_result result = stp_store_write(context, &content, path);
    result = result == STP_OK ? stp_store_open(context, path, &store) : result;
    uint64_t bytes = 0;
    for (uint32_t k = 0; result == STP_OK && k < set->octave_count; ++k) {
        bytes += stp_store_octave_block(store, 0, k)->size;
    }
    stp_progressive_counts counts = stp_progressive_count(set->ranges, set->count);
    *each = counts.splits > 0 ? (double)bytes / counts.splits : 0.0;
    if (store != NULL) {
        stp_store_close(store);
    }
    (void)unlink(path);
    (void)close(descriptor);
    return result;
}

static stp_result measure(const ball* b, stp_psp_metric metric, int repeats, json_t* results)
{
    uint32_t count = b->samples.count;
    const stp_psp_points points = {.count = count,
                                   .positions = b->positions,
                                   .normals = b->normals,
                                   .colors = b->samples.colors,
                                   .areas = b->areas};
    stp_psp_desc desc = stp_psp_desc_default();
    desc.metric = metric;
    double seconds[REPEATS], each = 0.0;
    uint32_t left_count = 0;
    stp_result result = STP_OK;
    for (int i = 0; i < repeats && result == STP_OK; ++i) {
        stp_psp_splats left;
        double start = stp_clock_ms();
        result = stp_psp_decimate(b->context, &points, &desc, count / SHARE, &left);
        seconds[i] = 1e-3 * (stp_clock_ms() - start);
        left_count = left.count;
        stp_psp_splats_destroy(b->context, &left);
    }
    stp_splats set = {0};
    result = result == STP_OK ? stp_psp_make(b->context, &b->samples, NULL, false, metric, 0, &set)
                              : result;
    result = result == STP_OK ? count_bytes(b->context, &set, &each) : result;
    stp_splats_destroy(b->context, &set);
    if (result == STP_OK) {
        double median = bench_median(seconds, (size_t)repeats);
        bench_entry e = bench_result(results, "psp");
        bench_set_count(e.params, "points", count);
        bench_set_text(e.params, "metric", metric == STP_PSP_NORMALS ? "normals" : "regions");
        bench_set_count(e.params, "threads", stp_context_thread_count(b->context));
        bench_set_count(e.figures, "input_points", count);
        bench_set_count(e.figures, "splats", left_count);
        bench_set_number(e.figures, "seconds", median);
        bench_set_number(e.figures, "points_per_second", count / median);
        bench_set_number(e.figures, "bytes_per_operator", each);
    }
    return result;
}

static int run_psp(const bench_options* options, json_t* results)
{
    static const stp_psp_metric metrics[] = {STP_PSP_NORMALS, STP_PSP_REGIONS};
    ball b = {.context = tool_context_create(options->threads, 0, "none")};
    if (b.context == NULL) {
        return 1;
    }
    stp_result result = STP_OK;
    for (uint32_t count = QUICK_POINTS;
         count <= (options->quick ? QUICK_POINTS : POINTS) && result == STP_OK;
         count *= POINTS / QUICK_POINTS) {
        result = make_ball(&b, count);
        for (int i = 0; i < 2 && result == STP_OK; ++i) {
            result =
                measure(&b, metrics[i], options->quick || count == POINTS ? 1 : REPEATS, results);
        }
        destroy_ball(&b);
    }
    stp_context_destroy(b.context);
    return result == STP_OK ? 0 : 1;
}

const benchmark benchmark_psp = {
    .name = "psp",
    .summary =
        "Progressive Splatting: points merged per second, and bytes per operator (Wu et al.)",
    .run = run_psp,
};

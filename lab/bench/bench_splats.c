// SPDX-License-Identifier: MIT
//
// Splats per second drawn into a picture of 1920 x 1080, from an order that is random in space:
// single pixels, and disks with the normals of a ball. The same points are drawn with software
// OpenGL, if available, with as many threads, in the same run. Both sides include clearing (here:
// emptying and merging the threads' buffers). Memory copy speed and random pixel updates are
// measured in between.
#include "base/core/clock.h"
#include "base/math/math.h"
#include "base/math/rng.h"
#include "base/splats/octahedral.h"
#include "lab/bench/bench.h"
#include "lab/bench/memory_speed.h"
#include "program/drawing/software_gl.h"
#include "raster/splats.h"

#include <assert.h>
#include <string.h>

enum { WIDTH = 1920, HEIGHT = 1080, MIN_REPEATS = 3, REPEATS = 7, TASK = 16384, MAX_THREADS = 2 };
static const double repeat_ms = 4000.0; // a size that has taken this long has enough repeats

typedef struct splat_bench {
    stp_context* context;
    uint32_t count, threads;
    uint16_t* positions;
    int8_t* normals;
    float* gl_positions;
    float* gl_normals;
    uint64_t* buffers; ///< one picture a thread
    stp_raster_splats splats;
    stp_raster_camera camera;
    uint64_t fragments[MAX_THREADS]; ///< fragments drawn by each worker
    memory_speed memory;
} splat_bench;

static void destroy(splat_bench* b)
{
    memory_speed_destroy(&b->memory);
    stp_free(b->context, b->positions);
    stp_free(b->context, b->normals);
    stp_free(b->context, b->gl_positions);
    stp_free(b->context, b->gl_normals);
    stp_free(b->context, b->buffers);
    stp_context_destroy(b->context);
}

/// A ball as high as the picture, in parallel projection, so that all splats have the same size.
static bool create(splat_bench* b, uint32_t count, uint32_t threads)
{
    *b = (splat_bench){
        .context = tool_context_create(threads, 0, "none"), .count = count, .threads = threads};
    if (b->context == NULL) {
        return false;
    }
    size_t n = count, pixels = (size_t)WIDTH * HEIGHT * threads;
    b->positions = STP_NEW_ARRAY(b->context, uint16_t, 3 * n);
    b->normals = STP_NEW_ARRAY(b->context, int8_t, 2 * n);
    b->gl_positions = STP_NEW_ARRAY(b->context, float, 3 * n);
    b->gl_normals = STP_NEW_ARRAY(b->context, float, 3 * n);
    b->buffers = STP_NEW_ARRAY(b->context, uint64_t, pixels);
    bool created = memory_speed_create(b->context, WIDTH * HEIGHT, &b->memory);
    if (!created || b->positions == NULL || b->normals == NULL || b->gl_positions == NULL ||
        b->gl_normals == NULL || b->buffers == NULL) {
        tool_error("bench splats: out of memory");
        destroy(b);
        return false;
    }
    memset(b->buffers, 0xff, pixels * sizeof(uint64_t));
    for (size_t i = 0; i < n; ++i) {
        double z = (double)(stp_rng_hash(1, 2 * i) >> 11) * 0x1p-52 - 1.0;
        double angle = (double)(stp_rng_hash(1, 2 * i + 1) >> 11) * 0x1p-53 * 2.0 * STP_PI;
        double r = sqrt(1.0 - z * z);
        const float p[3] = {(float)(r * cos(angle)), (float)(r * sin(angle)), (float)z};
        for (size_t k = 0; k < 3; ++k) {
            b->positions[3 * i + k] = (uint16_t)((p[k] * 0.49f + 0.5f) * 65536.0f);
            b->gl_normals[3 * i + k] = p[k];
            b->gl_positions[3 * i + k] = p[k] * 0.98f * (k == 0 ? (float)HEIGHT / WIDTH : 1.0f);
        }
        stp_octahedral_encode((stp_vec3){p[0], p[1], p[2]}, b->normals + 2 * i);
    }
    b->splats = (stp_raster_splats){
        .positions = b->positions, .normals = b->normals, .step = 1.0f / 65536.0f};
    b->camera = (stp_raster_camera){
        .matrix = {{{HEIGHT, 0, 0, 0.5f * (WIDTH - HEIGHT)},
                    {0, HEIGHT, 0, 0},
                    {0, 0, -0.9f, 0.95f},
                    {0, 0, 0, 1}}},
        .view = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}},
        .pixel_scale = HEIGHT,
        .parallel = true,
        .nearness_limit = 1.0f,
    };
    return true;
}

static void draw_task(size_t begin, size_t end, uint32_t worker, void* user)
{
    splat_bench* b = user;
    assert(worker < b->threads && b->threads <= MAX_THREADS && "each worker has its own buffer");
    stp_raster_target target = {WIDTH, HEIGHT, WIDTH, b->buffers + (size_t)worker * WIDTH * HEIGHT};
    stp_raster_splats splats = b->splats;
    splats.begin = (uint32_t)begin;
    splats.end = (uint32_t)end;
    b->fragments[worker] += stp_raster_draw_splats(&target, 0, HEIGHT, &b->camera, &splats, 0);
}

/// Leaves the buffers empty, as a frame does; the merged pixel would be shaded here.
static void merge_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    splat_bench* b = user;
    uint64_t row[WIDTH], sum = 0;
    for (size_t y = begin; y < end; ++y) {
        memset(row, 0xff, sizeof(row));
        for (uint32_t t = 0; t < b->threads; ++t) {
            uint64_t* pixels = b->buffers + ((size_t)t * HEIGHT + y) * WIDTH;
            for (int x = 0; x < WIDTH; ++x) {
                row[x] = pixels[x] < row[x] ? pixels[x] : row[x];
                pixels[x] = STP_RASTER_EMPTY;
            }
        }
        for (int x = 0; x < WIDTH; ++x) {
            sum += row[x];
        }
    }
    b->buffers[(size_t)worker * WIDTH * HEIGHT] |= sum == 1; // prevents the compiler from removing
                                                             // the work
}

typedef struct lap {
    double cpu, raster, gl; ///< milliseconds
    double copy, update;    ///< bytes and pixels a second
    uint64_t fragments;
} lap;

// Draws twice and counts the second frame, because in a flight the previous frame is similar. It
// makes no difference to OpenGL, which takes seconds.
static lap run_lap(splat_bench* b, software_gl* gl, float size)
{
    lap out = {0};
    for (int frame = 0; frame < 2; ++frame) {
        memset(b->fragments, 0, sizeof(b->fragments));
        double start = stp_clock_ms();
        stp_parallel_for(b->context, b->count, TASK, draw_task, b);
        out.raster = stp_clock_ms() - start;
        stp_parallel_for(b->context, HEIGHT, 8, merge_rows, b);
        out.cpu = stp_clock_ms() - start;
    }
    if (gl != NULL) {
        double start = stp_clock_ms();
        software_gl_draw(gl, size, size > 1.0f);
        out.gl = stp_clock_ms() - start;
    }
    for (uint32_t i = 0; i < b->threads; ++i) {
        out.fragments += b->fragments[i];
    }
    out.copy = memory_speed_copy(&b->memory);
    out.update = memory_speed_update(&b->memory);
    return out;
}

/// The minimum memory traffic of a splat: its own bytes, its fragments read and written, and its
/// share of emptying and merging the threads' pictures; and that traffic as a share of the memory
/// bandwidth.
static void set_memory(const splat_bench* b, const bench_entry* entry, double rate, double copy,
                       double update, uint64_t fragments)
{
    double each = (double)fragments / b->count;
    double own = b->splats.radius > 0.0f ? 8.0 : 6.0; // a position, and perhaps a normal
    double pixels = (double)WIDTH * HEIGHT * b->threads / b->count;
    double bytes = own + 16.0 * (each + pixels);
    bench_set_number(entry->figures, "fragments_per_splat", each);
    bench_set_number(entry->figures, "bytes_per_splat", bytes);
    bench_set_number(entry->figures, "bytes_per_second", bytes * rate);
    bench_set_number(entry->figures, "copy_bytes_per_second", copy);
    bench_set_number(entry->figures, "part_of_copy", bytes * rate / copy);
    bench_set_number(entry->figures, "random_pixels_per_second", update);
    bench_set_number(entry->figures, "part_of_random_pixels", each * rate / update);
}

static void measure(splat_bench* b, software_gl* gl, float size, bool quick, json_t* results)
{
    double cpu[REPEATS], raster[REPEATS], slow[REPEATS], copy[REPEATS], update[REPEATS];
    uint64_t fragments = 0;
    size_t repeats = 0;
    // one pixel: the centre's; else disks of that diameter
    b->splats.radius = size > 1.0f ? 0.5f * size / (float)HEIGHT : 0.0f;
    (void)run_lap(b, NULL, size);
    if (gl != NULL) {
        software_gl_warm(gl, size, size > 1.0f);
    }
    double start = stp_clock_ms();
    while (repeats < (quick ? 2 : MIN_REPEATS) ||
           (!quick && repeats < REPEATS && stp_clock_ms() - start < repeat_ms)) {
        lap l = run_lap(b, gl, size);
        cpu[repeats] = (double)b->count / l.cpu * 1000.0;
        raster[repeats] = (double)b->count / l.raster * 1000.0;
        copy[repeats] = l.copy;
        update[repeats] = l.update;
        fragments = l.fragments;
        slow[repeats++] = gl != NULL ? (double)b->count / l.gl * 1000.0 : 0.0;
    }
    bench_entry entry = bench_result(results, "splats");
    bench_set_number(entry.params, "size_px", (double)size);
    bench_set_count(entry.params, "threads", b->threads);
    bench_set_count(entry.params, "splats", b->count);
    bench_set_count(entry.params, "repeats", repeats);
    double fast = bench_median(cpu, repeats);
    bench_set_number(entry.figures, "cpu_per_second", fast);
    bench_set_number(entry.figures, "cpu_raster_per_second", bench_median(raster, repeats));
    set_memory(b, &entry, fast, bench_median(copy, repeats), bench_median(update, repeats),
               fragments);
    if (gl != NULL) {
        double gl_rate = bench_median(slow, repeats);
        bench_set_number(entry.figures, "gl_per_second", gl_rate);
        bench_set_number(entry.figures, "ratio", fast / gl_rate);
        bench_set_text(entry.figures, "gl", software_gl_name(gl));
    } else {
        json_object_set_new(entry.figures, "gl_per_second", json_null());
        json_object_set_new(entry.figures, "ratio", json_null());
    }
}

static int run(const bench_options* options, json_t* results)
{
    static const float sizes[] = {1, 2, 3, 4, 8};
    for (uint32_t threads = 1; threads <= MAX_THREADS; ++threads) {
        splat_bench b;
        if (!create(&b, options->quick ? 300000 : 2000000, threads)) {
            return 1;
        }
        software_gl* gl = software_gl_create(WIDTH, HEIGHT, threads);
        if (gl != NULL && !software_gl_upload(gl, b.gl_positions, b.gl_normals, b.count)) {
            software_gl_destroy(gl);
            gl = NULL;
        }
        for (size_t i = 0; i < sizeof(sizes) / sizeof(sizes[0]); ++i) {
            measure(&b, gl, sizes[i], options->quick, results);
        }
        software_gl_destroy(gl);
        destroy(&b);
    }
    return 0;
}

const benchmark benchmark_splats = {
    .name = "splats",
    .summary = "splats per second on the CPU and with software OpenGL",
    .run = run,
};

// SPDX-License-Identifier: MIT
// Small triangles in a visibility buffer: a jittered grid that fills the picture, in perspective.
#include "base/core/clock.h"
#include "base/math/rng.h"
#include "lab/bench/bench.h"
#include "raster/triangles.h"

#include <assert.h>
#include <string.h>

enum { WIDTH = 1920, HEIGHT = 1080, BAND_ROWS = 40, REPEATS = 7 };

typedef struct grid {
    float* positions;
    uint32_t* indices;
    uint32_t columns, rows; ///< numbers of quads, two triangles each
    float size;             ///< side of a quad, pixels
} grid;

typedef struct draw_job {
    const grid* grid;
    stp_raster_matrix matrix;
    uint64_t* pixels;
    stp_arena* scratch; ///< one per thread
    bool* failed;       ///< one per thread
} draw_job;

static float jitter(uint64_t index, float maximum)
{
    return ((float)(stp_rng_hash(7, index) >> 40) / 8388608.0f - 1.0f) * maximum;
}

static bool make_grid(stp_context* context, float size, grid* out)
{
    uint32_t columns = (uint32_t)((float)WIDTH / size), rows = (uint32_t)((float)HEIGHT / size);
    size_t vertices = (size_t)(columns + 1) * (rows + 1);
    *out = (grid){.columns = columns, .rows = rows, .size = size};
    out->positions = STP_NEW_ARRAY(context, float, 3 * vertices);
    out->indices = STP_NEW_ARRAY(context, uint32_t, (size_t)columns * rows * 6);
    if (out->positions == NULL || out->indices == NULL) {
        return false;
    }
    for (size_t v = 0; v < vertices; ++v) {
        size_t column = v % (columns + 1), row = v / (columns + 1);
        float x = (float)column * size + jitter(2 * v, 0.3f * size) - 0.5f * (float)WIDTH;
        float y = (float)row * size + jitter(2 * v + 1, 0.3f * size) - 0.5f * (float)HEIGHT;
        float depth = 1.5f + 0.3f * (x + y) / (float)WIDTH;
        float* p = out->positions + 3 * v;
        p[0] = x * depth / 1000.0f;
        p[1] = y * depth / 1000.0f;
        p[2] = depth;
    }
    uint32_t* index = out->indices;
    for (uint32_t y = 0; y < rows; ++y) {
        for (uint32_t x = 0; x < columns; ++x) {
            uint32_t a = y * (columns + 1) + x, b = a + 1, c = a + columns + 1, d = c + 1;
            memcpy(index, (uint32_t[6]){a, b, c, b, d, c}, 6 * sizeof(uint32_t));
            index += 6;
        }
    }
    return true;
}

static void free_grid(stp_context* context, grid* g)
{
    stp_free(context, g->positions);
    stp_free(context, g->indices);
}

/// Draws a band of the picture: the rows of quads that may touch it.
static void draw_band(size_t begin, size_t end, uint32_t worker, void* user)
{
    const draw_job* job = user;
    const grid* g = job->grid;
    stp_raster_target target = {
        .width = WIDTH, .height = HEIGHT, .stride = WIDTH, .pixels = job->pixels};
    memset(job->pixels + begin * WIDTH, 0xFF, (end - begin) * WIDTH * sizeof(uint64_t));
    float low = (float)begin / g->size - 2.0f, high = (float)end / g->size + 2.0f;
    uint32_t first = low > 0.0f ? (uint32_t)low : 0;
    uint32_t last = high < (float)g->rows ? (uint32_t)high : g->rows;
    assert(begin < end && end <= HEIGHT && first <= last);
    stp_raster_mesh mesh = {
        .positions = g->positions,
        .vertex_count = (g->columns + 1) * (g->rows + 1),
        .indices = g->indices + (size_t)first * g->columns * 6,
        .triangle_count = (last - first) * g->columns * 2,
    };
    stp_result result =
        stp_raster_triangles(&target, (uint32_t)begin, (uint32_t)end, &job->matrix, 1.0f, &mesh,
                             first * g->columns * 2, &job->scratch[worker]);
    job->failed[worker] = job->failed[worker] || result != STP_OK;
}

/// @return median time of drawing the grid in milliseconds; below 0 if memory runs out
static double time_grid(stp_context* context, const grid* g)
{
    uint32_t threads = stp_context_thread_count(context);
    draw_job job = {
        .grid = g,
        .matrix = {{{1000, 0, WIDTH * 0.5f, 0},
                    {0, 1000, HEIGHT * 0.5f, 0},
                    {0, 0, 0, 0.1f},
                    {0, 0, 1, 0}}},
        .pixels = STP_NEW_ARRAY(context, uint64_t, (size_t)WIDTH * HEIGHT),
        .scratch = STP_NEW_ZEROED(context, stp_arena, threads),
        .failed = STP_NEW_ZEROED(context, bool, threads),
    };
    bool failed = job.pixels == NULL || job.scratch == NULL || job.failed == NULL;
    double times[REPEATS];
    for (int repeat = -1; !failed && repeat < REPEATS; ++repeat) { // the first warms up
        for (uint32_t i = 0; repeat < 0 && i < threads; ++i) {
            job.scratch[i] = stp_arena_create(context, 4096);
        }
        double started = stp_clock_ms();
        // one thread draws the picture as a single band, so no quad is drawn twice
        stp_parallel_for(context, HEIGHT, threads > 1 ? BAND_ROWS : HEIGHT, draw_band, &job);
        times[repeat < 0 ? 0 : repeat] = stp_clock_ms() - started;
        for (uint32_t i = 0; i < threads; ++i) {
            failed = failed || job.failed[i];
        }
    }
    for (uint32_t i = 0; job.scratch != NULL && i < threads; ++i) {
        stp_arena_destroy(&job.scratch[i]);
    }
    stp_free(context, job.pixels);
    stp_free(context, job.scratch);
    stp_free(context, job.failed);
    return failed ? -1.0 : bench_median(times, REPEATS);
}

static int run_size(stp_context* context, float size, json_t* results)
{
    grid g;
    double ms = make_grid(context, size, &g) ? time_grid(context, &g) : -1.0;
    double triangles = 2.0 * (double)g.columns * (double)g.rows;
    free_grid(context, &g);
    if (ms < 0.0) {
        return tool_error("bench triangles: out of memory");
    }
    bench_entry entry = bench_result(results, "triangles");
    bench_set_number(entry.params, "size_px", (double)size);
    bench_set_count(entry.params, "threads", stp_context_thread_count(context));
    bench_set_number(entry.figures, "cpu_per_second", triangles / ms * 1000.0);
    json_object_set_new(entry.figures, "gl_per_second", json_null());
    json_object_set_new(entry.figures, "ratio", json_null());
    return 0;
}

static int run_triangles(const bench_options* options, json_t* results)
{
    static const float sizes[] = {1.0f, 2.0f, 4.0f, 8.0f, 32.0f};
    size_t count = options->quick ? 2 : sizeof(sizes) / sizeof(sizes[0]);
    static const uint32_t threads[] = {1, 0}; // 0: all
    int code = 0;
    for (size_t t = 0; t < 2 && code == 0; ++t) {
        stp_context* context = tool_context_create(threads[t], 0, "none");
        if (context == NULL) {
            return 1;
        }
        for (size_t i = 0; i < count && code == 0; ++i) {
            code = run_size(context, options->quick ? sizes[i + 1] : sizes[i], results);
        }
        stp_context_destroy(context);
    }
    return code;
}

const benchmark benchmark_triangles = {
    .name = "triangles",
    .summary = "small triangles per second in a visibility buffer",
    .run = run_triangles,
};

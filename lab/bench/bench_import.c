// SPDX-License-Identifier: MIT
//
// Benchmark `import`: CPU time from a point file to a scene, and a checksum of the result, with
// --model for that file, else for a text of points made in memory.
#include "base/core/clock.h"
#include "base/io/hash.h"
#include "base/math/rng.h"
#include "import/reading/import.h"
#include "lab/bench/bench.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>

enum {
    RUNS = 5,
    QUICK_RUNS = 1,
    MAX_RUNS = 64,
    POINTS = 2000000,
    QUICK_POINTS = 20000,
    LINE = 64 // maximum bytes of a line of the text
};

typedef struct import_bench {
    const bench_options* options;
    stp_context* context;
    char* text; ///< owned; of the benchmark's own points
    size_t text_size;
} import_bench;

typedef struct import_figures {
    uint64_t points, bytes;
    double cpu_seconds, wall_seconds;
    stp_hash checksum;
    char format[16];
} import_figures;

// CPU time of all threads, including the kernel.
static double processor_seconds(void)
{
    struct rusage used;
    getrusage(RUSAGE_SELF, &used);
    return (double)(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
           1e-6 * (double)(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

// Lines with map coordinates and a colour, as programs write them.
static bool make_text(import_bench* b)
{
    uint32_t count = b->options->quick ? QUICK_POINTS : POINTS;
    b->text = stp_alloc(b->context, (size_t)count * LINE);
    if (b->text == NULL) {
        return false;
    }
    for (uint32_t i = 0; i < count; ++i) {
        uint64_t bits = stp_rng_hash(0, i), color = stp_rng_hash(1, i);
        int written = snprintf(b->text + b->text_size, LINE, "%u.%03u %u.%03u %u.%03u %u %u %u\n",
                               600000u + (unsigned)(bits & 1023), (unsigned)(bits >> 10 & 511),
                               4900000u + (unsigned)(bits >> 20 & 1023),
                               (unsigned)(bits >> 30 & 511), (unsigned)(bits >> 40 & 127),
                               (unsigned)(bits >> 50 & 511), (unsigned)(color & 255),
                               (unsigned)(color >> 8 & 255), (unsigned)(color >> 16 & 255));
        assert(written > 0 && written < LINE && "no line is truncated");
        b->text_size += (size_t)written;
    }
    return true;
}

static stp_hash hash_points(const stp_point_set* p)
{
    stp_hash hash = stp_hash_bytes((stp_hash){0}, p->positions, p->point_count * 3 * sizeof(float));
    if (p->normals != NULL) {
        hash = stp_hash_bytes(hash, p->normals, p->point_count * 3 * sizeof(float));
    }
    if (p->colors != NULL) {
        hash = stp_hash_bytes(hash, p->colors, (size_t)p->point_count * 4);
    }
    for (unsigned k = 0; k < STP_ATTRIBUTES; ++k) {
        if (p->attributes[k] != NULL) {
            size_t size = stp_attribute_size((stp_attribute)k);
            hash = stp_hash_bytes(hash, p->attributes[k], p->point_count * size);
        }
    }
    return hash;
}

static void describe_scene(const stp_scene* scene, import_figures* f)
{
    f->points = 0;
    f->checksum = (stp_hash){0};
    for (size_t i = 0; i < scene->point_set_count; ++i) {
        stp_hash own = hash_points(&scene->point_sets[i]);
        f->points += scene->point_sets[i].point_count;
        f->checksum = stp_hash_bytes(f->checksum, &own, sizeof(own));
    }
    snprintf(f->format, sizeof(f->format), "%s", scene->sources[0].format);
    f->bytes = scene->sources[0].bytes;
}

static stp_result run_once(const import_bench* b, import_figures* f)
{
    stp_scene* scene = NULL;
    stp_result result = stp_scene_create(b->context, &scene);
    if (result != STP_OK) {
        return result;
    }
    const stp_import_desc desc = {0};
    double cpu = processor_seconds(), wall = stp_clock_ms();
    result = b->options->model != NULL
                 ? stp_import_file(scene, b->options->model, &desc)
                 : stp_import_memory(scene, "points.xyz", b->text, b->text_size, &desc);
    f->cpu_seconds = processor_seconds() - cpu;
    f->wall_seconds = 1e-3 * (stp_clock_ms() - wall);
    if (result == STP_OK) {
        describe_scene(scene, f);
    }
    stp_scene_destroy(scene);
    return result;
}

static stp_result measure(const import_bench* b, json_t* results)
{
    double cpu[MAX_RUNS], wall[MAX_RUNS];
    uint32_t runs = b->options->count > 0 ? b->options->count
                    : b->options->quick   ? QUICK_RUNS
                                          : RUNS;
    runs = runs < MAX_RUNS ? runs : MAX_RUNS;
    import_figures f = {0};
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < runs && result == STP_OK; ++i) {
        result = run_once(b, &f);
        cpu[i] = f.cpu_seconds;
        wall[i] = f.wall_seconds;
    }
    if (result != STP_OK) {
        return result;
    }
    char checksum[17];
    uint64_t bits;
    memcpy(&bits, &f.checksum, sizeof(bits));
    snprintf(checksum, sizeof(checksum), "%016llx", (unsigned long long)bits);
    double seconds = bench_median(cpu, runs);
    bench_entry entry = bench_result(results, "import");
    bench_set_text(entry.params, "model",
                   b->options->model != NULL ? b->options->model : "points.xyz");
    bench_set_text(entry.params, "format", f.format);
    bench_set_count(entry.params, "threads", stp_context_thread_count(b->context));
    bench_set_count(entry.params, "runs", runs);
    bench_set_count(entry.figures, "points", f.points);
    bench_set_count(entry.figures, "bytes", f.bytes);
    bench_set_number(entry.figures, "cpu_seconds", seconds);
    bench_set_number(entry.figures, "wall_seconds", bench_median(wall, runs));
    bench_set_number(entry.figures, "points_per_cpu_second", (double)f.points / seconds);
    bench_set_text(entry.figures, "checksum", checksum);
    return STP_OK;
}

static int run_import(const bench_options* options, json_t* results)
{
    uint32_t threads = options->threads > 0 ? options->threads : 1;
    import_bench b = {.options = options,
                      .context = tool_context_create(threads, options->memory, "none")};
    if (b.context == NULL) {
        return 1;
    }
    stp_result result = STP_OK;
    if (options->model == NULL && !make_text(&b)) {
        result = stp_fail_memory(b.context);
    }
    result = result == STP_OK ? measure(&b, results) : result;
    stp_free(b.context, b.text);
    stp_context_destroy(b.context);
    return result == STP_OK ? 0 : 1;
}

const benchmark benchmark_import = {
    .name = "import",
    .summary = "CPU time of importing a file (--model), on one thread unless --threads is given",
    .run = run_import,
};

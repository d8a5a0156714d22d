// SPDX-License-Identifier: MIT
//
// Benchmark `positions`: frame times all over scene `paper`, as in the last column of Table 3 of
// Brandt et al. 2019 (section 5.3): at random positions 200 m above the whole scene, looking
// slightly down, and 2 m above the ground of each part, in the four cardinal directions.
#include "base/math/math.h"
#include "base/math/rng.h"
#include "lab/bench/bench.h"
#include "lab/scenes/terrain.h"
#include "program/drawing/frame.h"
#include "program/files/scene_file.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

enum { DIRECTIONS = 4, DEFAULT_COUNT = 20, QUICK_COUNT = 2, SHARE_OF_A_PART = 4 };

typedef struct place {
    const char* name;
    double x, z, half_width, half_depth;
    double above;   ///< the ground, metres
    double decline; ///< slope of the view direction: metres down per metre forward
} place;

typedef struct position_bench {
    stp_context* context;
    stp_store* store;
    frame_maker maker;
    stp_image image;
    terrain_map map;
    const char* model;
    stp_quality quality;
    json_t* results;
} position_bench;

enum { PLACES = 1 + SITE_COUNT };

// Excludes the sites' margins, where the ground changes to terrain.
static void list_places(place places[PLACES])
{
    static const char* const names[SITE_COUNT] = {[SITE_CITY] = "Pompeii",
                                                  [SITE_CAR_FACTORY] = "Car factory",
                                                  [SITE_BAKERY] = "Bakery",
                                                  [SITE_POWER_PLANTS] = "Power plants"};
    places[0] =
        (place){"Overview", 0.0, 0.0, 0.5 * TILE_SIZE * TILE_COLUMNS, 0.5 * TILE_SIZE * TILE_ROWS,
                200.0,      0.2};
    for (int i = 0; i < SITE_COUNT; ++i) {
        const terrain_site* s = &terrain_sites[i];
        places[1 + i] = (place){names[i], s->x, s->z, s->half_width, s->half_depth, 2.0, 0.0};
    }
}

// Position number i is the same for any number of positions.
static stp_view make_view(const position_bench* b, const place* p, uint64_t seed, uint64_t i,
                          int direction)
{
    static const double along[DIRECTIONS][2] = {{0, -1}, {1, 0}, {0, 1}, {-1, 0}};
    double u = (double)(stp_rng_hash(seed, 2 * i) >> 11) * 0x1p-52 - 1.0;
    double v = (double)(stp_rng_hash(seed, 2 * i + 1) >> 11) * 0x1p-52 - 1.0;
    double x = p->x + u * p->half_width, z = p->z + v * p->half_depth;
    double y = terrain_height(&b->map, x, z) + p->above;
    const double reach = 100.0; // distance of the target: arbitrary
    return (stp_view){
        .width = b->image.width,
        .height = b->image.height,
        .fov_degrees = 60.0,
        .eye = {x, y, z},
        .target = {x + reach * along[direction][0], y - reach * p->decline,
                   z + reach * along[direction][1]},
        .up = {0, 1, 0},
    };
}

static int compare_doubles(const void* a, const void* b)
{
    double x = *(const double*)a, y = *(const double*)b;
    return (x > y) - (x < y);
}

static void set_ranks(const bench_entry* entry, double* values, uint32_t count)
{
    static const struct {
        const char* name;
        double part;
    } ranks[] = {{"min", 0.0},  {"p25", 0.25}, {"p50", 0.5}, {"p75", 0.75},
                 {"p95", 0.95}, {"p99", 0.99}, {"max", 1.0}};
    assert(count > 0 && "a rank is a value");
    qsort(values, count, sizeof(values[0]), compare_doubles);
    for (size_t i = 0; i < sizeof(ranks) / sizeof(ranks[0]); ++i) {
        uint32_t rank = (uint32_t)ceil(ranks[i].part * count - 1e-9);
        assert(rank <= count);
        bench_set_number(entry->figures, ranks[i].name, values[rank > 0 ? rank - 1 : 0]);
    }
}

/// Figures of the pictures of a place, as arrays with one value per picture.
typedef struct place_times {
    double *second, *first;     ///< frame times, milliseconds; `first` after a jump
    double *splats, *triangles; ///< counts of the second frame
} place_times;

static void set_list(const bench_entry* entry, const char* key, const double* values,
                     uint32_t count)
{
    json_t* list = json_array();
    for (uint32_t i = 0; i < count; ++i) {
        json_array_append_new(list, json_real(values[i]));
    }
    json_object_set_new(entry->figures, key, list);
}

static void report_place(position_bench* b, const place* p, uint32_t first, uint32_t positions,
                         const place_times* t)
{
    uint32_t pictures = DIRECTIONS * positions;
    bench_entry entry = bench_result(b->results, "positions");
    bench_set_text(entry.params, "model", b->model);
    bench_set_text(entry.params, "place", p->name);
    bench_set_number(entry.params, "metres_above_ground", p->above);
    bench_set_count(entry.params, "first", first);
    bench_set_count(entry.params, "positions", positions);
    bench_set_count(entry.params, "pictures", pictures);
    bench_set_count(entry.params, "width", b->image.width);
    bench_set_count(entry.params, "height", b->image.height);
    bench_set_count(entry.params, "threads", stp_context_thread_count(b->context));
    bench_set_number(entry.params, "splat_size", (double)b->quality.splat_size);
    set_list(&entry, "frame_ms", t->second, pictures); // before sorting
    set_list(&entry, "jump_ms", t->first, pictures);
    set_list(&entry, "splats", t->splats, pictures);
    set_list(&entry, "triangles", t->triangles, pictures);
    set_ranks(&entry, t->second, pictures);
    bench_set_number(entry.figures, "jump_p50", bench_median(t->first, pictures));
    bench_set_number(entry.figures, "splats_p50", bench_median(t->splats, pictures));
    bench_set_number(entry.figures, "triangles_p50", bench_median(t->triangles, pictures));
}

// Draws each picture twice and counts the second frame, as in a flight: the first has cold caches
// and no occlusion data.
static stp_result measure_place(position_bench* b, const place* p, uint64_t seed, uint32_t begin,
                                uint32_t positions)
{
    uint32_t pictures = DIRECTIONS * positions;
    double* block = STP_NEW_ARRAY(b->context, double, 4 * (size_t)pictures);
    if (block == NULL) {
        return stp_fail_memory(b->context);
    }
    place_times t = {block, block + pictures, block + 2 * (size_t)pictures,
                     block + 3 * (size_t)pictures};
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < pictures && result == STP_OK; ++i) {
        stp_view view = make_view(b, p, seed, begin + i / DIRECTIONS, (int)(i % DIRECTIONS));
        frame_figures first, second;
        result = frame_draw_loaded(&b->maker, &view, &b->quality, &b->image, &first);
        if (result == STP_OK) {
            result = frame_draw(&b->maker, &view, &b->quality, &b->image, &second);
        }
        if (result == STP_OK) {
            t.first[i] = first.cost.milliseconds;
            t.second[i] = second.cost.milliseconds;
            t.splats[i] = (double)second.splats;
            t.triangles[i] = (double)second.triangles;
        }
    }
    if (result == STP_OK) {
        report_place(b, p, begin, positions, &t);
    }
    stp_free(b->context, block);
    return result;
}

static stp_result measure(position_bench* b, const bench_options* options)
{
    uint32_t width = options->quick ? 320 : 1920, height = options->quick ? 180 : 1080;
    if (options->size[0] > 0) {
        width = options->size[0];
        height = options->size[1];
    }
    if (!frame_image_create(b->context, width, height, &b->image)) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    terrain_map_make(&b->map, 0);
    stp_draw_style style = {0};
    stp_result result = frame_maker_create(b->context, b->store, &style, &b->maker);
    if (result == STP_OK && options->memory > 0) {
        result = frame_maker_stream(&b->maker);
    }
    uint32_t count = options->count > 0 ? options->count
                     : options->quick   ? QUICK_COUNT
                                        : DEFAULT_COUNT;
    place places[PLACES];
    list_places(places);
    for (uint32_t i = 0; i < PLACES && result == STP_OK; ++i) {
        uint32_t share = i == 0 ? 1 : SHARE_OF_A_PART;
        uint32_t begin = (options->first + share - 1) / share;
        uint32_t end = (options->first + count + share - 1) / share;
        result = begin < end ? measure_place(b, &places[i], i, begin, end - begin) : STP_OK;
    }
    return result;
}

static int run_positions(const bench_options* options, json_t* results)
{
    position_bench b = {.context = tool_context_create(options->threads, options->memory, "none"),
                        .model = options->model != NULL ? options->model
                                 : options->quick       ? "scene:paper,scale=0.001"
                                                        : "scene:paper,scale=0.02",
                        .quality = {.splat_size = (float)options->splat_size},
                        .results = results};
    stp_result result = STP_ERROR_OUT_OF_MEMORY;
    if (b.context != NULL) {
        result = tool_open_scene(b.context, b.model, &b.store);
    }
    if (result == STP_OK) {
        result = measure(&b, options);
    }
    if (b.context != NULL) {
        stp_free(b.context, b.image.pixels);
        frame_maker_destroy(&b.maker);
        if (b.store != NULL) {
            stp_store_close(b.store);
        }
        stp_context_destroy(b.context);
    }
    return result == STP_OK ? 0 : 1;
}

const benchmark benchmark_positions = {
    .name = "positions",
    .summary =
        "frame times all over scene paper: 200 m above it, and 2 m above the ground of its parts",
    .run = run_positions,
};

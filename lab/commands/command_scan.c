// SPDX-License-Identifier: MIT
//
// stipple-lab scan: a simulated laser scan of a scene, as test data whose truth is known.
#include "base/core/clock.h"
#include "lab/scan/scan_file.h"
#include "lab/scan/scan_sweep.h"
#include "program/files/overwrite.h"
#include "program/files/scene_file.h"
#include "program/options/command.h"
#include "program/options/options.h"
#include "program/options/tool.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

enum { BATCH_POINTS = 1 << 16 };

#define DEFAULT_RESOLUTION 0.25
#define DEFAULT_NOISE 0.002
#define DEFAULT_RANGE 350.0
#define AIRBORNE_RANGE 1e6
#define HALF_STRENGTH 40.0 ///< metres at which half of the light returns

static struct {
    const char* output;
    option_texts stations;
    uint64_t count, seed, threads, memory;
    double noise, resolution, range, height, shift[3];
    bool has_noise, has_resolution, has_range, airborne, truth, json;
} args;

static const option* options(void)
{
    static const option table[] = {
        {.name = "output",
         .letter = 'o',
         .type = OPTION_TEXT,
         .argument = "OUT.las|OUT.ptx|OUT.e57|OUT.ply",
         .help = "file to write the points to",
         .value = &args.output},
        {.name = "stations",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "1..256",
         .help = "number of stations to place, or of flight lines; default 1",
         .value = &args.count},
        {.name = "station",
         .type = OPTION_TEXTS,
         .argument = "X,Y,Z",
         .help = "position of a station, in metres with z up; repeatable",
         .value = &args.stations},
        {.name = "airborne",
         .help = "fly over the scene in parallel lines and scan downwards",
         .value = &args.airborne},
        {.name = "resolution",
         .type = OPTION_NUMBER,
         .argument = "DEG|N",
         .words = "0.0055..65535",
         .help = "angular resolution: up to 30, degrees between rays; above 30, rays per turn; "
                 "default 0.25",
         .value = &args.resolution,
         .given = &args.has_resolution},
        {.name = "noise",
         .type = OPTION_NUMBER,
         .argument = "M",
         .words = "0..1000",
         .help = "standard deviation of the range noise in metres; default 0.002",
         .value = &args.noise,
         .given = &args.has_noise},
        {.name = "range",
         .type = OPTION_NUMBER,
         .argument = "M",
         .words = "0.001..1000000",
         .help = "maximum range in metres; default 350, with --airborne 1000000",
         .value = &args.range,
         .given = &args.has_range},
        {.name = "height",
         .type = OPTION_NUMBER,
         .argument = "M",
         .words = "auto|0.001..1000",
         .help =
             "height in metres: of stations above the floor, default 1.8, less in small models; "
             "of a flight above the highest point, by default chosen so that lines overlap",
         .value = &args.height},
        {.name = "shift",
         .type = OPTION_VECTOR,
         .argument = "X,Y,Z",
         .help = "offset added to all coordinates in the file, in metres, for example to get map "
                 "coordinates",
         .value = args.shift},
        {.name = "truth",
         .help = "add columns to a .ply: true normal, object and range error",
         .value = &args.truth},
        {.name = "seed",
         .type = OPTION_COUNT,
         .argument = "N",
         .help = "random seed of noise and placement; default 0",
         .value = &args.seed},
        OPTION_THREADS(&args.threads),
        OPTION_MEMORY(&args.memory),
        OPTION_JSON(&args.json),
        {0},
    };
    return table;
}

/// A scan in the making.
typedef struct scan {
    stp_context* context;
    const char* path;
    stp_scene* scene; ///< the input if it was imported, else NULL
    stp_store* store; ///< the input if it is a .stip, else NULL
    scan_target target;
    scan_settings settings;
    scan_station* stations;
    uint32_t station_count;
    uint64_t points, misses;
    stp_boxd bounds;
    double cast_seconds;
} scan;

static stp_result open_target(scan* s)
{
    if (tool_is_store_file(s->path)) {
        stp_result result = stp_store_open(s->context, s->path, &s->store);
        return result == STP_OK ? scan_target_of_store(s->context, s->store, s->path, &s->target)
                                : result;
    }
    stp_result result = tool_import_scene(s->context, s->path, &s->scene);
    return result == STP_OK ? scan_target_of_scene(s->scene, s->path, &s->target) : result;
}

static bool read_place(const char* text, double place[3])
{
    char problem[256];
    const option vector = {.type = OPTION_VECTOR, .value = place};
    return option_set_value(&vector, text, problem, sizeof(problem));
}

static stp_result choose_positions(scan* s)
{
    stp_vec3d* places = STP_NEW_ARRAY(s->context, stp_vec3d, s->station_count);
    if (places == NULL) {
        return stp_fail_memory(s->context);
    }
    for (uint32_t i = 0; i < args.stations.count; ++i) {
        double v[3];
        (void)read_place(args.stations.texts[i], v); // checked before
        places[i] = (stp_vec3d){v[0] - args.shift[0], v[1] - args.shift[1], v[2] - args.shift[2]};
    }
    const scan_placing placing = {.count = s->station_count,
                                  .height = args.height,
                                  .range = s->settings.range,
                                  .seed = args.seed};
    stp_result result =
        args.stations.count > 0 ? STP_OK : scan_place_stations(&s->target, &placing, places);
    for (uint32_t i = 0; i < s->station_count && result == STP_OK; ++i) {
        s->stations[i] = (scan_station){.number = i + 1,
                                        .columns = s->settings.columns,
                                        .rows = s->settings.rows,
                                        .place = places[i]};
    }
    stp_free(s->context, places);
    return result;
}

static stp_result place_stations(scan* s)
{
    scan_settings* set = &s->settings;
    *set = (scan_settings){.airborne = args.airborne,
                           .noise = args.has_noise ? args.noise : DEFAULT_NOISE,
                           .range = args.has_range  ? args.range
                                    : args.airborne ? AIRBORNE_RANGE
                                                    : DEFAULT_RANGE,
                           .half = HALF_STRENGTH,
                           .seed = args.seed};
    double step = scan_settings_set_resolution(set, args.has_resolution ? args.resolution
                                                                        : DEFAULT_RESOLUTION);
    s->station_count = args.stations.count > 0 ? args.stations.count
                       : args.count > 0        ? (uint32_t)args.count
                                               : 1;
    s->stations = STP_NEW_ARRAY(s->context, scan_station, s->station_count);
    if (s->stations == NULL) {
        return stp_fail_memory(s->context);
    }
    return args.airborne
               ? scan_plan_flight(&s->target, args.height, step, s->station_count, set, s->stations)
               : choose_positions(s);
}

/// One station into the file, a few columns at a time.
static stp_result sweep_station(scan* s, scan_file* file, uint32_t index, scan_point* points,
                                uint32_t batch)
{
    const scan_settings* set = &s->settings;
    const scan_station* station = &s->stations[index];
    stp_result result = scan_file_begin_station(file, station);
    for (uint32_t first = 0; first < set->columns && result == STP_OK; first += batch) {
        uint32_t left = set->columns - first, count = left < batch ? left : batch;
        double start = stp_clock_ms();
        scan_sweep(&s->target, set, station, first, count, points);
        s->cast_seconds += 1e-3 * (stp_clock_ms() - start);
        result = scan_file_add(file, station, points, (size_t)count * set->rows);
        double done = (double)index + (double)(first + count) / (double)set->columns;
        result = result == STP_OK
                     ? stp_progress(s->context, "scan", done / (double)s->station_count)
                     : result;
    }
    return result == STP_OK ? scan_file_end_station(file, station) : result;
}

static stp_result sweep_all(scan* s)
{
    assert(s->settings.rows > 0 && s->settings.columns > 0 && s->station_count > 0);
    uint32_t batch = BATCH_POINTS / s->settings.rows;
    batch = batch > 0 ? batch : 1;
    scan_point* points = STP_NEW_ARRAY(s->context, scan_point, (size_t)batch * s->settings.rows);
    if (points == NULL) {
        return stp_fail_memory(s->context);
    }
    const scan_file_desc desc = {.path = args.output,
                                 .shift = {args.shift[0], args.shift[1], args.shift[2]},
                                 .bounds = stp_caster_bounds(s->target.caster),
                                 .truth = args.truth,
                                 .stations = s->station_count};
    scan_file file;
    stp_result result = scan_file_open(s->context, &desc, &file);
    if (result == STP_OK) {
        for (uint32_t i = 0; i < s->station_count && result == STP_OK; ++i) {
            result = sweep_station(s, &file, i, points, batch);
        }
        s->points = file.points;
        s->misses = file.misses;
        s->bounds = file.bounds;
        if (result == STP_OK) {
            result = scan_file_close(&file);
        } else {
            scan_file_abort(&file);
        }
    }
    stp_free(s->context, points);
    return result;
}

static json_t* describe_place(stp_vec3d place)
{
    return json_pack("[f, f, f]", place.x + args.shift[0], place.y + args.shift[1],
                     place.z + args.shift[2]);
}

static int print_report(const scan* s, double seconds)
{
    uint64_t rays = s->points + s->misses;
    double rate = s->cast_seconds > 0.0 ? (double)rays / s->cast_seconds : 0.0;
    if (!args.json) {
        printf("%llu points from %u station%s, %llu rays hit nothing; %.2f s, %.3g rays/s\n",
               (unsigned long long)s->points, s->station_count, s->station_count == 1 ? "" : "s",
               (unsigned long long)s->misses, seconds, rate);
        return 0;
    }
    json_t* places = json_array();
    bool good = places != NULL;
    for (uint32_t i = 0; good && i < s->station_count; ++i) {
        good = json_array_append_new(places, describe_place(s->stations[i].place)) == 0;
    }
    json_t* bounds = s->points > 0 ? json_pack("{s:o, s:o}", "min", describe_place(s->bounds.min),
                                               "max", describe_place(s->bounds.max))
                                   : json_null();
    return tool_print_json(json_pack(
        "{s:I, s:I, s:I, s:I, s:I, s:I, s:f, s:f, s:o, s:o, s:I}", "points", (json_int_t)s->points,
        "stations", (json_int_t)s->station_count, "misses", (json_int_t)s->misses, "columns",
        (json_int_t)s->settings.columns, "rows", (json_int_t)s->settings.rows, "objects",
        (json_int_t)s->target.part_count, "seconds", seconds, "rays_per_second", rate, "bounds",
        bounds, "station_positions", places, "peak_bytes",
        (json_int_t)stp_context_peak_bytes(s->context)));
}

static int make(scan* s)
{
    double start = stp_clock_ms();
    stp_result result = open_target(s);
    result = result == STP_OK ? place_stations(s) : result;
    result = result == STP_OK ? sweep_all(s) : result;
    if (result == STP_OK && s->points == 0) {
        stp_warn(s->context, "%s: no ray hit anything within %.6g m", s->path, s->settings.range);
    }
    return result == STP_OK ? print_report(s, 1e-3 * (stp_clock_ms() - start)) : 1;
}

static int check_stations(void)
{
    if (args.stations.count > 0 && args.count > 0) {
        return tool_usage_error("--stations (automatic placement) and --station (given "
                                "positions) exclude each other");
    }
    if (args.stations.count > 0 && args.airborne) {
        return tool_usage_error("--airborne uses flight lines (--stations N) and excludes "
                                "--station");
    }
    for (uint32_t i = 0; i < args.stations.count; ++i) {
        double v[3];
        if (!read_place(args.stations.texts[i], v)) {
            return tool_usage_error("--station needs X,Y,Z, not %s", args.stations.texts[i]);
        }
    }
    return 0;
}

static int check_arguments(int argc, const char* path)
{
    if (argc != 1) {
        return tool_usage_error("scan needs one scene or model, but got %d", argc);
    }
    if (args.output == NULL) {
        return tool_usage_error("scan needs -o OUT.las, .ptx, .e57 or .ply");
    }
    const scan_format* format = scan_format_of(args.output);
    if (format == NULL) {
        return tool_usage_error("%s: expected .las, .ptx, .ply or .e57", args.output);
    }
    if (args.truth && !format->has_truth) {
        return tool_usage_error("--truth needs a .ply: %s files have no such columns",
                                format->ending);
    }
    int code = check_stations();
    return code != 0 ? code : overwrite_check(path, args.output);
}

static int run(int argc, char** argv)
{
    int code = check_arguments(argc, argc > 0 ? argv[0] : NULL);
    if (code != 0) {
        return code;
    }
    scan s = {.path = argv[0],
              .context = tool_context_create((uint32_t)args.threads, args.memory, NULL)};
    if (s.context == NULL) {
        return 1;
    }
    s.target.context = s.context;
    code = make(&s);
    stp_free(s.context, s.stations);
    scan_target_destroy(&s.target);
    stp_scene_destroy(s.scene);
    if (s.store != NULL) {
        stp_store_close(s.store);
    }
    stp_context_destroy(s.context);
    return code;
}

const command command_scan = {
    .name = "scan",
    .arguments = "scene:NAME|FILE.stip|MODEL -o OUT.las|ptx|e57|ply",
    .summary = "simulate a laser scan: test data with known truth",
    .text =
        "Simulates a laser scanner in a scene and writes its measurements. From each station it "
        "sweeps 360 degrees, from 60 degrees below the horizon to the zenith, and records the "
        "first surface that each ray hits. As in a real scan, points are dense near a station "
        "and sparse far from it, and hidden surfaces are missing. Rays hit the original "
        "triangles and respect cut-out and transparent textures; they do not hit points of a "
        "cloud.\n\n"
        "--stations places stations automatically: on floors with free space around them, so "
        "that each sees much that the others do not, or around a free-standing model. --station "
        "gives a position.\n\n"
        "--airborne flies over the scene along its longer side, back and forth, in --stations "
        "lines, and scans downwards from 30 degrees left to 30 degrees right.\n\n"
        "Coordinates are in metres with z up, regardless of the scene's unit and axes; a scene "
        "without a unit is assumed to be in metres. Each point has a colour, an intensity (from "
        "albedo, angle and distance), its station number (from 1), and its ray number as the "
        "time. Range noise is normal with deviation --noise, and at most six times that.\n\n"
        "The scene itself is the truth. --truth adds it to a .ply as columns: the surface "
        "normal, facing the scanner; the object (one use of a mesh); and the range error, "
        "positive if the point is too far away.\n\n"
        "The same input, options and seed give the same bytes with any number of threads.",
    .examples =
        "Scan a city from five stations, as LAS:\n"
        "$ stipple-lab scan scene:city-small -o city.las --stations 5\n"
        "Scan more finely, with more noise and map coordinates:\n"
        "$ stipple-lab scan hall.glb -o hall.e57 --stations 3 --resolution 0.05 --noise 0.005 "
        "--shift 389000,5820000,34\n"
        "Scan terrain from the air:\n"
        "$ stipple-lab scan scene:terrain -o terrain.las --airborne --stations 6\n"
        "Write the truth too, from a given position:\n"
        "$ stipple-lab scan scene:forest -o forest.ply --station 0,0,2 --truth\n",
    .files = "OUT.las\tLAS 1.4, point format 7, in millimetres\n"
             "OUT.ptx\ttext: the grid and pose of each station, misses as zeros\n"
             "OUT.e57\tE57: one scan per station, with pose, rows and columns\n"
             "OUT.ply\tbinary PLY, doubles\n",
    .options = options,
    .run = run,
};

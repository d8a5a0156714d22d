// SPDX-License-Identifier: MIT
//
// stipple-lab capture: writes the surfel candidates of a model as points, and the captured pictures.
#include "capture/capture.h"
#include "program/files/overwrite.h"
#include "program/files/point_file.h"
#include "program/files/scene_file.h"
#include "program/options/command.h"
#include "program/present/picture_file.h"

#include <assert.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#define MAX_PARTS ((size_t)1 << 26)

static struct {
    const char *output, *pictures;
    uint64_t directions, resolution, candidates, threads;
    bool no_fill;
} args;

static const option* options(void)
{
    static const option table[] = {
        {.name = "output",
         .letter = 'o',
         .type = OPTION_TEXT,
         .argument = "OUT.ply",
         .help = "file to write the candidates to",
         .value = &args.output},
        {.name = "pictures",
         .type = OPTION_TEXT,
         .argument = "FOLDER",
         .help = "folder for pictures of position, normal and colour of each direction",
         .value = &args.pictures},
        {.name = "directions",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "1..4096",
         .help = "number of directions; default 8, the corners of a cube",
         .value = &args.directions},
        {.name = "resolution",
         .type = OPTION_COUNT,
         .argument = "PX",
         .words = "auto|4..16384",
         .help = "pixels along the longer side; default auto",
         .value = &args.resolution},
        {.name = "candidates",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "1..1000000000",
         .help = "approximate number of candidates if the resolution is automatic; default "
                 "1750000",
         .value = &args.candidates},
        {.name = "no-fill",
         .help = "leave out surfaces that only additional directions see",
         .value = &args.no_fill},
        OPTION_THREADS(&args.threads),
        {0},
    };
    return table;
}

static uint8_t to_byte(double value)
{
    double scaled = value * 255.0 + 0.5;
    return (uint8_t)(scaled < 0.0 ? 0.0 : scaled > 255.0 ? 255.0 : scaled);
}

enum { POSITION, NORMAL, COLOR, KIND_COUNT };

// The colour of a candidate in a picture of each kind.
static void paint(const stp_candidates* c, uint32_t i, double reach, uint8_t* pixels[KIND_COUNT],
                  size_t at)
{
    for (size_t k = 0; k < 3; ++k) {
        double position = (double)c->positions[3 * (size_t)i + k];
        double normal = (double)c->normals[3 * (size_t)i + k];
        pixels[POSITION][4 * at + k] = to_byte(0.5 + 0.5 * position / reach);
        pixels[NORMAL][4 * at + k] = to_byte(0.5 + 0.5 * normal);
        pixels[COLOR][4 * at + k] = c->colors[4 * (size_t)i + k];
    }
    for (int kind = 0; kind < KIND_COUNT; ++kind) {
        pixels[kind][4 * at + 3] = 255;
    }
}

// Projects the candidates of one direction back to the pixels they come from.
static stp_result write_view(stp_context* context, const stp_candidates* c, uint32_t view,
                             stp_vec3d toward, double reach)
{
    static const char* const names[KIND_COUNT] = {"position", "normal", "color"};
    stp_vec3d up = {0.0, fabs(toward.y) > 0.95 ? 0.0 : 1.0, fabs(toward.y) > 0.95 ? -1.0 : 0.0};
    stp_vec3d right = stp_normalized(stp_crossd(up, toward)), down = stp_crossd(right, toward);
    assert(c->view_starts[view] <= c->view_starts[view + 1] &&
           c->view_starts[view + 1] <= c->count && "views partition the candidates");
    uint32_t side = c->resolution + 3;
    size_t count = (size_t)side * side;
    uint8_t* pixels[KIND_COUNT];
    stp_result result = STP_OK;
    for (int kind = 0; kind < KIND_COUNT; ++kind) {
        pixels[kind] = stp_alloc_zeroed(context, count, 4);
        result = pixels[kind] == NULL ? STP_ERROR_OUT_OF_MEMORY : result;
    }
    double shift[2] = {0.5 * (double)side, 0.5 * (double)side};
    if (c->view_starts[view] < c->view_starts[view + 1]) { // candidates lie at pixels' centres
        const float* f = c->positions + 3 * (size_t)c->view_starts[view];
        stp_vec3d p = {(double)f[0], (double)f[1], (double)f[2]};
        double x = stp_dotd(right, p) / c->pixel_size, y = stp_dotd(down, p) / c->pixel_size;
        shift[0] += floor(x + shift[0]) + 0.5 - (x + shift[0]);
        shift[1] += floor(y + shift[1]) + 0.5 - (y + shift[1]);
    }
    for (uint32_t i = c->view_starts[view]; result == STP_OK && i < c->view_starts[view + 1]; ++i) {
        const float* f = c->positions + 3 * (size_t)i;
        stp_vec3d p = {(double)f[0], (double)f[1], (double)f[2]};
        double x = stp_dotd(right, p) / c->pixel_size + shift[0];
        double y = stp_dotd(down, p) / c->pixel_size + shift[1];
        if (x >= 0.0 && y >= 0.0 && x < (double)side && y < (double)side) {
            paint(c, i, reach, pixels, (size_t)y * side + (size_t)x);
        }
    }
    for (int kind = 0; kind < KIND_COUNT; ++kind) {
        char path[4096];
        snprintf(path, sizeof(path), "%s/%s%u.png", args.pictures, names[kind], view);
        stp_image image = {side, side, pixels[kind]};
        result = result == STP_OK ? tool_write_picture(context, &image, path) : result;
        stp_free(context, pixels[kind]);
    }
    return result;
}

static stp_result write_pictures(stp_context* context, const stp_candidates* c)
{
    if (c->count == 0) {
        return STP_OK;
    }
    if (mkdir(args.pictures, 0777) != 0 && errno != EEXIST) {
        return stp_fail(context, STP_ERROR_IO, "%s: %s", args.pictures, strerror(errno));
    }
    stp_vec3d* directions = STP_NEW_ARRAY(context, stp_vec3d, c->direction_count);
    if (directions == NULL) {
        return stp_fail(context, STP_ERROR_OUT_OF_MEMORY, "out of memory");
    }
    stp_capture_directions(c->direction_count, directions);
    double reach = 1e-30;
    for (size_t i = 0; i < 3 * (size_t)c->count; ++i) {
        reach = fmax(reach, fabs((double)c->positions[i]));
    }
    stp_result result = STP_OK;
    for (uint32_t view = 0; result == STP_OK && view < c->direction_count; ++view) {
        result = write_view(context, c, view, directions[view], reach);
    }
    stp_free(context, directions);
    return result;
}

static stp_result write_candidates(stp_context* context, const stp_candidates* c)
{
    uint32_t* order = STP_NEW_ARRAY(context, uint32_t, (size_t)c->count + 1);
    if (order == NULL) {
        return stp_fail(context, STP_ERROR_OUT_OF_MEMORY, "out of memory");
    }
    for (uint32_t i = 0; i < c->count; ++i) {
        order[i] = i;
    }
    tool_points points = {.count = c->count,
                          .origin = {c->origin.x, c->origin.y, c->origin.z},
                          .positions = c->positions,
                          .normals = c->normals,
                          .colors = c->colors};
    stp_result result = tool_write_points(context, args.output, &points, order, c->count);
    stp_free(context, order);
    return result;
}

static stp_result capture_scene(stp_context* context, const stp_scene* scene)
{
    stp_placed_part* parts;
    size_t part_count, kept = 0;
    stp_result result = stp_scene_flatten(scene, scene->root, MAX_PARTS, &parts, &part_count);
    if (result != STP_OK) {
        return result;
    }
    for (size_t i = 0; i < part_count; ++i) {
        if ((parts[i].flags & STP_OBJECT_MOVING) == 0) {
            parts[kept++] = parts[i];
        }
    }
    stp_capture_desc desc = {.direction_count = (uint32_t)args.directions,
                             .resolution = (uint32_t)args.resolution,
                             .wanted_candidates = args.candidates,
                             .no_fill = args.no_fill};
    stp_candidates candidates;
    result = stp_capture_parts(scene, parts, kept, &desc, &candidates);
    stp_free(context, parts);
    if (result != STP_OK) {
        return result;
    }
    if (args.output != NULL) {
        result = write_candidates(context, &candidates);
    }
    if (result == STP_OK && args.pictures != NULL) {
        result = write_pictures(context, &candidates);
    }
    if (result == STP_OK) {
        printf(
            "%u candidates, %u of them filled in; %u directions, %u pixels, %.4g units per pixel\n",
            candidates.count, candidates.filled, candidates.direction_count, candidates.resolution,
            candidates.pixel_size);
    }
    stp_candidates_destroy(context, &candidates);
    return result;
}

static int run(int argc, char** argv)
{
    if (argc != 1 || (args.output == NULL && args.pictures == NULL)) {
        return tool_usage_error("capture: expected one model, and -o OUT.ply or --pictures FOLDER");
    }
    int refused = overwrite_check(argv[0], args.output);
    if (refused != 0) {
        return refused;
    }
    stp_context* context = tool_context_create((uint32_t)args.threads, 0, NULL);
    if (context == NULL) {
        return 1;
    }
    stp_scene* scene = NULL;
    stp_result result = tool_import_scene(context, argv[0], &scene);
    result = result == STP_OK ? capture_scene(context, scene) : result;
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    return result == STP_OK ? 0 : 1;
}

const command command_capture = {
    .name = "capture",
    .arguments = "MODEL [-o OUT.ply] [--pictures FOLDER]",
    .summary = "sample the surface of a model: the candidates for surfels",
    .text = "Renders the model in parallel projection from the corners of a cube around it and "
            "writes the visible surface as points with normals and colours. `stipple build` "
            "chooses surfels from these candidates; they are also a useful input for `stipple "
            "order`.\n\n"
            "--pictures writes positionN.png, normalN.png and colorN.png for each direction N.",
    .examples = "Write the candidates:\n"
                "$ stipple-lab capture plant.glb -o points.ply\n"
                "Write the captured pictures (three for each of eight directions):\n"
                "$ stipple-lab capture plant.glb --pictures views\n",
    .files = "OUT.ply\tbinary PLY: points with normals and colours\n"
             "FOLDER/position0.png\tand so on: positions, normals and colours of each direction\n",
    .options = options,
    .run = run,
};

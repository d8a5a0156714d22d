// SPDX-License-Identifier: MIT
//
// stipple render: one picture of a scene.
#include "command.h"
#include "picture.h"
#include "scene_file.h"
#include "tool.h"

#include "base/clock.h"
#include "draw/draw.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { REPEATS = 9 };
static const double repeat_ms = 3000.0; // no more repeats once they have taken this long

static struct {
    const char* output;
    uint32_t size[2];
    const char* view;
    double eye[3], target[3], up[3];
    bool has_eye, has_target, has_up, has_fov;
    double fov, ortho;
    int backend;
    double splat_size;
    uint64_t splats;
    bool has_splat_size, has_splats;
    double splat_scale;
    int policy;
    bool reference;
    uint64_t supersample;
    int light;
    const char* background;
    uint64_t threads, memory;
    bool json;
} args;

enum { BACKEND_AUTO, BACKEND_CPU, BACKEND_GL };
enum { LIGHT_SUN, LIGHT_HEAD };

static const option* options(void)
{
    static const option table[] = {
        {.name = "output",
         .letter = 'o',
         .type = OPTION_TEXT,
         .argument = "OUT.png",
         .help = "the picture to write",
         .value = &args.output},
        {.name = "size",
         .type = OPTION_PIXELS,
         .argument = "WxH",
         .help = "pixels; default 1920x1080",
         .value = args.size},
        {.name = "view",
         .type = OPTION_TEXT,
         .argument = "NAME",
         .help = "a view of the file, or front, back, left, right, top, bottom, iso, d0 to d25; "
                 "default iso",
         .value = &args.view},
        {.name = "eye",
         .type = OPTION_VECTOR,
         .argument = "X,Y,Z",
         .help = "where the eye is",
         .value = args.eye,
         .given = &args.has_eye},
        {.name = "target",
         .type = OPTION_VECTOR,
         .argument = "X,Y,Z",
         .help = "what it looks at; default the middle of the scene",
         .value = args.target,
         .given = &args.has_target},
        {.name = "up",
         .type = OPTION_VECTOR,
         .argument = "X,Y,Z",
         .help = "what is up in the picture; default 0,1,0",
         .value = args.up,
         .given = &args.has_up},
        {.name = "fov",
         .type = OPTION_NUMBER,
         .argument = "DEG",
         .words = "1..179",
         .help = "vertical field of view; default the view's own, or 60",
         .value = &args.fov,
         .given = &args.has_fov},
        {.name = "ortho",
         .type = OPTION_NUMBER,
         .argument = "HEIGHT",
         .words = "1e-9..1e12",
         .help =
             "parallel projection, of so many units from top to bottom; standard views choose it",
         .value = &args.ortho},
        {.name = "backend",
         .type = OPTION_CHOICE,
         .argument = "NAME",
         .words = "auto|cpu|gl",
         .help = "what draws; default auto",
         .value = &args.backend},
        {.name = "splat-size",
         .type = OPTION_NUMBER,
         .argument = "PX",
         .words = "1..64",
         .help = "size of splats in pixels; default 1",
         .value = &args.splat_size,
         .given = &args.has_splat_size},
        {.name = "splats",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "1..4294967294",
         .help = "draw exactly N splats",
         .value = &args.splats,
         .given = &args.has_splats},
        {.name = "splat-scale",
         .type = OPTION_NUMBER,
         .argument = "F",
         .words = "0.01..100",
         .help = "shrink or grow splats: 0.3 shows how they are distributed",
         .value = &args.splat_scale},
        {.name = "policy",
         .type = OPTION_CHOICE,
         .argument = "NAME",
         .words = "insertion|paper|switch",
         .help = "how many splats of a node are drawn: by insertion radius, by the estimate of "
                 "Brandt 4.1, or without blending between levels; default insertion",
         .value = &args.policy},
        {.name = "reference",
         .help = "original triangles and points only",
         .value = &args.reference},
        {.name = "supersample",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "1..16",
         .help = "N x N samples a pixel; default 1",
         .value = &args.supersample},
        {.name = "light",
         .type = OPTION_CHOICE,
         .argument = "NAME",
         .words = "sun|head",
         .help = "light from above the viewer's left shoulder, or from the eye; default sun",
         .value = &args.light},
        {.name = "background",
         .type = OPTION_TEXT,
         .argument = "RRGGBB",
         .help = "colour behind the scene, in hexadecimal; default none (transparent)",
         .value = &args.background},
        {.name = "threads",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "0..1024",
         .help = "threads that work; default all processors",
         .value = &args.threads},
        {.name = "memory",
         .type = OPTION_SIZE,
         .argument = "SIZE",
         .help = "most memory; default no limit",
         .value = &args.memory},
        {.name = "json", .help = "print figures as one JSON object", .value = &args.json},
        {0},
    };
    return table;
}

/// Six hexadecimal digits, perhaps after a #.
static bool parse_color(const char* text, uint8_t color[3])
{
    text += *text == '#' ? 1 : 0;
    if (strlen(text) != 6 || strspn(text, "0123456789abcdefABCDEF") != 6) {
        return false;
    }
    unsigned long value = strtoul(text, NULL, 16);
    color[0] = (uint8_t)(value >> 16);
    color[1] = (uint8_t)(value >> 8);
    color[2] = (uint8_t)value;
    return true;
}

static stp_vec3d vector_of(const double v[3])
{
    return (stp_vec3d){v[0], v[1], v[2]};
}

/// @return 0, or 2 with the message printed
static int choose_view(const stp_store* store, stp_view* view)
{
    *view = (stp_view){.width = args.size[0] != 0 ? args.size[0] : 1920,
                       .height = args.size[1] != 0 ? args.size[1] : 1080,
                       .fov_degrees = args.has_fov ? args.fov : 0.0,
                       .ortho_height = args.ortho};
    const char* name = args.view != NULL ? args.view : "iso";
    if (!tool_find_view(store, name, view)) {
        return tool_usage_error("there is no view named %s", name);
    }
    if (args.has_eye || args.has_target) {
        view->eye = args.has_eye ? vector_of(args.eye) : view->eye;
        view->target = args.has_target ? vector_of(args.target) : view->target;
        view->up = (stp_vec3d){0, 1, 0};
        view->ortho_height = args.ortho;
    }
    if (args.has_up) {
        view->up = vector_of(args.up);
    }
    view->fov_degrees = view->fov_degrees > 0.0 ? view->fov_degrees : 60.0;
    return 0;
}

typedef struct session {
    stp_context* context;
    stp_store* store;
    stp_renderer* renderer;
    stp_draw_list list;
    stp_image image;
    stp_view view;
    stp_quality quality;
    stp_draw_style style;
    stp_draw_stats stats;
    double frame_ms, select_ms, draw_ms, shade_ms;
} session;

static stp_result draw_frame(session* s, double times[4])
{
    double start = stp_clock_ms();
    stp_result result = stp_select(s->context, s->store, &s->view, &s->quality, &s->list);
    double selected = stp_clock_ms();
    if (result == STP_OK) {
        result =
            stp_renderer_draw(s->renderer, &s->view, &s->list, &s->style, &s->image, &s->stats);
    }
    times[0] = stp_clock_ms() - start;
    times[1] = selected - start;
    times[2] = s->stats.draw_ms;
    times[3] = s->stats.shade_ms;
    return result;
}

static int compare_times(const void* a, const void* b)
{
    double x = ((const double*)a)[0], y = ((const double*)b)[0];
    return (x > y) - (x < y);
}

/// Draws the frame, again and again where figures are wanted: the first finds nothing in caches.
static stp_result draw_frames(session* s)
{
    double times[REPEATS][4], total = 0.0;
    stp_result result = draw_frame(s, times[0]);
    size_t count = 0;
    while (result == STP_OK && args.json && count < REPEATS && (count < 3 || total < repeat_ms)) {
        result = draw_frame(s, times[count]);
        total += times[count++][0];
    }
    qsort(times, count, sizeof(times[0]), compare_times);
    const double* middle = times[count / 2];
    s->frame_ms = middle[0];
    s->select_ms = middle[1];
    s->draw_ms = middle[2];
    s->shade_ms = middle[3];
    return result;
}

/// What the processor calls itself.
static void read_device(char* name, size_t size)
{
    snprintf(name, size, "CPU");
    FILE* file = fopen("/proc/cpuinfo", "r");
    char line[256];
    while (file != NULL && fgets(line, sizeof(line), file) != NULL) {
        const char* colon = strchr(line, ':');
        if (strncmp(line, "model name", 10) == 0 && colon != NULL) {
            snprintf(name, size, "%.*s", (int)strcspn(colon + 2, "\n"), colon + 2);
            break;
        }
    }
    if (file != NULL) {
        fclose(file);
    }
}

static int print_json(const session* s)
{
    char device[200];
    read_device(device, sizeof(device));
    uint64_t meshes = 0;
    for (size_t i = 0; i < s->list.count; ++i) {
        meshes += s->list.items[i].kind == STP_DRAW_MESH;
    }
    uint64_t resident = stp_context_live_bytes(s->context) + stp_store_file_bytes(s->store);
    json_t* object =
        json_pack("{s:s, s:s, s:I, s:I, s:f, s:f, s:f, s:f, s:f}", "backend", "cpu", "device",
                  device, "width", (json_int_t)s->view.width, "height", (json_int_t)s->view.height,
                  "splat_size", (double)s->list.splat_size, "frame_ms", s->frame_ms, "select_ms",
                  s->select_ms, "draw_ms", s->draw_ms, "shade_ms", s->shade_ms);
    json_t* counts = json_pack(
        "{s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I}", "splats", (json_int_t)s->stats.splats,
        "fragments", (json_int_t)s->stats.fragments, "clusters", (json_int_t)meshes, "triangles",
        (json_int_t)s->stats.triangles, "nodes", (json_int_t)s->list.node_count, "draw_calls",
        (json_int_t)s->stats.draw_calls, "resident_bytes", (json_int_t)resident, "covered_pixels",
        (json_int_t)s->stats.covered_pixels);
    if (object == NULL || counts == NULL || json_object_update(object, counts) != 0) {
        json_decref(object);
        json_decref(counts);
        return tool_error("out of memory");
    }
    json_decref(counts);
    return tool_print_json(object);
}

/// Who asks for nothing of splats gets a picture soon.
static scene_use choose_use(void)
{
    bool splats = args.has_splat_size || args.has_splats || args.splat_scale > 0.0 ||
                  args.policy != STP_POLICY_INSERTION;
    return args.reference ? SCENE_FOR_ORIGINALS : splats ? SCENE_FOR_SPLATS : SCENE_FOR_A_PICTURE;
}

/// An empty picture is rarely what was wanted: it should not look like a scene without content.
static void explain_empty(const session* s, const char* path)
{
    if (s->stats.covered_pixels == 0) {
        bool any = stp_store_get_directory(s->store)->root != STP_STORE_NONE;
        stp_warn(s->context, "%s: the picture is empty: %s", path,
                 !any                 ? "so is the scene"
                 : s->list.count == 0 ? "nothing of the scene lies in the view"
                                      : "what lies in the view covers the middle of no pixel");
    }
}

static int render(session* s, const char* path)
{
    if (tool_open_scene_for(s->context, path, choose_use(), &s->store) != STP_OK) {
        return 1;
    }
    int code = choose_view(s->store, &s->view);
    if (code != 0) {
        return code;
    }
    s->image = (stp_image){.width = s->view.width, .height = s->view.height};
    s->image.pixels = stp_alloc_array(s->context, (size_t)s->view.width * s->view.height, 4);
    if (s->image.pixels == NULL) {
        return tool_error("out of memory for a picture of %ux%u", s->view.width, s->view.height);
    }
    stp_result result = stp_draw_cpu_create(s->context, s->store, &s->renderer);
    if (result == STP_OK) {
        result = draw_frames(s);
    }
    if (result == STP_OK) {
        explain_empty(s, path);
        result = tool_write_picture(s->context, &s->image, args.output);
    }
    return result != STP_OK ? 1 : args.json ? print_json(s) : 0;
}

static int check_arguments(int argc, const char* path, stp_draw_style* style)
{
    if (argc != 1) {
        return tool_usage_error("render needs one file, and got %d", argc);
    }
    if (args.output == NULL) {
        return tool_usage_error("render needs -o OUT.png");
    }
    if (tool_is_same_file(path, args.output)) {
        return tool_usage_error("%s is the scene, and would be written over", path);
    }
    if (args.json && strcmp(args.output, "-") == 0) {
        return tool_usage_error("standard output is for the figures; name a file");
    }
    if (args.has_splat_size && args.has_splats) {
        return tool_usage_error("--splat-size and --splats exclude each other");
    }
    if (args.backend == BACKEND_GL) {
        return tool_usage_error("this build has no gl backend; use --backend cpu");
    }
    if (args.background != NULL) {
        style->background = true;
        if (!parse_color(args.background, style->background_color)) {
            return tool_usage_error("--background is six hexadecimal digits, not %s",
                                    args.background);
        }
    }
    return 0;
}

static int run(int argc, char** argv)
{
    session s = {.style = {.splat_scale = (float)args.splat_scale,
                           .supersample = (uint32_t)args.supersample,
                           .headlight = args.light == LIGHT_HEAD},
                 .quality = {.splat_size = (float)args.splat_size,
                             .splat_count = args.splats,
                             .policy = (stp_policy)args.policy,
                             .reference = args.reference}};
    int code = check_arguments(argc, argv[0], &s.style);
    if (code != 0) {
        return code;
    }
    s.context = tool_context_create((uint32_t)args.threads, args.memory, NULL);
    if (s.context == NULL) {
        return 1;
    }
    code = render(&s, argv[0]);
    stp_free(s.context, s.image.pixels);
    stp_renderer_destroy(s.renderer);
    stp_draw_list_destroy(s.context, &s.list);
    if (s.store != NULL) {
        stp_store_close(s.store);
    }
    stp_context_destroy(s.context);
    return code;
}

const command command_render = {
    .name = "render",
    .arguments = "FILE -o OUT.png",
    .summary = "draw one picture of a scene",
    .text =
        "Draws the scene as splats where they are good enough, and as its own triangles elsewhere. "
        "--splat-size says what is good enough: 1 is a splat a pixel, larger is faster.\n"
        "\n"
        "A model is built into a cache first ($XDG_CACHE_HOME/stipple, or ~/.cache/stipple). Where "
        "nothing is asked of splats and the model has more than 100,000 triangles, it is built "
        "without surfels, which takes a tenth of the time, and drawn as triangles; so it is for "
        "--reference. More than 134 million triangles, all instances counted, always get surfels.\n"
        "\n"
        "The picture is transparent where nothing was drawn. --json prints what was drawn and how "
        "long it took: frame_ms is the median of repeated frames, without opening the file.",
    .options = options,
    .run = run,
};

// SPDX-License-Identifier: MIT
//
// stipple fly: draws a camera flight through a scene, without a window.
#include "program/drawing/drawing.h"
#include "program/drawing/flight_report.h"
#include "program/files/import_options.h"
#include "program/files/scene_file.h"
#include "program/options/command.h"
#include "program/options/tool.h"
#include "program/present/canvas.h"
#include "program/present/video.h"

#include <string.h>

static struct {
    const char *path, *output, *plot;
    uint64_t frames, reference_every;
    bool popping;
    draw_options draw;
    model_axes axes;
    double smooth;
} args;

static const option* options(void)
{
    static const option own[] = {
        {.name = "output",
         .letter = 'o',
         .type = OPTION_TEXT,
         .argument = "OUT.mp4|DIR/",
         .help = "write a film (with ffmpeg), or PNG files into a folder",
         .value = &args.output,
         .group = "Output"},
        {.name = "plot",
         .type = OPTION_TEXT,
         .argument = "OUT.svg",
         .help = "plot frame time, splat size, splats and triangles over the flight",
         .value = &args.plot},
        {.name = "path",
         .type = OPTION_TEXT,
         .argument = "FLIGHT.json",
         .help = "flight: camera keyframes over time",
         .value = &args.path,
         .group = "Camera"},
        {.name = "frames",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "1..1000000",
         .help = "number of frames, spread evenly over the flight; default from its fps",
         .value = &args.frames},
        {.name = "reference-every",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "1..1000000",
         .help = "compare every N-th frame, starting with the first, with the original geometry",
         .value = &args.reference_every,
         .group = "Measuring",
         .rare = true},
        {.name = "popping",
         .help = "measure popping: changes between frames that the original geometry does not "
                 "show",
         .value = &args.popping,
         .rare = true},
        OPTION_MODEL_UP("model-up", &args.axes),
        OPTION_MODEL_UNIT(&args.axes),
        OPTION_SMOOTH(&args.smooth),
        {0},
    };
    static option table[OPTION_TABLE_ROOM];
    return draw_options_table(table, own, &args.draw);
}

typedef struct session {
    drawing drawing;
    stp_flight flight;
    video film;
    flight_plan plan;
    flight_record record;
} session;

static int print_json(const session* s)
{
    const stp_residency* residency = s->drawing.maker.residency;
    json_t* object = drawing_describe(&s->drawing, &s->plan.view);
    const char* method = draw_options_method(&args.draw, s->drawing.store);
    json_t* name = method != NULL ? json_string(method) : json_null();
    json_t* threads = json_integer(stp_context_thread_count(s->drawing.context));
    json_t* figures = flight_describe(&s->record);
    if (json_object_set_new(object, "threads", threads) != 0 ||
        json_object_set_new(object, "method", name) != 0 ||
        json_object_set_new(
            object, "coarse_method",
            json_pack("s?", draw_options_coarse_method(&args.draw, s->drawing.store))) != 0 ||
        figures == NULL || json_object_update(object, figures) != 0) {
        json_decref(object);
        json_decref(figures);
        return tool_error("out of memory");
    }
    json_decref(figures);
    if (residency != NULL &&
        json_object_set_new(object, "residency",
                            flight_describe_residency(&s->record, residency)) != 0) {
        json_decref(object);
        return tool_error("out of memory");
    }
    return tool_print_json(object);
}

static int report(const session* s)
{
    if (args.plot != NULL &&
        flight_plot(s->drawing.context, args.plot, &s->record, s->plan.budget_ms) != STP_OK) {
        return 1;
    }
    if (args.draw.json) {
        return print_json(s);
    }
    tool_end_progress();
    flight_print(&s->record);
    return tool_finish_output(0);
}

// @return the exit code, with the message printed
static int make_plan(session* s)
{
    s->plan = (flight_plan){.flight = &s->flight,
                            .frame_count = (uint32_t)args.frames,
                            .view = draw_options_view(&args.draw),
                            .quality = draw_options_quality(&args.draw),
                            .budget_ms = args.draw.budget_ms,
                            .controller = (stp_controller)args.draw.controller,
                            .reference_every = (uint32_t)args.reference_every,
                            .popping = args.popping};
    if (flight_count_frames(&s->plan) > FLIGHT_FRAMES_MAX) {
        return tool_error("%s: has %u frames, more than %d; choose fewer with --frames", args.path,
                          flight_count_frames(&s->plan), FLIGHT_FRAMES_MAX);
    }
    return 0;
}

static bool open_film(session* s)
{
    double seconds = s->flight.keys[s->flight.key_count - 1].t - s->flight.keys[0].t;
    bool spread = args.frames > 1 && seconds > 0.0;
    double fps = spread ? (double)(args.frames - 1) / seconds : s->flight.fps;
    s->plan.sink = video_add;
    s->plan.sink_user = &s->film;
    return video_open(s->drawing.context, args.output, s->plan.view.width, s->plan.view.height, fps,
                      &s->film);
}

/// @return the exit code, with the message printed
static int fly_through(session* s, const char* file)
{
    drawing* d = &s->drawing;
    if (drawing_open(d, &args.draw, file) != STP_OK) {
        return 1;
    }
    s->plan.quality = draw_options_quality(&args.draw);
    s->plan.view.eye_distance = draw_options_eye_distance(&args.draw, d->store);
    int code = draw_options_check_method(&args.draw, d->store, file);
    code = code == 0 ? scene_show_apply(&d->show, &args.draw.show, &s->plan.view) : code;
    if (code != 0) {
        return code;
    }
    s->plan.quality.visibility = d->show.visibility;
    bool flown = drawing_make(d, &args.draw) == STP_OK &&
                 flight_run(&d->maker, &s->plan, &s->record) == STP_OK;
    return flown ? 0 : 1;
}

static int fly(session* s, const char* file)
{
    int code =
        stp_flight_read(s->drawing.context, args.path, &s->flight) == STP_OK ? make_plan(s) : 1;
    if (code != 0) {
        return code;
    }
    // checks the outputs before the long build and flight
    if (args.plot != NULL && svg_check(s->drawing.context, args.plot) != STP_OK) {
        return 1;
    }
    if (args.output != NULL && !open_film(s)) {
        return 1;
    }
    code = fly_through(s, file);
    if (!video_close(&s->film, code == 0)) {
        return 1;
    }
    return code == 0 ? report(s) : code;
}

static bool ends_with(const char* name, const char* ending)
{
    const char* last = strrchr(name, '.');
    return last != NULL && strcmp(last, ending) == 0;
}

static int check_arguments(int argc, const char* file)
{
    if (argc != 1) {
        return tool_usage_error("fly needs one file, but got %d", argc);
    }
    if (args.path == NULL) {
        return tool_usage_error("fly needs --path FLIGHT.json");
    }
    const char* const outputs[] = {args.output, args.plot};
    for (int i = 0; i < 2; ++i) {
        if (outputs[i] != NULL &&
            (tool_is_same_file(file, outputs[i]) || tool_is_same_file(args.path, outputs[i]))) {
            return tool_usage_error("%s is an input and would be overwritten", outputs[i]);
        }
    }
    if (args.plot != NULL && strcmp(args.plot, "-") == 0) {
        return tool_usage_error("--plot needs a file name: standard output is not supported");
    }
    if (args.plot != NULL && !ends_with(args.plot, ".svg")) {
        return tool_usage_error("--plot needs a name OUT.svg, not %s", args.plot);
    }
    if (args.output != NULL && !video_is_folder(args.output) && !ends_with(args.output, ".mp4")) {
        return tool_usage_error("-o needs a film OUT.mp4 or a folder DIR/, not %s", args.output);
    }
    return draw_options_check(&args.draw);
}

static int run(int argc, char** argv)
{
    int code = check_arguments(argc, argv[0]);
    code = code == 0 ? tool_take_axes(&args.axes, argc, argv) : code;
    code = code == 0 ? tool_take_smooth(args.smooth, argc, argv) : code;
    if (code != 0) {
        return code;
    }
    session s = {0};
    args.draw.in_motion = true;
    if (!drawing_begin(&s.drawing, &args.draw)) {
        return 1;
    }
    code = fly(&s, argv[0]);
    flight_record_destroy(s.drawing.context, &s.record);
    stp_flight_destroy(s.drawing.context, &s.flight);
    drawing_end(&s.drawing);
    return code;
}

const command command_fly = {
    .name = "fly",
    .arguments = "FILE --path FLIGHT.json",
    .summary = "draw a camera flight through a scene: figures, plots, a film",
    .text = "Draws a camera flight and reports frame times and what was drawn. Before the "
            "flight, the first view is drawn until caches are warm or --budget-ms has found its "
            "splat size. Writing pictures (-o), comparing (--reference-every) and measuring "
            "popping (--popping) happen in a second pass with the same splat sizes, so they do "
            "not affect the frame times.\n\n"
            "With --memory, data is loaded during the flight and no frame waits for it: missing "
            "data is drawn coarser. The second pass waits until everything that fits is "
            "loaded.\n\n"
            "A flight is JSON: { \"fov\": 60, \"fps\": 60, \"keys\": [ { \"t\": 0, \"eye\": [0, "
            "2, 30], \"target\": [0, 2, 0], \"up\": [0, 1, 0] }, ... ] }. The camera follows "
            "Catmull-Rom curves between the keys. lab/scenes/flights has a flight for each named "
            "scene.\n\n"
            "Popping is measured on blocks of 8 x 8 pixels: how much more they change between "
            "frames (mean over pixels and channels, 0 to 255) than in pictures of the original "
            "geometry. SSIM and popping compare with the originals drawn like the frame: with its "
            "samples and its pixel filter. The truth of a compared frame is its covered SSIM to "
            "the originals with 16 samples a pixel; exact is the truth of the originals with one "
            "sample, filtered is the same after the pixel filter, and ratio is truth / exact. "
            "--reference-every and --popping draw that geometry, which takes long in "
            "large scenes; --plot shows their results.",
    .examples = "Fly at 33 ms per frame and plot the times:\n"
                "$ stipple fly plant.stip --path flight.json --budget-ms 33 --plot flight.svg\n"
                "Write a film:\n"
                "$ stipple fly plant.stip --path flight.json -o flight.mp4\n"
                "Compare every tenth frame with the original:\n"
                "$ stipple fly plant.stip --path flight.json --reference-every 10 --json\n",
    .files =
        "FLIGHT.json\tcamera keys over time; stipple view records them, lab/scenes/flights has "
        "one for each named scene\n"
        "DIR/frame-000000.png\tpictures, with -o DIR/; removed if the flight is "
        "interrupted\n"
        "$XDG_CACHE_HOME/stipple\tcache of built models; ~/.cache/stipple if the variable "
        "is not set\n",
    .options = options,
    .run = run,
};

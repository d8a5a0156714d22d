// SPDX-License-Identifier: MIT
//
// stipple-lab scene: writes named procedural scenes as glTF files.
#include "lab/scenes/gltf_plan.h"
#include "lab/scenes/scenes.h"
#include "program/options/command.h"
#include "program/options/program.h"
#include "program/options/tool.h"

#include <stdio.h>
#include <string.h>

static struct {
    const char* output;
    double scale;
    uint64_t seed, memory;
    int progress;
    bool list, json, scale_given;
} args;

static const option* options(void)
{
    static const option table[] = {
        {.name = "output",
         .letter = 'o',
         .type = OPTION_TEXT,
         .argument = "FILE",
         .help = "file to write: .glb, or .gltf with .bin files beside it",
         .value = &args.output},
        {.name = "list", .help = "list all scenes", .value = &args.list},
        {.name = "scale",
         .type = OPTION_NUMBER,
         .argument = "S",
         .help = "share of the content to generate; default 1 (everything)",
         .value = &args.scale,
         .given = &args.scale_given},
        {.name = "seed",
         .type = OPTION_COUNT,
         .argument = "N",
         .help = "random seed; default 0",
         .value = &args.seed},
        OPTION_MEMORY(&args.memory),
        OPTION_PROGRESS(&args.progress),
        OPTION_JSON(&args.json),
        {0},
    };
    return table;
}

static int print_list(void)
{
    json_t* scenes = json_array();
    for (const scene_recipe* recipe = scene_recipes(); recipe->name != NULL; ++recipe) {
        if (args.json) {
            (void)json_array_append_new(
                scenes, json_pack("{s:s, s:s}", "name", recipe->name, "summary", recipe->summary));
        } else {
            printf("  %-15s %s\n", recipe->name, recipe->summary);
        }
    }
    if (args.json) {
        return tool_print_json(json_pack("{s:o}", "scenes", scenes));
    }
    json_decref(scenes);
    return tool_finish_output(0);
}

static int print_figures(const char* name, const gltf_figures* f)
{
    if (args.json) {
        return tool_print_json(
            json_pack("{s:s, s:f, s:I, s:I, s:I, s:I, s:I, s:i}", "scene", name, "scale",
                      args.scale, "seed", (json_int_t)args.seed, "nodes", (json_int_t)f->nodes,
                      "meshes", (json_int_t)f->meshes, "unique_triangles", (json_int_t)f->triangles,
                      "bytes", (json_int_t)f->bytes, "files", (int)f->files));
    }
    if (!tool_settings_get()->quiet) {
        printf("%s: %llu nodes, %llu meshes of %llu triangles, %llu bytes in %u file%s\n",
               args.output, (unsigned long long)f->nodes, (unsigned long long)f->meshes,
               (unsigned long long)f->triangles, (unsigned long long)f->bytes, f->files,
               f->files == 1 ? "" : "s");
    }
    return tool_finish_output(0);
}

static bool has_ending(const char* path, const char* ending)
{
    size_t length = strlen(path), size = strlen(ending);
    return length > size && strcmp(path + length - size, ending) == 0;
}

static int run(int argc, char** argv)
{
    if (args.list) {
        return argc == 0 ? print_list() : tool_usage_error("--list takes no scene");
    }
    if (argc != 1) {
        return tool_usage_error("scene needs one name (`stipple-lab scene --list`), but got %d",
                                argc);
    }
    const char* name = program_is_scene(argv[0]) ? argv[0] + strlen(SCENE_PREFIX) : argv[0];
    if (scene_find(name) == NULL) {
        return tool_usage_error("there is no scene \"%s\"; see `stipple-lab scene --list`", name);
    }
    args.scale = args.scale_given ? args.scale : 1.0;
    if (!(args.scale > 0.0) || args.scale > 1000.0) {
        return tool_usage_error("--scale must be above 0 and at most 1000");
    }
    if (args.output == NULL ||
        !(has_ending(args.output, ".glb") || has_ending(args.output, ".gltf"))) {
        return tool_usage_error("scene needs -o FILE.glb or -o FILE.gltf");
    }
    stp_context* context = tool_context_create(0, args.memory, tool_progress_names[args.progress]);
    if (context == NULL) {
        return 1;
    }
    stp_scene* scene = NULL;
    gltf_figures figures;
    scene_options settings = {.scale = args.scale, .seed = args.seed};
    stp_result result = stp_scene_create(context, &scene);
    result = result == STP_OK ? scene_make(scene, name, &settings) : result;
    result = result == STP_OK ? gltf_file_write(scene, args.output, &figures) : result;
    tool_end_progress();
    int code = result == STP_OK ? print_figures(name, &figures) : 1;
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    return code;
}

const command command_scene = {
    .name = "scene",
    .arguments = "NAME -o FILE.glb|FILE.gltf",
    .summary = "write a named procedural scene as glTF",
    .text = "Generates a scene from its name, scale and seed, with the same result on every "
            "machine. Each mesh is written once; objects become named nodes, views become "
            "cameras, and many instances of a mesh use EXT_mesh_gpu_instancing. glTF cannot "
            "share nodes, so repeated groups are written out; a scene of more than three million "
            "nodes is rejected. build, info and render accept scenes directly: `stipple build "
            "scene:NAME,scale=S,seed=N`.\n\n"
            "A .glb holds at most 4 GiB; a .gltf has as many .bin files next to it as it needs.",
    .examples = "List the scenes:\n"
                "$ stipple-lab scene --list\n"
                "Write one at a tenth of its size:\n"
                "$ stipple-lab scene paper -o paper.glb --scale 0.1\n",
    .files = "FILE.glb\t"
             "one file of at most 4 GiB\n"
             "FILE.gltf, FILE.bin\t"
             "the scene and its buffers, in as many files as they need\n",
    .options = options,
    .run = run,
};

// SPDX-License-Identifier: MIT
#include "lab/scenes/scenes.h"

#include "lab/scenes/compose.h"
#include "lab/scenes/paper.h"
#include "program/options/program.h"

#include <stdlib.h>
#include <string.h>

static const scene_recipe recipes[] = {
    {"boxes", "27 boxes of as many colours: the smallest scene", scene_make_boxes},
    {"spheres", "a sphere of spheres of spheres: nested instancing", scene_make_spheres},
    {"one-mesh", "one mesh of a million triangles times the scale", scene_make_one_mesh},
    {"power-plant", "one coal-fired power plant: pipes, steelwork, a turbine in its hall",
     scene_make_power_plant},
    {"twenty-million", "two power plants of 20 M triangles in which no part is used twice",
     scene_make_twenty_million},
    {"forest", "a thousand trees of six kinds on hilly ground, with a road", scene_make_forest},
    {"city-small", "the middle of a Roman city: a sixteenth of it", scene_make_small_city},
    {"city", "a Roman city of 26,878 unique objects", scene_make_city},
    {"terrain", "the terrain of paper alone", scene_make_terrain},
    {"bakery-line", "a line that makes doughnuts, from the mixers to the pallets",
     scene_make_bakery_line},
    {"car-factory", "presses, welding robots, paint shop, and cars in all states",
     scene_make_car_factory},
    {"paper", "the benchmark of Brandt et al. 2019: 2.35 G triangles, 86 M unique",
     scene_make_paper},
    {"paper-huge", "the same unique content 441 times: a trillion triangles",
     scene_make_paper_huge},
    {0},
};

const scene_recipe* scene_recipes(void)
{
    return recipes;
}

const scene_recipe* scene_find(const char* name)
{
    for (const scene_recipe* recipe = recipes; recipe->name != NULL; ++recipe) {
        if (strcmp(recipe->name, name) == 0) {
            return recipe;
        }
    }
    return NULL;
}

// All scenes are made in metres. If earlier inputs use another unit, converts the items added after
// them.
static void convert_unit(stp_scene* scene, const char* name, size_t first_object, size_t first_view)
{
    if (scene->unit_metres == 0.0 && first_object > 0) {
        stp_warn(scene->context,
                 "scene %s: its unit is 1 m; assumes the same unit for the inputs before it, "
                 "which specify none",
                 name);
    }
    if (scene->unit_metres == 0.0) {
        scene->unit_metres = 1.0;
    }
    double scale = 1.0 / scene->unit_metres;
    if (scale == 1.0) { // not only faster: avoids turning 0 into -0
        return;
    }
    stp_affine scaled = {{{scale, 0, 0, 0}, {0, scale, 0, 0}, {0, 0, scale, 0}}};
    for (size_t i = first_object; i < scene->object_count; ++i) {
        stp_object* object = &scene->objects[i];
        if (object->parent == STP_NONE) {
            object->transform = stp_affine_multiply(scaled, object->transform);
        }
    }
    for (size_t i = first_view; i < scene->view_count; ++i) {
        stp_scene_view* view = &scene->views[i];
        view->eye = stp_affine_point(&scaled, view->eye);
        view->target = stp_affine_point(&scaled, view->target);
    }
}

stp_result scene_make(stp_scene* scene, const char* name, const scene_options* options)
{
    const scene_recipe* recipe = scene_find(name);
    if (recipe == NULL) {
        return stp_fail(scene->context, STP_ERROR_ARGUMENT,
                        "there is no scene \"%s\" (`stipple-lab scene --list` names them)", name);
    }
    if (!(options->scale > 0.0) || options->scale > 1000.0) {
        return stp_fail(scene->context, STP_ERROR_ARGUMENT,
                        "scene %s: the scale must be above 0 and at most 1000", name);
    }
    size_t first_object = scene->object_count, first_view = scene->view_count;
    stp_result result = recipe->make(scene, options);
    if (result == STP_OK) {
        convert_unit(scene, name, first_object, first_view);
    }
    return result;
}

// Parses one setting, "scale=0.5" or "seed=3", of `length` characters.
static bool read_setting(const char* text, size_t length, scene_options* options)
{
    char copy[64], *end;
    if (length >= sizeof(copy)) {
        return false;
    }
    memcpy(copy, text, length);
    copy[length] = '\0';
    if (strncmp(copy, "scale=", 6) == 0) {
        options->scale = strtod(copy + 6, &end);
        return end != copy + 6 && *end == '\0';
    }
    if (strncmp(copy, "seed=", 5) == 0 && copy[5] != '-') {
        options->seed = strtoull(copy + 5, &end, 10);
        return end != copy + 5 && *end == '\0';
    }
    return false;
}

stp_result scene_make_input(stp_scene* scene, const char* input, void* user)
{
    (void)user;
    scene_options options = {.scale = 1.0};
    const char* text = program_is_scene(input) ? input + strlen(SCENE_PREFIX) : input;
    size_t length = strcspn(text, ",");
    char name[64];
    bool valid = length < sizeof(name);
    if (valid) {
        memcpy(name, text, length);
        name[length] = '\0';
    }
    for (text += length; valid && *text == ','; text += length) {
        length = strcspn(++text, ",");
        valid = read_setting(text, length, &options);
    }
    if (!valid) {
        return stp_fail(scene->context, STP_ERROR_ARGUMENT,
                        "%s: expected " SCENE_PREFIX "NAME[,scale=NUMBER][,seed=NUMBER]", input);
    }
    stp_result result = scene_make(scene, name, &options);
    return result != STP_OK
               ? result
               : stp_scene_add_source(scene, &(stp_source){.path = input, .format = "scene"});
}

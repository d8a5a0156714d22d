// SPDX-License-Identifier: MIT
#include "lab/scenes/city.h"

#include "lab/scenes/compose.h"

static const struct {
    const char* name;
    uint32_t srgb;
    double roughness;
} paints[PAINT_COUNT] = {
    [PAINT_WHITE] = {"white plaster", 0xe4dfd2, 0.9},
    [PAINT_CREAM] = {"cream plaster", 0xdcc9a0, 0.9},
    [PAINT_OCHRE] = {"ochre plaster", 0xc9974a, 0.9},
    [PAINT_RED] = {"red plaster", 0x9c3a2c, 0.9},
    [PAINT_ROSE] = {"rose plaster", 0xc98d78, 0.9},
    [PAINT_GREY] = {"grey plaster", 0xb0aaa0, 0.9},
    [PAINT_TUFA] = {"tufa", 0xa8987c, 0.95},
    [PAINT_BASALT] = {"basalt", 0x55565a, 0.8},
    [PAINT_KERB] = {"kerb stone", 0x8a8780, 0.9},
    [PAINT_TILE] = {"tile", 0xb0603e, 0.85},
    [PAINT_TILE_DARK] = {"dark tile", 0x8e4a34, 0.85},
    [PAINT_TILE_PALE] = {"pale tile", 0xc47e56, 0.85},
    [PAINT_WOOD] = {"wood", 0x7a5534, 0.8},
    [PAINT_WOOD_DARK] = {"dark wood", 0x4e3422, 0.8},
    [PAINT_WOOD_PALE] = {"pale wood", 0xa8845a, 0.85},
    [PAINT_MARBLE] = {"marble", 0xe8e6e0, 0.4},
    [PAINT_MARBLE_GREY] = {"grey marble", 0xc2c0bc, 0.45},
    [PAINT_MOSAIC] = {"mosaic", 0x9a9488, 0.6},
    [PAINT_TERRAZZO] = {"terrazzo", 0xb08a78, 0.7},
    [PAINT_BRICK] = {"brick", 0xa2583e, 0.9},
    [PAINT_PLANTS] = {"plants", 0x5d7a35, 0.9},
    [PAINT_SOIL] = {"soil", 0x7a6346, 0.95},
    [PAINT_CLOTH_RED] = {"red cloth", 0xa8322c, 0.9},
    [PAINT_CLOTH_BLUE] = {"blue cloth", 0x3c5a8a, 0.9},
    [PAINT_CLOTH_YELLOW] = {"yellow cloth", 0xd8b04a, 0.9},
    [PAINT_CLAY] = {"clay", 0xb8734c, 0.85},
    [PAINT_BRONZE] = {"bronze", 0x6e6040, 0.5},
    [PAINT_TREE] = {"city trees", 0xffffff, 0.9},
};

static stp_result add_paints(stp_scene* scene, uint32_t* first)
{
    *first = (uint32_t)scene->material_count;
    stp_result result = STP_OK;
    for (int i = 0; result == STP_OK && i < PAINT_COUNT; ++i) {
        result =
            add_plain_material(scene, paints[i].name, paints[i].srgb, paints[i].roughness, NULL);
        if (result == STP_OK) {
            scene->materials[scene->material_count - 1].double_sided =
                i == PAINT_TREE || i == PAINT_PLANTS ||
                (i >= PAINT_CLOTH_RED && i <= PAINT_CLOTH_YELLOW);
        }
    }
    return result;
}

static const char* const kind_names[CITY_KINDS] = {"wall",
                                                   "roof",
                                                   "floor",
                                                   "basin",
                                                   "door",
                                                   "table",
                                                   "counter",
                                                   "shrine",
                                                   "couch",
                                                   "mill",
                                                   "bed",
                                                   "awning",
                                                   "goods",
                                                   "cart",
                                                   "paving",
                                                   "kerb",
                                                   "stepping stones",
                                                   "rampart",
                                                   "tower",
                                                   "podium",
                                                   "architrave",
                                                   "gable",
                                                   "arcade",
                                                   "seats",
                                                   "beams",
                                                   "column",
                                                   "amphora",
                                                   "statue",
                                                   "fountain",
                                                   "tree"};

static stp_result make_pieces(stp_scene* scene, const city_plan* plan, uint32_t first_paint,
                              uint32_t* first_mesh)
{
    mesh_recipe* recipes = STP_NEW_ARRAY(scene->context, mesh_recipe, plan->piece_count + 1);
    if (recipes == NULL) {
        return stp_fail_memory(scene->context);
    }
    for (size_t i = 0; i < plan->piece_count; ++i) {
        const city_piece* piece = &plan->pieces[i];
        recipes[i] = (mesh_recipe){kind_names[piece->kind], city_make_piece, piece,
                                   first_paint + piece->paint};
    }
    stp_result result = make_meshes(scene, recipes, plan->piece_count, first_mesh);
    stp_free(scene->context, recipes);
    return result;
}

static stp_result add_items(stp_scene* scene, const city_plan* plan, uint32_t parent,
                            uint32_t first_mesh)
{
    uint32_t* objects = STP_NEW_ARRAY(scene->context, uint32_t, plan->item_count + 1);
    stp_result result = objects != NULL ? STP_OK : stp_fail_memory(scene->context);
    for (size_t i = 0; result == STP_OK && i < plan->item_count; ++i) {
        const city_item* item = &plan->items[i];
        uint32_t above = item->parent == STP_NONE ? parent : objects[item->parent];
        result = add_group(scene, item->name, above, &item->place, &objects[i]);
        if (result == STP_OK && item->piece != STP_NONE) {
            result = stp_scene_add_part(scene, (stp_part){STP_PART_MESH, first_mesh + item->piece});
        }
    }
    stp_free(scene->context, objects);
    return result;
}

stp_result scene_add_city(stp_scene* scene, uint32_t parent, const stp_affine* place,
                          const scene_options* options, uint32_t* object)
{
    city_plan plan;
    uint32_t top, first_paint, first_mesh;
    city_plan_begin(&plan, scene->context, options);
    city_plan_make(&plan);
    stp_result result = plan.failed ? stp_fail_memory(scene->context) : STP_OK;
    result = result == STP_OK ? add_group(scene, "Pompeii", parent, place, &top) : result;
    if (result == STP_OK && object != NULL) {
        *object = top;
    }
    result = result == STP_OK ? add_paints(scene, &first_paint) : result;
    result = result == STP_OK ? make_pieces(scene, &plan, first_paint, &first_mesh) : result;
    result = result == STP_OK ? add_items(scene, &plan, top, first_mesh) : result;
    city_plan_end(&plan);
    return result;
}

static stp_result add_city_views(stp_scene* scene, double half)
{
    stp_result result =
        add_view(scene, "overview", (stp_vec3d){-1.1 * half, 0.75 * half, -1.2 * half},
                 (stp_vec3d){0, 0, 0}, 50.0);
    result = result == STP_OK ? add_view(scene, "street", (stp_vec3d){-82.0, 2.0, -60.0},
                                         (stp_vec3d){-70.0, 2.2, 0.0}, 60.0)
                              : result;
    return result == STP_OK ? add_view(scene, "forum", (stp_vec3d){6.0, 2.0, -44.0},
                                       (stp_vec3d){-2.0, 6.0, 30.0}, 60.0)
                            : result;
}

stp_result scene_make_city(stp_scene* scene, const scene_options* options)
{
    stp_affine still = stp_affine_identity();
    stp_result result = scene_add_city(scene, STP_NONE, &still, options, NULL);
    return result == STP_OK
               ? add_city_views(scene, 400.0 * sqrt(options->scale < 1.0 ? options->scale : 1.0))
               : result;
}

// One sixteenth: the forum and its surroundings.
stp_result scene_make_small_city(stp_scene* scene, const scene_options* options)
{
    scene_options smaller = {.scale = 0.0625 * options->scale, .seed = options->seed};
    return scene_make_city(scene, &smaller);
}

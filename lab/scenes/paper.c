// SPDX-License-Identifier: MIT
#include "lab/scenes/paper.h"

#include "lab/scenes/compose.h"
#include "lab/scenes/terrain.h"

typedef stp_result (*part_adder)(stp_scene* scene, uint32_t parent, const stp_affine* place,
                                 const scene_options* options, uint32_t* object);

static const struct {
    part_adder add;
    int site;
} parts[] = {
    {scene_add_city, SITE_CITY},
    {scene_add_car_factory, SITE_CAR_FACTORY},
    {scene_add_bakery, SITE_BAKERY},
    {scene_add_power_plants, SITE_POWER_PLANTS},
};

// An overview from 200 m; the others at eye height: a street of the city, the car factory, between
// two lines of the bakery, in front of the power plants. Each looks along the terrain, so that the
// background counts as well.
const paper_view paper_views[PAPER_VIEWS] = {
    {"1", {-2540, 215, 1650}, {-900, 60, 500}, 60.0, 2.12e9},
    {"2", {-2236, 2, 250}, {-2000, 2.5, 250}, 60.0, 1.73e9},
    {"3", {-390, 2, 880}, {-200, 2.5, 800}, 60.0, 656.20e6},
    {"4", {453, 2, -665}, {350, 2.3, -630}, 65.0, 949.09e6},
    {"5", {1185, 2, 640}, {1500, 14, 300}, 65.0, 419.44e6},
};

// Adds the content below `parent`, without views. STP_NONE: each part becomes a root object.
static stp_result add_paper(stp_scene* scene, uint32_t parent, const scene_options* options)
{
    stp_affine still = stp_affine_identity();
    stp_result result = scene_add_terrain(scene, parent, &still, options, NULL);
    for (size_t i = 0; result == STP_OK && i < sizeof(parts) / sizeof(parts[0]); ++i) {
        const terrain_site* site = &terrain_sites[parts[i].site];
        stp_affine place = place_at(site->x, 0.0, site->z);
        result = parts[i].add(scene, parent, &place, options, NULL);
    }
    return result == STP_OK ? scene_add_pylons(scene, parent, options) : result;
}

static stp_result add_paper_views(stp_scene* scene)
{
    stp_result result = STP_OK;
    for (int i = 0; result == STP_OK && i < PAPER_VIEWS; ++i) {
        const paper_view* v = &paper_views[i];
        result = add_view(scene, v->name, v->eye, v->target, v->fov_degrees);
    }
    return result;
}

stp_result scene_make_paper(stp_scene* scene, const scene_options* options)
{
    stp_result result = add_paper(scene, STP_NONE, options);
    return result == STP_OK ? add_paper_views(scene) : result;
}

// 21 x 21 copies of 2.35 G triangles are a trillion. The terrain is level at its edges, so copies
// join seamlessly.
stp_result scene_make_paper_huge(stp_scene* scene, const scene_options* options)
{
    enum { COPIES = 21 };
    const double width = TILE_SIZE * TILE_COLUMNS, depth = TILE_SIZE * TILE_ROWS;
    uint32_t content = (uint32_t)scene->object_count, group;
    stp_affine still = stp_affine_identity();
    stp_object prototype = {.name = "benchmark scene",
                            .parent = STP_NONE,
                            .transform = still,
                            .flags = STP_OBJECT_PROTOTYPE};
    stp_result result = stp_scene_add_object(scene, &prototype, NULL);
    result = result == STP_OK ? add_paper(scene, content, options) : result;
    result = result == STP_OK ? add_group(scene, "land", STP_NONE, &still, &group) : result;
    for (int i = 0; result == STP_OK && i < COPIES * COPIES; ++i) {
        // the views' copy is the central one: each looks over a quarter of the others
        double x = width * (i % COPIES - COPIES / 2), z = depth * (i / COPIES - COPIES / 2);
        stp_affine place = place_at(x, 0.0, z);
        result = add_group(scene, "copy", group, &place, NULL);
        result = result == STP_OK ? stp_scene_add_use(scene, content) : result;
    }
    return result == STP_OK ? add_paper_views(scene) : result;
}

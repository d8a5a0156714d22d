// SPDX-License-Identifier: MIT
#include "lab/scenes/city.h"

#include <stdlib.h>

// Room for one more element, as stp_make_room; false, and the plan fails, if out of memory.
static bool make_room(city_plan* plan, void* array_address, size_t* capacity, size_t count,
                      size_t size)
{
    plan->failed =
        plan->failed || !stp_make_room(plan->context, array_address, capacity, count + 1, size);
    return !plan->failed;
}

// A new piece; it has four sizes. @return its number
static uint32_t add_piece(city_plan* plan, city_kind kind, uint32_t paint, double a, double b,
                          double c, double d)
{
    if (!make_room(plan, &plan->pieces, &plan->piece_capacity, plan->piece_count,
                   sizeof(*plan->pieces))) {
        return 0;
    }
    plan->pieces[plan->piece_count] = (city_piece){
        .kind = kind, .paint = paint, .seed = random_bits(&plan->random), .sizes = {a, b, c, d}};
    return (uint32_t)plan->piece_count++;
}

void city_plan_begin(city_plan* plan, stp_context* context, const scene_options* options)
{
    *plan = (city_plan){.context = context, .group = STP_NONE};
    plan->random = random_begin(options->seed + 4242);
    double scale = options->scale < 1.0 ? options->scale : 1.0;
    // Pompeii in Table 1 of Brandt et al. 2019
    plan->objects_wanted = (uint64_t)(33167.0 * scale + 0.5);
    plan->unique_wanted = (uint64_t)(26878.0 * scale + 0.5);
    plan->triangles_wanted = (uint64_t)(62.93e6 * scale);
    plan->unique_triangles_wanted = (uint64_t)(40.35e6 * scale);
    plan->columns[0] = add_piece(plan, CITY_COLUMN, PAINT_WHITE, 3.1, 0.22, 0, 0);
    plan->columns[1] = add_piece(plan, CITY_COLUMN, PAINT_MARBLE, 6.0, 0.38, 1, 0);
    plan->columns[2] = add_piece(plan, CITY_COLUMN, PAINT_MARBLE, 9.0, 0.55, 2, 0);
    plan->amphora = add_piece(plan, CITY_AMPHORA, PAINT_CLAY, 0, 0, 0, 0);
    plan->statue = add_piece(plan, CITY_STATUE, PAINT_BRONZE, 0, 0, 0, 0);
    plan->fountain = add_piece(plan, CITY_FOUNTAIN, PAINT_MARBLE_GREY, 0, 0, 0, 0);
    plan->trees[0] = add_piece(plan, CITY_TREE, PAINT_TREE, 0, 30000, 0, 0);
    plan->trees[1] = add_piece(plan, CITY_TREE, PAINT_TREE, 1, 18000, 0, 0);
}

void city_plan_end(city_plan* plan)
{
    stp_free(plan->context, plan->pieces);
    stp_free(plan->context, plan->items);
    stp_free(plan->context, plan->triangles);
    stp_free(plan->context, plan->tree_spots);
    stp_free(plan->context, plan->jar_spots);
}

static uint32_t add_item(city_plan* plan, const city_item* item)
{
    if (!make_room(plan, &plan->items, &plan->item_capacity, plan->item_count, sizeof(*item))) {
        return 0;
    }
    plan->items[plan->item_count] = *item;
    return (uint32_t)plan->item_count++;
}

uint32_t city_enter(city_plan* plan, const char* name, bool top, stp_affine place)
{
    uint32_t former = plan->group;
    plan->group = add_item(plan, &(city_item){.name = name,
                                              .parent = top ? STP_NONE : former,
                                              .piece = STP_NONE,
                                              .place = place});
    return former;
}

void city_show(city_plan* plan, const char* name, uint32_t piece, stp_affine place)
{
    add_item(plan, &(city_item){name, plan->group, piece, place});
    plan->objects += 1;
}

void city_put(city_plan* plan, const char* name, city_kind kind, uint32_t paint, double a, double b,
              double c, double d, stp_affine place)
{
    city_show(plan, name, add_piece(plan, kind, paint, a, b, c, d), place);
}

void city_tree_spot(city_plan* plan, double x, double y, double z)
{
    if (make_room(plan, &plan->tree_spots, &plan->tree_spot_capacity, plan->tree_spot_count,
                  sizeof(city_spot))) {
        plan->tree_spots[plan->tree_spot_count++] = (city_spot){plan->group, x, y, z};
    }
}

void city_jar_spot(city_plan* plan, double x, double y, double z)
{
    if (make_room(plan, &plan->jar_spots, &plan->jar_spot_capacity, plan->jar_spot_count,
                  sizeof(city_spot))) {
        plan->jar_spots[plan->jar_spot_count++] = (city_spot){plan->group, x, y, z};
    }
}

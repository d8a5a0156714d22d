// SPDX-License-Identifier: MIT
//
// Houses: rooms around an atrium whose roof is open in the middle, and behind it, where the lot is
// wide enough, a garden between colonnades. Narrow lots have a shop with a flat above it.
#include "lab/scenes/city.h"

enum { WALLS = 6, ROOFS = 3, CLOTHS = 3 };
static const uint32_t wall_paints[WALLS] = {PAINT_WHITE, PAINT_CREAM, PAINT_OCHRE,
                                            PAINT_RED,   PAINT_ROSE,  PAINT_GREY};
static const uint32_t roof_paints[ROOFS] = {PAINT_TILE, PAINT_TILE_DARK, PAINT_TILE_PALE};
static const uint32_t cloth_paints[CLOTHS] = {PAINT_CLOTH_RED, PAINT_CLOTH_BLUE,
                                              PAINT_CLOTH_YELLOW};

typedef struct house {
    city_plan* plan;
    double width, depth;
    uint32_t inside, outside, roof; ///< paints
} house;

static double between(const house* h, double low, double high)
{
    return random_between(&h->plan->random, low, high);
}

static void put_wall(const house* h, uint32_t paint, double x, double z, double turns,
                     double length, double height, city_openings openings)
{
    city_put(h->plan, "wall", CITY_WALL, paint, length, height, 0.35, (double)openings,
             place_turned(x, 0, z, turns, 1.0));
}

// A roof, sometimes with visible beams. The eave begins at (x, y, z) and runs along the rotated x
// axis.
static void put_roof(const house* h, double x, double y, double z, double turns, double width,
                     double run, double rise)
{
    stp_affine place = place_turned(x, y, z, turns, 1.0);
    city_put(h->plan, "roof", CITY_ROOF, h->roof, width, run, rise, 0.3, place);
    if (random_below(&h->plan->random, 8) == 0) { // seen where the room has no ceiling
        city_put(h->plan, "beams", CITY_BEAMS, PAINT_WOOD_DARK, width, run, 0, 0,
                 place_turned(x, y - 0.35, z, turns, 1.0));
    }
}

static void put_column(const house* h, double x, double y, double z)
{
    city_show(h->plan, "column", h->plan->columns[0], place_at(x, y, z));
}

// Furnishes a room of that size, from its corner.
static void furnish(const house* h, double x, double z, double width, double depth)
{
    city_plan* plan = h->plan;
    uint32_t mosaic = random_below(&plan->random, 2);
    double stone = between(h, 0.35, 0.6);
    city_put(plan, "floor", CITY_FLOOR, mosaic == 0 ? PAINT_MOSAIC : PAINT_TERRAZZO, width, depth,
             stone, 0, place_at(x, 0, z));
    switch (random_below(&plan->random, 5)) {
    case 0: {
        uint32_t cloth = random_below(&plan->random, CLOTHS);
        double couch = between(h, 1.7, 2.0);
        city_put(plan, "couch", CITY_COUCH, cloth_paints[cloth], couch, 0, 0, 0,
                 place_at(x + 0.5, 0, z + 0.5));
        break;
    }
    case 1: {
        double table_width = between(h, 1.0, 1.6);
        double table_depth = between(h, 0.6, 0.9);
        double table_height = between(h, 0.6, 0.8);
        city_put(plan, "table", CITY_TABLE, PAINT_WOOD, table_width, table_depth, table_height, 0,
                 place_at(x + 0.6, 0, z + 0.6));
        break;
    }
    case 2:
        city_put(plan, "crates", CITY_STALL, PAINT_WOOD_PALE, width - 1.0 > 1.5 ? width - 1.0 : 1.5,
                 1.4, 0, 0, place_at(x + 0.5, 0, z + 0.4));
        city_jar_spot(plan, x + width - 0.6, 0, z + depth - 0.6);
        break;
    case 3:
        city_put(plan, "shrine", CITY_SHRINE, PAINT_MARBLE_GREY, between(h, 1.8, 2.3), 0, 0, 0,
                 place_at(x + 0.5, 0, z + depth - 1.4));
        break;
    default:
        city_jar_spot(plan, x + 0.7, 0, z + 0.7);
        city_jar_spot(plan, x + 1.15, 0, z + 0.75);
        break;
    }
}

// The rooms facing the street: shops beside the entrance.
static void plan_front(const house* h, double depth, double height)
{
    double w = h->width;
    city_plan* plan = h->plan;
    put_wall(h, h->outside, 0, 0, 0, w, height, OPEN_SHOPS);
    put_wall(h, h->inside, 0, depth - 0.35, 0, w, height, OPEN_ROOMS);
    put_wall(h, h->inside, 0.42 * w, 0.4, -0.25, depth - 0.8, height, OPEN_NONE);
    put_wall(h, h->inside, 0.58 * w + 0.35, 0.4, -0.25, depth - 0.8, height, OPEN_NONE);
    city_put(plan, "door", CITY_DOOR, PAINT_WOOD_DARK, 1.4, 2.4, 0, 0,
             place_at(0.5 * w - 0.7, 0, 0.3));
    if (random_below(&plan->random, 3) == 0) {
        city_put(plan, "counter", CITY_COUNTER, PAINT_MARBLE, 0.3 * w, 0, 0, 0,
                 place_at(0.06 * w, 0, 0.5));
        city_jar_spot(plan, 0.1 * w, 0, 2.5);
    } else {
        furnish(h, 0.5, 0.8, 0.38 * w, depth - 1.6);
    }
    furnish(h, 0.6 * w, 0.8, 0.36 * w, depth - 1.6);
    if (random_below(&plan->random, 3) == 0) {
        city_put(plan, "awning", CITY_AWNING, cloth_paints[random_below(&plan->random, CLOTHS)],
                 0.34 * w, 1.3, 0, 0, place_at(0.62 * w, 0, -0.05));
    }
}

static void plan_side_walls(const house* h, double from, double to, double height)
{
    put_wall(h, h->outside, 0.35, from, -0.25, to - from, height, OPEN_WINDOWS);
    put_wall(h, h->outside, h->width, from, -0.25, to - from, height, OPEN_WINDOWS);
}

static void plan_atrium(const house* h, double from, double to, double low, double high)
{
    double w = h->width, side = 0.5 * w - 1.9, length = to - from, middle = 0.5 * (from + to);
    city_plan* plan = h->plan;
    put_wall(h, h->inside, 0.32 * w, from, -0.25, length, low, OPEN_ROOMS);
    put_wall(h, h->inside, 0.68 * w + 0.35, from, -0.25, length, low, OPEN_ROOMS);
    put_wall(h, h->inside, 0.3, middle, 0, 0.32 * w - 0.6, low, OPEN_NONE);
    put_wall(h, h->inside, 0.68 * w + 0.3, middle, 0, 0.32 * w - 0.6, low, OPEN_NONE);
    furnish(h, 0.5, from + 0.4, 0.27 * w, 0.5 * length - 0.8);
    furnish(h, 0.5, middle + 0.5, 0.27 * w, 0.5 * length - 0.9);
    furnish(h, 0.7 * w, from + 0.4, 0.27 * w, 0.5 * length - 0.8);
    furnish(h, 0.7 * w, middle + 0.5, 0.27 * w, 0.5 * length - 0.9);
    put_roof(h, side, low, from, -0.25, length, side, high - low);
    put_roof(h, w - side, low, to, 0.25, length, side, high - low);
    double opening = 1.7, run = 0.5 * length - opening;
    put_roof(h, w - side, low + 0.02, from + run, 0.5, w - 2 * side, run, 0.8 * (high - low));
    put_roof(h, side, low + 0.02, to - run, 0.0, w - 2 * side, run, 0.8 * (high - low));
    city_put(plan, "impluvium", CITY_BASIN, PAINT_MARBLE, 2.6, 2.6, 0, 0,
             place_at(0.5 * w - 1.3, 0, middle - 1.3));
    city_put(plan, "atrium floor", CITY_FLOOR, PAINT_MOSAIC, 0.34 * w, length - 0.8, 0.3, 0,
             place_at(0.33 * w, 0, from + 0.4));
    if (random_below(&plan->random, 4) == 0) {
        city_show(plan, "statue", plan->statue, place_turned(0.5 * w, 0, to - 1.2, 0.0, 0.8));
    }
}

static void plan_garden(const house* h, double from, double to, double height)
{
    double w = h->width, arm = 2.6, length = to - from;
    city_plan* plan = h->plan;
    put_roof(h, arm, height, from, -0.25, length, arm, 0.9);
    put_roof(h, w - arm, height, to, 0.25, length, arm, 0.9);
    put_roof(h, arm, height, to - arm, 0.0, w - 2 * arm, arm, 0.9);
    int along = (int)((length - arm) / 3.4), across = (int)((w - 2 * arm) / 3.2);
    for (int i = 0; i <= along; ++i) {
        double z = from + 0.3 + (length - arm - 0.3) * i / (along > 0 ? along : 1);
        put_column(h, arm, 0, z);
        put_column(h, w - arm, 0, z);
    }
    for (int i = 1; i < across; ++i) {
        put_column(h, arm + (w - 2 * arm) * i / across, 0, to - arm);
    }
    city_put(plan, "flower bed", CITY_BED, PAINT_PLANTS, w - 2 * arm - 1.0, 0.42 * (length - arm),
             0, 0, place_at(arm + 0.5, 0.1, from + 0.5));
    city_put(plan, "flower bed", CITY_BED, PAINT_PLANTS, w - 2 * arm - 1.0, 0.36 * (length - arm),
             0, 0, place_at(arm + 0.5, 0.1, from + 0.58 * (length - arm)));
    city_put(plan, "soil", CITY_FLOOR, PAINT_SOIL, w - 2 * arm - 0.4, length - arm - 0.4, 1.5, 0,
             place_at(arm + 0.2, 0.02, from + 0.2));
    city_tree_spot(plan, arm + 1.4, 0, from + 0.3 * length);
    city_tree_spot(plan, w - arm - 1.4, 0, from + 0.55 * length);
    if (random_below(&plan->random, 3) == 0) {
        city_show(plan, "fountain", plan->fountain,
                  place_at(0.5 * w, 0.02, from + 0.48 * (length - arm)));
    } else if (random_below(&plan->random, 2) == 0) {
        city_show(plan, "statue", plan->statue,
                  place_turned(0.5 * w, 0, from + 0.48 * (length - arm), 0.5, 0.8));
    }
    for (int i = 0; i < 3; ++i) {
        city_jar_spot(plan, 0.9, 0, from + length * (i + 0.5) / 3.0);
    }
    city_put(plan, "walk", CITY_FLOOR, PAINT_TERRAZZO, arm - 0.5, length - 0.5, 0.5, 0,
             place_at(0.4, 0, from));
    city_put(plan, "walk", CITY_FLOOR, PAINT_TERRAZZO, arm - 0.5, length - 0.5, 0.5, 0,
             place_at(w - arm + 0.1, 0, from));
}

// A yard with tools of trades: mills, a cart, jars.
static void plan_yard(const house* h, double from, double to)
{
    city_plan* plan = h->plan;
    double w = h->width;
    int mills = (int)random_below(&plan->random, 4);
    for (int i = 0; i < mills; ++i) {
        city_put(plan, "mill", CITY_MILL, PAINT_BASALT, between(h, 1.5, 1.8), 0, 0, 0,
                 place_at(w * (i + 0.7) / (mills + 0.5), 0, to - 2.2));
    }
    double cart = between(h, 1.9, 2.4);
    double turns = between(h, 0, 1);
    city_put(plan, "cart", CITY_CART, PAINT_WOOD, cart, 0, 0, 0,
             place_turned(0.3 * w, 0, from + 2.2, turns, 1.0));
    city_put(plan, "herbs", CITY_BED, PAINT_PLANTS, 0.5 * w, 0.3 * (to - from), 0, 0,
             place_at(0.4 * w, 0, from + 0.5 * (to - from)));
    city_put(plan, "crates", CITY_STALL, PAINT_WOOD_PALE, 2.4, 1.6, 0, 0,
             place_at(0.5, 0, to - 2.4));
    for (int i = 0; i < 4; ++i) {
        city_jar_spot(plan, w - 1.0, 0, from + 0.8 + 0.5 * i);
    }
    city_tree_spot(plan, 0.7 * w, 0, from + 0.4 * (to - from));
}

void city_plan_house(city_plan* plan, double width, double depth)
{
    random_stream* random = &plan->random;
    house h = {.plan = plan, .width = width, .depth = depth};
    h.inside = wall_paints[random_below(random, WALLS)];
    h.outside = wall_paints[random_below(random, WALLS)];
    h.roof = roof_paints[random_below(random, ROOFS)];
    bool wide = width > 11.5;
    double front = random_between(random, 4.6, 5.6), low = random_between(random, 3.9, 4.4);
    double height = wide ? random_between(random, 4.9, 5.5) : random_between(random, 6.4, 7.2);
    plan_front(&h, front, height);
    plan_side_walls(&h, 0.0, front, height);
    if (wide) {
        double court = 0.36 * depth + front, high = low + 1.4;
        put_roof(&h, 0.0, height - 0.1, -0.35, 0.0, width, front + 0.35, 1.5);
        plan_side_walls(&h, front, court, high);
        plan_atrium(&h, front, court, low, high);
        double behind = court + 3.4;
        plan_side_walls(&h, court, behind, low + 0.8);
        put_wall(&h, h.inside, 0, court, 0, width, low + 0.8, OPEN_ROOMS);
        put_wall(&h, h.inside, 0, behind - 0.35, 0, width, low + 0.4, OPEN_ROOMS);
        furnish(&h, 0.4 * width, court + 0.4, 0.2 * width, 2.5);
        put_roof(&h, 0.0, low + 0.8, court - 0.2, 0.0, width, 1.9, 0.9);
        put_roof(&h, width, low + 0.8, behind + 0.2, 0.5, width, 1.9, 0.9);
        plan_side_walls(&h, behind, depth, low);
        plan_garden(&h, behind, depth, 3.15);
        put_wall(&h, h.outside, 0, depth - 0.35, 0, width, low, OPEN_NONE);
        return;
    }
    double house_end = 0.62 * depth;
    put_roof(&h, 0.0, height, -0.4, 0.0, width, 0.5 * house_end + 0.4, 2.0);
    put_roof(&h, width, height, house_end + 0.3, 0.5, width, 0.5 * house_end + 0.3, 2.0);
    plan_side_walls(&h, front, house_end, height);
    put_wall(&h, h.outside, 0, house_end - 0.35, 0, width, height, OPEN_DOOR_WINDOWS);
    put_wall(&h, h.inside, 0, 0.5 * (front + house_end), 0, width, 3.2, OPEN_ROOMS);
    furnish(&h, 0.5, front + 0.3, 0.4 * width, 0.4 * (house_end - front));
    furnish(&h, 0.55 * width, front + 0.3, 0.4 * width, 0.4 * (house_end - front));
    furnish(&h, 0.5, 0.5 * (front + house_end) + 0.6, 0.8 * width, 0.3 * (house_end - front));
    plan_side_walls(&h, house_end, depth, 2.6);
    put_wall(&h, h.outside, 0, depth - 0.35, 0, width, 2.6, OPEN_DOOR);
    plan_yard(&h, house_end + 0.3, depth - 0.5);
}

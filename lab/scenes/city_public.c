// SPDX-License-Identifier: MIT
//
// Temples, the forum with its colonnades and basilica, the amphitheatre.
#include "lab/scenes/city.h"
#include "lab/scenes/trigonometry.h"

// A row of columns from (x0, z0) to (x1, z1), both ends included, and the architrave on top.
static void put_colonnade(city_plan* plan, int order, double y, double x0, double z0, double x1,
                          double z1, int count)
{
    static const double heights[3] = {3.1, 6.0, 9.0};
    double dx = x1 - x0, dz = z1 - z0, length = sqrt(dx * dx + dz * dz);
    for (int i = 0; i < count; ++i) {
        double t = count > 1 ? (double)i / (count - 1) : 0.5;
        city_show(plan, "column", plan->columns[order], place_at(x0 + dx * t, y, z0 + dz * t));
    }
    // one block of the architrave for every four columns
    int blocks = (count + 2) / 4;
    for (int i = 0; i < blocks; ++i) {
        double t = (double)i / blocks, c = dx / length, s = -dz / length;
        stp_affine place = {
            {{c, 0, s, x0 + dx * t}, {0, 1, 0, y + heights[order]}, {-s, 0, c, z0 + dz * t}}};
        city_put(plan, "architrave", CITY_ARCHITRAVE, PAINT_MARBLE, length / blocks,
                 0.16 * heights[order], 0, 0, place);
    }
}

void city_plan_temple(city_plan* plan, double width, double depth, int order)
{
    static const double heights[3] = {3.1, 6.0, 9.0};
    double floor = 0.25 * heights[order] + 0.2, top = floor + 1.16 * heights[order];
    double half = 0.5 * width, end = 0.5 * depth, in = 0.14 * heights[order];
    city_put(plan, "podium", CITY_PODIUM, PAINT_TUFA, width, depth, floor - 0.2, 0,
             place_at(-half, 0, -end));
    int across = (int)(width / (0.42 * heights[order])) + 1,
        along = (int)(depth / (0.42 * heights[order]));
    put_colonnade(plan, order, floor, -half + in, -end + in, half - in, -end + in, across);
    put_colonnade(plan, order, floor, -half + in, end - in, half - in, end - in, across);
    put_colonnade(plan, order, floor, -half + in, -end + 2.8 * in, -half + in, end - 2.8 * in,
                  along);
    put_colonnade(plan, order, floor, half - in, -end + 2.8 * in, half - in, end - 2.8 * in, along);
    double room = 0.55 * width, back = end - 3.2 * in, front = -0.3 * end,
           tall = 1.05 * heights[order];
    city_put(plan, "cella", CITY_WALL, PAINT_MARBLE_GREY, room, tall, 0.6, OPEN_DOOR,
             place_at(-0.5 * room, floor, front));
    city_put(plan, "cella", CITY_WALL, PAINT_MARBLE_GREY, room, tall, 0.6, OPEN_NONE,
             place_at(-0.5 * room, floor, back));
    for (int side = 0; side < 2; ++side) {
        double x = side == 0 ? -0.5 * room + 0.6 : 0.5 * room;
        city_put(plan, "cella", CITY_WALL, PAINT_MARBLE_GREY, back - front, tall, 0.6, OPEN_NONE,
                 place_turned(x, floor, front, -0.25, 1.0));
    }
    city_show(plan, "statue", plan->statue,
              place_turned(0, floor, back - 2.0, 0.0, 1.0 + 0.25 * order));
    double rise = 0.28 * width;
    city_put(plan, "gable", CITY_GABLE, PAINT_MARBLE, width, rise, 0.6, 0,
             place_at(-half, top, -end));
    city_put(plan, "gable", CITY_GABLE, PAINT_MARBLE, width, rise, 0.6, 0,
             place_at(-half, top, end - 0.6));
    city_put(plan, "roof", CITY_ROOF, PAINT_TILE, depth, half + 0.4, rise * (half + 0.4) / half,
             0.3, place_turned(-half - 0.4, top - 0.1, end, 0.25, 1.0));
    city_put(plan, "roof", CITY_ROOF, PAINT_TILE, depth, half + 0.4, rise * (half + 0.4) / half,
             0.3, place_turned(half + 0.4, top - 0.1, -end, -0.25, 1.0));
}

static void plan_basilica(city_plan* plan)
{
    double w = 24.0, d = 56.0, h = 8.5;
    city_put(plan, "basilica", CITY_ARCADE, PAINT_BRICK, d, h, 0.9, 0,
             place_turned(-0.5 * w + 0.9, 0, -0.5 * d, -0.25, 1.0));
    city_put(plan, "basilica", CITY_ARCADE, PAINT_BRICK, d, h, 0.9, 0,
             place_turned(0.5 * w, 0, -0.5 * d, -0.25, 1.0));
    city_put(plan, "basilica", CITY_ARCADE, PAINT_BRICK, w, h, 0.9, 0,
             place_at(-0.5 * w, 0, -0.5 * d));
    city_put(plan, "basilica", CITY_ARCADE, PAINT_BRICK, w, h, 0.9, 0,
             place_at(-0.5 * w, 0, 0.5 * d - 0.9));
    put_colonnade(plan, 2, 0, -6.0, -0.42 * d, -6.0, 0.42 * d, 12);
    put_colonnade(plan, 2, 0, 6.0, -0.42 * d, 6.0, 0.42 * d, 12);
    city_put(plan, "roof", CITY_ROOF, PAINT_TILE_DARK, d, 0.5 * w + 0.5, 3.2, 0.3,
             place_turned(-0.5 * w - 0.5, h + 0.4, 0.5 * d, 0.25, 1.0));
    city_put(plan, "roof", CITY_ROOF, PAINT_TILE_DARK, d, 0.5 * w + 0.5, 3.2, 0.3,
             place_turned(0.5 * w + 0.5, h + 0.4, -0.5 * d, -0.25, 1.0));
    city_put(plan, "gable", CITY_GABLE, PAINT_BRICK, w, 3.0, 0.8, 0,
             place_at(-0.5 * w, h + 0.4, -0.5 * d));
    city_put(plan, "gable", CITY_GABLE, PAINT_BRICK, w, 3.0, 0.8, 0,
             place_at(-0.5 * w, h + 0.4, 0.5 * d - 0.8));
}

void city_plan_forum(city_plan* plan)
{
    uint32_t here = plan->group;
    for (int i = 0; i < 5 * 12; ++i) { // slabs
        city_put(plan, "forum paving", CITY_FLOOR, PAINT_MARBLE_GREY, 8.0, 8.0, 0.8, 0,
                 place_at(-20.0 + 8.0 * (i % 5), 0, -38.0 + 8.0 * (i / 5)));
    }
    for (int side = 0; side < 2; ++side) {
        double x = side == 0 ? -24.0 : 24.0, outer = side == 0 ? -31.0 : 31.0;
        put_colonnade(plan, 1, 0.4, x, -50.0, x, 58.0, 36);
        city_put(plan, "portico wall", CITY_WALL, PAINT_CREAM, 108.0, 7.5, 0.5, OPEN_ROOMS,
                 place_turned(outer, 0, -50.0, -0.25, 1.0));
        for (int i = 0; i < 9; ++i) {
            double z = -50.0 + 12.0 * i;
            city_put(plan, "portico floor", CITY_FLOOR, PAINT_TERRAZZO, 7.0, 12.0, 0.7, 0,
                     place_at(side == 0 ? outer : x, 0.35, z));
            city_put(plan, "roof", CITY_ROOF, PAINT_TILE, 12.0, 7.6, 1.6, 0.3,
                     side == 0 ? place_turned(x + 0.5, 7.2, z, -0.25, 1.0)
                               : place_turned(x - 0.5, 7.2, z + 12.0, 0.25, 1.0));
        }
        for (int i = 0; i < 7; ++i) {
            city_show(plan, "statue", plan->statue,
                      place_turned(0.82 * x, 0, -26.0 + 12.0 * i, side == 0 ? 0.25 : -0.25, 1.1));
        }
    }
    city_enter(plan, "temple of Jupiter", false, place_at(0, 0, 40.0));
    city_plan_temple(plan, 17.0, 34.0, 2);
    plan->group = here;
    city_enter(plan, "basilica", false, place_at(-48.0, 0, -20.0));
    plan_basilica(plan);
    plan->group = here;
    city_enter(plan, "temple of Apollo", false, place_turned(-50.0, 0, 38.0, 0.0, 1.0));
    city_plan_temple(plan, 14.0, 24.0, 1);
    plan->group = here;
    city_enter(plan, "market", false, place_at(50.0, 0, 0));
    put_colonnade(plan, 1, 0, -14.0, -20.0, 14.0, -20.0, 9);
    put_colonnade(plan, 1, 0, -14.0, 20.0, 14.0, 20.0, 9);
    for (int i = 0; i < 40; ++i) {
        city_put(plan, "market stall", CITY_STALL, PAINT_WOOD_PALE, 2.6, 2.0, 0, 0,
                 place_at(-14.0 + 3.6 * (i % 8), 0, -14.0 + 6.0 * (i / 8)));
        city_put(plan, "market awning", CITY_AWNING,
                 i % 2 == 0 ? PAINT_CLOTH_RED : PAINT_CLOTH_YELLOW, 2.8, 2.4, 0, 0,
                 place_at(-14.1 + 3.6 * (i % 8), 0, -11.8 + 6.0 * (i / 8)));
        city_jar_spot(plan, -14.3 + 3.6 * (i % 8), 0, -12.4 + 6.0 * (i / 8));
    }
    plan->group = here;
}

void city_plan_amphitheatre(city_plan* plan)
{
    enum { WEDGES = 40 };
    double inner = 22.0, outer = 56.0, height = 15.0;
    for (int i = 0; i < WEDGES; ++i) {
        double turns = (double)i / WEDGES, next = (double)(i + 1) / WEDGES;
        stp_affine place = place_turned(0, 0, 0, -turns, 1.0);
        city_put(plan, "seats", CITY_SEATS, PAINT_TUFA, inner, outer, 0.995 / WEDGES, height,
                 place);
        double x0 = outer * turn_cosine(turns), z0 = outer * turn_sine(turns);
        double x1 = outer * turn_cosine(next), z1 = outer * turn_sine(next);
        double length = sqrt((x1 - x0) * (x1 - x0) + (z1 - z0) * (z1 - z0));
        double c = (x1 - x0) / length, s = -(z1 - z0) / length;
        for (int storey = 0; storey < 2; ++storey) {
            stp_affine wall = {{{c, 0, s, x0}, {0, 1, 0, 7.6 * storey}, {-s, 0, c, z0}}};
            city_put(plan, "arcade", CITY_ARCADE, storey == 0 ? PAINT_TUFA : PAINT_BRICK, length,
                     7.2, 1.2, 0, wall);
        }
    }
    city_put(plan, "arena", CITY_FLOOR, PAINT_SOIL, 32.0, 32.0, 3.0, 0, place_at(-16.0, 0, -16.0));
}

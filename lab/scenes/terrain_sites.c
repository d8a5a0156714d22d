// SPDX-License-Identifier: MIT
//
// The map: sites, and roads that connect them. Figure 5 of Brandt et al. 2019 shows the parts
// spread over the whole terrain, with forests between them.
#include "lab/scenes/terrain.h"

#include <assert.h>

const terrain_site terrain_sites[SITE_COUNT] = {
    [SITE_CITY] = {-1850.0, 250.0, 430.0, 330.0},
    [SITE_CAR_FACTORY] = {-300.0, 900.0, 180.0, 130.0},
    [SITE_BAKERY] = {400.0, -650.0, 90.0, 60.0},
    [SITE_POWER_PLANTS] = {1650.0, 350.0, 480.0, 480.0},
};

double terrain_site_distance(double x, double z)
{
    double nearest = 1e9;
    for (int i = 0; i < SITE_COUNT; ++i) {
        const terrain_site* s = &terrain_sites[i];
        double dx = (x < s->x ? s->x - x : x - s->x) - s->half_width;
        double dz = (z < s->z ? s->z - z : z - s->z) - s->half_depth;
        dx = dx > 0.0 ? dx : 0.0;
        dz = dz > 0.0 ? dz : 0.0;
        double distance = sqrt(dx * dx + dz * dz);
        nearest = distance < nearest ? distance : nearest;
    }
    return nearest;
}

enum { MOST_POINTS = 10 };

typedef struct road {
    int count;
    double points[MOST_POINTS][2];
} road;

// Control points of Catmull-Rom curves, which also pass through the first and last.
static const road roads[ROAD_COUNT] = {
    // from the city to the crossing in the middle
    {7,
     {{-1400, 250}, {-1250, 260}, {-1050, 180}, {-850, 60}, {-620, 40}, {-380, 90}, {-150, 100}}},
    // the crossing to the power plants
    {6, {{-150, 100}, {150, 130}, {450, 260}, {700, 330}, {950, 340}, {1150, 350}}},
    // the crossing to the car factory
    {5, {{-150, 100}, {-190, 300}, {-330, 480}, {-320, 640}, {-300, 760}}},
    // the crossing to the bakery, and on to the north edge
    {7,
     {{-150, 100}, {-80, -150}, {90, -380}, {270, -540}, {260, -850}, {-40, -1200}, {-60, -1640}}},
    // the west edge, around the city, to the south edge
    {7,
     {{-2540, -450},
      {-2200, -330},
      {-1800, -260},
      {-1330, -180},
      {-1150, 300},
      {-1200, 900},
      {-1300, 1640}}},
    // the power plants to the north edge
    {6, {{1650, -140}, {1640, -350}, {1500, -650}, {1550, -1000}, {1850, -1250}, {1900, -1640}}},
};

stp_vec3d terrain_road_point(int index, double t, stp_vec3d* direction)
{
    assert(index >= 0 && index < ROAD_COUNT);
    const road* r = &roads[index];
    double at = (t < 0.0 ? 0.0 : t > 1.0 ? 1.0 : t) * (double)(r->count - 1);
    int span = (int)at;
    span = span > r->count - 2 ? r->count - 2 : span;
    double u = at - (double)span, p[4][2], out[2][2];
    for (int i = 0; i < 4; ++i) {
        int k = span + i - 1;
        k = k < 0 ? 0 : k >= r->count ? r->count - 1 : k;
        p[i][0] = r->points[k][0];
        p[i][1] = r->points[k][1];
    }
    for (int axis = 0; axis < 2; ++axis) {
        double a = p[0][axis], b = p[1][axis], c = p[2][axis], d = p[3][axis];
        double k1 = 0.5 * (c - a), k2 = a - 2.5 * b + 2.0 * c - 0.5 * d;
        double k3 = 0.5 * (d - a) + 1.5 * (b - c);
        out[0][axis] = b + u * (k1 + u * (k2 + u * k3));
        out[1][axis] = k1 + u * (2.0 * k2 + 3.0 * u * k3);
    }
    if (direction != NULL) {
        *direction = stp_normalized((stp_vec3d){out[1][0], 0.0, out[1][1]});
    }
    return (stp_vec3d){out[0][0], 0.0, out[0][1]};
}

double terrain_road_length(int index)
{
    double length = 0.0;
    stp_vec3d last = terrain_road_point(index, 0.0, NULL);
    for (int i = 1; i <= 64; ++i) {
        stp_vec3d next = terrain_road_point(index, (double)i / 64.0, NULL);
        stp_vec3d step = stp_subd(next, last);
        length += sqrt(stp_dotd(step, step));
        last = next;
    }
    return length;
}

void terrain_map_make(terrain_map* map, uint64_t seed)
{
    map->seed = seed;
    for (int i = 0; i < ROAD_COUNT; ++i) {
        for (int k = 0; k <= ROAD_PIECES; ++k) {
            stp_vec3d p = terrain_road_point(i, (double)k / ROAD_PIECES, NULL);
            map->points[i][k][0] = p.x;
            map->points[i][k][1] = p.z;
        }
        for (int run = 0; run < ROAD_PIECES / ROAD_RUN; ++run) {
            double* box = map->boxes[i][run];
            box[0] = box[1] = 1e9;
            box[2] = box[3] = -1e9;
            for (int k = run * ROAD_RUN; k <= (run + 1) * ROAD_RUN; ++k) {
                for (int axis = 0; axis < 2; ++axis) {
                    double value = map->points[i][k][axis];
                    box[axis] = value < box[axis] ? value : box[axis];
                    box[2 + axis] = value > box[2 + axis] ? value : box[2 + axis];
                }
            }
        }
    }
}

static double piece_distance_square(const double a[2], const double b[2], double x, double z)
{
    double along[2] = {b[0] - a[0], b[1] - a[1]}, to[2] = {x - a[0], z - a[1]};
    double t = (to[0] * along[0] + to[1] * along[1]) / (along[0] * along[0] + along[1] * along[1]);
    t = t < 0.0 ? 0.0 : t > 1.0 ? 1.0 : t;
    double dx = to[0] - t * along[0], dz = to[1] - t * along[1];
    return dx * dx + dz * dz;
}

double terrain_road_distance(const terrain_map* map, double x, double z)
{
    const double reach = 100.0;
    double nearest = reach * reach;
    for (int i = 0; i < ROAD_COUNT; ++i) {
        for (int run = 0; run < ROAD_PIECES / ROAD_RUN; ++run) {
            const double* box = map->boxes[i][run];
            if (x < box[0] - reach || x > box[2] + reach || z < box[1] - reach ||
                z > box[3] + reach) {
                continue;
            }
            for (int k = run * ROAD_RUN; k < (run + 1) * ROAD_RUN; ++k) {
                double square =
                    piece_distance_square(map->points[i][k], map->points[i][k + 1], x, z);
                nearest = square < nearest ? square : nearest;
            }
        }
    }
    return sqrt(nearest);
}

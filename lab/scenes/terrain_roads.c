// SPDX-License-Identifier: MIT
//
// Roads as segments with separate meshes: an embankment with shoulders, two lanes with
// markings, and marker posts or a guard rail. The paper's segments have 100 to 5,000 triangles
// (Brandt et al. 2019, 5.1).
#include "lab/scenes/compose.h"
#include "lab/scenes/mesh_builder.h"
#include "lab/scenes/scene_random.h"
#include "lab/scenes/solids.h"
#include "lab/scenes/terrain.h"

#include <stdio.h>

enum { STATIONS = 12 }; ///< points across

typedef struct segment {
    const terrain_map* map;
    int road;
    double begin, end; ///< along the road, 0..1
    uint32_t rows;     ///< rows along the segment
    uint32_t posts;    ///< posts of the guard rail on each side; 0: none
} segment;

// Cross section: distance from the centre, height above the ground, and grey of the next strip.
// Markings are separate strips, so no texture is needed.
static const double stations[STATIONS][3] = {
    {-7.5, -1.2, 0.10},   {-5.2, 0.20, 0.16},  {-3.9, 0.26, 0.045}, {-3.6, 0.27, 0.62},
    {-3.45, 0.27, 0.045}, {-0.08, 0.33, 0.62}, {0.08, 0.33, 0.045}, {3.45, 0.27, 0.62},
    {3.6, 0.27, 0.045},   {3.9, 0.26, 0.16},   {5.2, 0.20, 0.10},   {7.5, -1.2, 0.0}};
enum { ROW_TRIANGLES = 2 * (STATIONS - 1), POST_TRIANGLES = 2 * (12 + 8) };

static uint64_t segment_triangles(const segment* s)
{
    return (uint64_t)s->rows * ROW_TRIANGLES + (uint64_t)s->posts * POST_TRIANGLES;
}

// The road is level across: its height is the ground's at its centre.
static double road_height(const segment* s, stp_vec3d point)
{
    return terrain_height(s->map, point.x, point.z) + 0.25;
}

static void put_strip(mesh_builder* builder, const segment* s, stp_vec3d origin, int station)
{
    uint32_t first = (uint32_t)builder->vertex_count;
    double grey = stations[station][2];
    mesh_builder_color(builder, grey, grey * 0.98, grey * (grey > 0.09 && grey < 0.2 ? 0.7 : 0.96));
    for (uint32_t row = 0; row <= s->rows; ++row) {
        stp_vec3d direction;
        double t = s->begin + (s->end - s->begin) * (double)row / (double)s->rows;
        stp_vec3d middle = terrain_road_point(s->road, t, &direction);
        double height = road_height(s, middle);
        for (int side = 0; side < 2; ++side) {
            const double* station_at = stations[station + side];
            double off = station_at[0], slope = stations[station + 1][1] - stations[station][1];
            double width = stations[station + 1][0] - stations[station][0];
            stp_vec3 normal = point3(-slope * -direction.z, width, -slope * direction.x);
            mesh_builder_vertex(builder,
                                point3(middle.x - direction.z * off - origin.x,
                                       height + station_at[1] - origin.y,
                                       middle.z + direction.x * off - origin.z),
                                normal);
        }
    }
    for (uint32_t row = 0; row < s->rows; ++row) {
        uint32_t a = first + 2 * row, b = a + 1, c = a + 2, d = a + 3;
        mesh_builder_triangle(builder, a, c, d);
        mesh_builder_triangle(builder, a, d, b);
    }
}

// A post and the rail from it to the next.
static void put_post(mesh_builder* builder, const segment* s, stp_vec3d origin, uint32_t number,
                     double side)
{
    double step = (s->end - s->begin) / (double)s->posts, off = 4.7 * side;
    stp_vec3d at[2];
    for (int i = 0; i < 2; ++i) {
        stp_vec3d direction;
        stp_vec3d p = terrain_road_point(s->road, s->begin + step * (double)(number + (uint32_t)i),
                                         &direction);
        at[i] = (stp_vec3d){p.x - direction.z * off - origin.x, road_height(s, p) - origin.y,
                            p.z + direction.x * off - origin.z};
    }
    mesh_builder_color(builder, 0.45, 0.45, 0.47);
    solid_box(builder, point3(at[0].x - 0.06, at[0].y - 0.6, at[0].z - 0.06),
              point3(at[0].x + 0.06, at[0].y + 0.8, at[0].z + 0.06));
    mesh_builder_color(builder, 0.55, 0.56, 0.58);
    for (int face = 0; face < 2; ++face) { // visible from both sides: a bent sheet of two strips
        for (int strip = 0; strip < 2; ++strip) {
            double low = 0.45 + 0.17 * strip, high = low + 0.17;
            stp_vec3 a = point3(at[0].x, at[0].y + low, at[0].z);
            stp_vec3 b = point3(at[1].x, at[1].y + low, at[1].z);
            stp_vec3 c = point3(at[1].x, at[1].y + high, at[1].z);
            stp_vec3 d = point3(at[0].x, at[0].y + high, at[0].z);
            if (face == 0) {
                solid_quad(builder, a, b, c, d);
            } else {
                solid_quad(builder, b, a, d, c);
            }
        }
    }
}

static stp_vec3d segment_origin(const segment* s)
{
    stp_vec3d origin = terrain_road_point(s->road, s->begin, NULL);
    origin.y = terrain_height(s->map, origin.x, origin.z);
    return origin;
}

static void make_segment(mesh_builder* builder, const void* parameters)
{
    const segment* s = parameters;
    stp_vec3d origin = segment_origin(s);
    for (int station = 0; station + 1 < STATIONS; ++station) {
        put_strip(builder, s, origin, station);
    }
    for (uint32_t i = 0; i < s->posts; ++i) {
        put_post(builder, s, origin, i, -1.0);
        put_post(builder, s, origin, i, 1.0);
    }
}

// Distributes the segments over the roads by length, and the triangles: most segments have 5 to 12
// rows, some 60 to 149, and some guard rails. They are reduced to fit; the rest goes to rows one by
// one.
static void plan_segments(const terrain_map* map, uint64_t triangles,
                          segment segments[ROAD_SEGMENTS])
{
    double lengths[ROAD_COUNT], whole = 0.0, before = 0.0;
    for (int i = 0; i < ROAD_COUNT; ++i) {
        lengths[i] = terrain_road_length(i);
        whole += lengths[i];
    }
    random_stream random = random_begin(map->seed + 5);
    int made = 0;
    uint64_t planned = 0;
    for (int i = 0; i < ROAD_COUNT; ++i) {
        before += lengths[i];
        int until =
            i + 1 == ROAD_COUNT ? ROAD_SEGMENTS : (int)(ROAD_SEGMENTS * before / whole + 0.5);
        int count = until - made;
        for (int k = 0; made < until; ++made, ++k) {
            bool railed = made % 37 == 5, fine = made % 29 == 3;
            uint32_t more_rows = random_below(&random, fine ? 90 : 8);
            uint32_t more_posts = railed ? random_below(&random, 90) : 0;
            segments[made] = (segment){.map = map,
                                       .road = i,
                                       .begin = (double)k / count,
                                       .end = (double)(k + 1) / count,
                                       .rows = fine ? 60 + more_rows : 5 + more_rows,
                                       .posts = railed ? 24 + more_posts : 0};
            planned += segment_triangles(&segments[made]);
        }
    }
    double fit = planned > 0 ? (double)triangles / (double)planned : 1.0;
    for (planned = 0, made = 0; made < ROAD_SEGMENTS; ++made) {
        segment* s = &segments[made];
        s->rows = (uint32_t)((double)s->rows * (fit < 1.0 ? fit : 1.0) + 0.5);
        s->rows = s->rows < (fit < 0.5 ? 1u : 5u) ? (fit < 0.5 ? 1u : 5u) : s->rows;
        s->posts = fit < 0.5 ? 0 : s->posts;
        planned += segment_triangles(s);
    }
    for (int i = 0; planned + ROW_TRIANGLES <= triangles; i = (i + 1) % ROAD_SEGMENTS) {
        segments[i].rows += 1;
        planned += ROW_TRIANGLES;
    }
}

uint64_t terrain_count_roads(const terrain_map* map, uint64_t triangles,
                             uint64_t counts[ROAD_SEGMENTS])
{
    segment segments[ROAD_SEGMENTS];
    uint64_t sum = 0;
    plan_segments(map, triangles, segments);
    for (int i = 0; i < ROAD_SEGMENTS; ++i) {
        counts[i] = segment_triangles(&segments[i]);
        sum += counts[i];
    }
    return sum;
}

stp_result terrain_add_roads(stp_scene* scene, uint32_t parent, const terrain_map* map,
                             uint64_t triangles)
{
    segment segments[ROAD_SEGMENTS];
    mesh_recipe recipes[ROAD_SEGMENTS];
    uint32_t material, first, group;
    plan_segments(map, triangles, segments);
    stp_affine still = stp_affine_identity();
    stp_result result = add_plain_material(scene, "road", 0xffffff, 0.85, &material);
    for (int i = 0; i < ROAD_SEGMENTS; ++i) {
        recipes[i] = (mesh_recipe){"road segment", make_segment, &segments[i], material};
    }
    result = result == STP_OK ? make_meshes(scene, recipes, ROAD_SEGMENTS, &first) : result;
    result = result == STP_OK ? add_group(scene, "roads", parent, &still, &group) : result;
    for (uint32_t i = 0; result == STP_OK && i < ROAD_SEGMENTS; ++i) {
        char name[32];
        stp_vec3d origin = segment_origin(&segments[i]);
        stp_affine place = place_at(origin.x, origin.y, origin.z);
        snprintf(name, sizeof(name), "road %d, segment %u", segments[i].road + 1, i + 1);
        result = add_mesh_object(scene, name, group, &place, first + i);
    }
    return result;
}

// SPDX-License-Identifier: MIT
// Simulated scans: points lie in the scanner's directions, on the surface, off by the noise;
// files without memory.
#include "tests.h"

#include "lab/measure/shapes.h"
#include "lab/scan/scan_file.h"
#include "lab/scan/scan_sweep.h"
#include "lab/scenes/scenes.h"

#include <math.h>
#include <string.h>
#include <unistd.h>

enum { COLUMNS = 180, ROWS = 75, STATIONS = 3 };

static const scan_settings settings = {
    .columns = COLUMNS, .rows = ROWS, .noise = 0.01, .range = 50.0, .half = 40.0, .seed = 5};

static stp_scene* make_boxes(stp_context* context)
{
    stp_scene* scene = NULL;
    stp_result result = stp_scene_create(context, &scene);
    const scene_options plain = {.scale = 1.0};
    result = result == STP_OK ? scene_make(scene, "boxes", &plain) : result;
    result = result == STP_OK ? stp_scene_finish(scene) : result;
    if (result != STP_OK) {
        stp_scene_destroy(scene);
        return NULL;
    }
    return scene;
}

/// Distance from a position to the triangles of one object, or of all (UINT32_MAX).
static double distance_to(const scan_target* t, uint32_t object, stp_vec3d place)
{
    double minimum = (double)INFINITY;
    for (uint32_t part = 0; part < t->part_count; ++part) {
        if (object != UINT32_MAX && object != part) {
            continue;
        }
        for (uint32_t i = 0; i < t->meshes[t->parts[part].mesh].triangle_count; ++i) {
            stp_vec3d corners[3];
            stp_caster_corners(t->caster, part, i, corners);
            minimum = fmin(minimum, stp_triangle_distance_squared(corners, place));
        }
    }
    return sqrt(minimum);
}

static stp_vec3d place_of(const scan_point* p)
{
    return (stp_vec3d){p->place[0], p->place[1], p->place[2]};
}

void test_scan_points_lie_on_the_surface(test_state* test)
{
    static scan_point points[COLUMNS * ROWS];
    stp_context* context = test_context(NULL, 2, NULL);
    stp_scene* scene = make_boxes(context);
    CHECK(scene != NULL);
    scan_target target;
    CHECK(scan_target_of_scene(scene, "boxes", &target) == STP_OK);
    stp_vec3d origin = {0.7, 0.7, 0.7}; // between boxes
    const scan_station station = {.number = 3, .columns = COLUMNS, .rows = ROWS, .place = origin};
    scan_sweep(&target, &settings, &station, 0, COLUMNS, points);
    double sum = 0.0, squares = 0.0;
    uint32_t hits = 0, objects = 0;
    uint64_t seen = 0;
    for (uint32_t i = 0; i < COLUMNS * ROWS; ++i) {
        const scan_point* p = &points[i];
        CHECK(p->time == 2.0 * COLUMNS * ROWS + i && p->column == i / ROWS && p->row == i % ROWS);
        scan_ray ray = scan_ray_of(&settings, &station, p->column, p->row);
        stp_vec3d direction = ray.direction;
        double elevation = asin(direction.z) * 57.295779513082323;
        CHECK(fabs(elevation - (double)p->angle) < 1e-4);
        CHECK(fabs(elevation + 60.0 - 150.0 * (p->row + 0.5) / ROWS) < 1e-9);
        if (!p->hit) {
            continue;
        }
        double error = (double)p->range_error;
        CHECK(fabs(error) < 5.0 * settings.noise);
        CHECK(distance_to(&target, UINT32_MAX, place_of(p)) < 5.0 * settings.noise);
        stp_vec3d true_place = stp_subd(place_of(p), stp_scaled(direction, error));
        CHECK(distance_to(&target, p->object, true_place) < 1e-6);
        stp_vec3d out = stp_subd(true_place, origin);
        double range = sqrt(stp_dotd(out, out));
        CHECK(fabs(stp_dotd(out, direction) - range) < 1e-6);
        stp_vec3d normal = {(double)p->normal[0], (double)p->normal[1], (double)p->normal[2]};
        CHECK(fabs(stp_dotd(normal, normal) - 1.0) < 1e-6 && stp_dotd(normal, direction) <= 0.0);
        sum += error;
        squares += error * error;
        objects += (seen >> p->object & 1) == 0 ? 1 : 0;
        seen |= UINT64_C(1) << p->object;
        hits += 1;
    }
    CHECK(hits > COLUMNS * ROWS / 4 && hits < COLUMNS * ROWS && objects > 5);
    CHECK(fabs(sum / hits) < 4.0 * settings.noise / sqrt(hits));
    CHECK(fabs(sqrt(squares / hits) / settings.noise - 1.0) < 0.05);
    scan_target_destroy(&target);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// The intensity is lower at larger distance or slant, or for darker colours.
void test_scan_intensity_falls(test_state* test)
{
    static const float square[12] = {-9, 0, -9, 9, 0, -9, 9, 0, 9, -9, 0, 9};
    static const uint32_t corners[6] = {0, 2, 1, 0, 3, 2};
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    CHECK(stp_scene_create(context, &scene) == STP_OK);
    stp_mesh mesh = {.vertex_count = 4, .triangle_count = 2};
    mesh.positions = stp_alloc(context, sizeof(square));
    mesh.indices = stp_alloc(context, sizeof(corners));
    memcpy(mesh.positions, square, sizeof(square));
    memcpy(mesh.indices, corners, sizeof(corners));
    const stp_object object = {.parent = STP_NONE, .transform = stp_affine_identity()};
    CHECK(stp_scene_add_mesh(scene, &mesh, NULL) == STP_OK);
    CHECK(stp_scene_add_object(scene, &object, NULL) == STP_OK);
    CHECK(stp_scene_add_part(scene, (stp_part){STP_PART_MESH, 0}) == STP_OK);
    CHECK(stp_scene_finish(scene) == STP_OK);
    scan_target target;
    CHECK(scan_target_of_scene(scene, "square", &target) == STP_OK);
    scan_point near[ROWS], far[ROWS];
    const scan_station low = {.number = 1, .place = {0, 0, 1}},
                       high = {.number = 1, .place = {0, 0, 2}};
    scan_sweep(&target, &settings, &low, 0, 1, near);
    scan_sweep(&target, &settings, &high, 0, 1, far);
    uint32_t compared = 0;
    for (uint32_t row = 0; row + 1 < ROWS; ++row) {
        if (near[row + 1].hit) { // lower rays meet the ground more squarely, and nearer
            CHECK(near[row].intensity > near[row + 1].intensity);
            compared += 1;
        }
        CHECK(!far[row].hit || far[row].intensity < near[row].intensity);
        CHECK(near[row].hit == ((double)near[row].angle < -atan(1.0 / 9.0) * 57.2957795));
    }
    CHECK(compared > 10);
    scan_target_destroy(&target);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

/// Writes a whole small scan into a file. @return the first failure
static stp_result write_all(stp_context* context, const stp_scene* scene, const char* path)
{
    static scan_point points[COLUMNS * ROWS];
    scan_target target;
    stp_vec3d places[STATIONS];
    const scan_placing placing = {.count = STATIONS, .range = 50.0};
    stp_result result = scan_target_of_scene(scene, "boxes", &target);
    if (result != STP_OK) {
        return result;
    }
    result = scan_place_stations(&target, &placing, places);
    const scan_file_desc desc = {
        .path = path, .bounds = stp_caster_bounds(target.caster), .stations = STATIONS};
    scan_file file;
    result = result == STP_OK ? scan_file_open(context, &desc, &file) : result;
    bool open = result == STP_OK;
    for (uint32_t i = 0; i < STATIONS && result == STP_OK; ++i) {
        const scan_station station = {
            .number = i + 1, .columns = COLUMNS, .rows = ROWS, .place = places[i]};
        result = scan_file_begin_station(&file, &station);
        scan_sweep(&target, &settings, &station, 0, COLUMNS, points);
        result = result == STP_OK ? scan_file_add(&file, &station, points, COLUMNS * ROWS) : result;
        result = result == STP_OK ? scan_file_end_station(&file, &station) : result;
    }
    if (open && result == STP_OK) {
        result = scan_file_close(&file);
    } else if (open) {
        scan_file_abort(&file);
    }
    scan_target_destroy(&target);
    return result;
}

void test_scan_files_without_memory(test_state* test)
{
    static const char* const endings[] = {".las", ".ptx", ".ply", ".e57"};
    for (size_t e = 0; e < 4; ++e) {
        char path[64];
        snprintf(path, sizeof(path), "stipple-test-scan-%d%s", (int)getpid(), endings[e]);
        bool made = false;
        for (int fail = 0; fail < 400 && !made; fail += fail < 40 ? 1 : 3) {
            test_heap heap = TEST_HEAP(-1);
            test_log log = {0};
            stp_context* context = test_context(&heap, 1, &log);
            stp_scene* scene = make_boxes(context);
            CHECK(scene != NULL);
            heap.fail_at = heap.count + fail;
            stp_result result = write_all(context, scene, path);
            made = result == STP_OK;
            CHECK(made || (result == STP_ERROR_OUT_OF_MEMORY && log.errors == 1));
            CHECK((access(path, F_OK) == 0) == made);
            heap.fail_at = -1;
            stp_scene_destroy(scene);
            stp_context_destroy(context);
            CHECK_EQUAL(0, heap.live_bytes);
        }
        CHECK(made);
        CHECK(unlink(path) == 0);
    }
}

void test_scan_refuses_what_las_cannot_hold(test_state* test)
{
    test_log log = {0};
    char path[64];
    snprintf(path, sizeof(path), "stipple-test-far-%d.las", (int)getpid());
    stp_context* context = test_context(NULL, 1, &log);
    const scan_file_desc desc = {.path = path, .bounds = {{0, 0, 0}, {1, 1, 1}}, .stations = 1};
    scan_file file;
    CHECK(scan_file_open(context, &desc, &file) == STP_OK);
    const scan_station station = {.number = 1, .columns = 4, .rows = 2};
    const scan_point far = {.hit = true, .place = {3e6, 0, 0}};
    CHECK(scan_file_add(&file, &station, &far, 1) == STP_ERROR_LIMIT);
    CHECK(strstr(log.text, "4,29") != NULL);
    scan_file_abort(&file);
    CHECK(access(desc.path, F_OK) != 0);
    stp_context_destroy(context);
}

// Airborne scans: parallel flight lines scan every place from above, at angles up to 30 degrees,
// and overlap.
void test_scan_flies_over_all(test_state* test)
{
    static scan_point points[64 * 64];
    stp_context* context = test_context(NULL, 2, NULL);
    stp_scene* scene = make_boxes(context);
    CHECK(scene != NULL);
    scan_target target;
    CHECK(scan_target_of_scene(scene, "boxes", &target) == STP_OK);
    scan_settings set = {.airborne = true, .range = 100.0};
    scan_station lines[3];
    double step = scan_settings_set_resolution(&set, 1.0);
    CHECK(step == 1.0 && set.rows == 60);
    CHECK(scan_plan_flight(&target, 0.0, 1e-6, 3, &set, lines) == STP_ERROR_LIMIT);
    CHECK(scan_plan_flight(&target, 3.0, 10.0 * step, 3, &set, lines) == STP_OK);
    CHECK(set.columns == 8); // 4 m in steps of 3 m times 10 degrees
    bool seen[27] = {false};
    for (int line = 0; line < 3; ++line) {
        CHECK(fabs(lines[line].place.z - 5.0) < 1e-9);
        CHECK((lines[line].along.x > 0.0) == (line % 2 == 0));
        CHECK(fabs(lines[line].place.y - (-2.0 + 4.0 * (line + 0.5) / 3.0)) < 1e-9);
        scan_sweep(&target, &set, &lines[line], 0, set.columns, points);
        for (uint32_t i = 0; i < set.columns * set.rows; ++i) {
            const scan_point* p = &points[i];
            scan_ray ray = scan_ray_of(&set, &lines[line], p->column, p->row);
            double right = stp_dotd(
                ray.direction, stp_normalized(stp_crossd(lines[line].along, (stp_vec3d){0, 0, 1})));
            CHECK(fabs(asin(right) * 57.295779513082323 - (double)p->angle) < 1e-4);
            CHECK(fabs((double)p->angle) < 30.0 && ray.direction.z < -0.86);
            if (p->hit) {
                CHECK(p->object < 27 && distance_to(&target, p->object, place_of(p)) < 1e-6);
                seen[p->object] = true;
            }
        }
    }
    int count = 0;
    for (int i = 0; i < 27; ++i) {
        count += seen[i] ? 1 : 0;
    }
    CHECK(count >= 9); // the upper ones
    scan_target_destroy(&target);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// A single box is scanned from around it, because its sides are not visible from its top.
void test_scan_stands_around_what_is_alone(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    stp_scene* scene = make_boxes(context);
    CHECK(scene != NULL);
    scan_target target;
    CHECK(scan_target_of_scene(scene, "boxes", &target) == STP_OK);
    stp_caster_destroy(context, target.caster);
    target.part_count = 1; // one of the boxes
    CHECK(stp_caster_create(context, target.meshes, target.mesh_count, target.parts, 1,
                            &target.caster) == STP_OK);
    stp_boxd box = stp_caster_bounds(target.caster);
    stp_vec3d places[4];
    const scan_placing placing = {.count = 4, .range = 50.0};
    CHECK(scan_place_stations(&target, &placing, places) == STP_OK);
    int sides[4] = {0};
    for (int i = 0; i < 4; ++i) {
        sides[0] += places[i].x < box.min.x ? 1 : 0;
        sides[1] += places[i].x > box.max.x ? 1 : 0;
        sides[2] += places[i].y < box.min.y ? 1 : 0;
        sides[3] += places[i].y > box.max.y ? 1 : 0;
    }
    CHECK(sides[0] > 0 && sides[1] > 0 && sides[2] > 0 && sides[3] > 0);
    scan_target_destroy(&target);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

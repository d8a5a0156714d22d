// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/math/math.h"
#include "capture/seen_sides.h"

#include <string.h>

enum { MANY = 40000, BALL_ROWS = 80, BALL_COLUMNS = 160, RESOLUTION = 256 };

/// Triangles in static memory.
typedef struct seen_mesh {
    float positions[3 * MANY];
    uint32_t indices[3 * MANY];
    uint8_t sides[MANY];
    uint32_t vertex_count, triangle_count;
} seen_mesh;

static seen_mesh mesh;

static void add_triangle(uint32_t a, uint32_t b, uint32_t c)
{
    const uint32_t corners[3] = {a, b, c};
    memcpy(mesh.indices + 3 * (size_t)mesh.triangle_count++, corners, sizeof(corners));
}

/// A cube with outward fronts, two triangles a face; face 5, the last, is at the top.
static void add_cube(float x, float y, float z, float half)
{
    static const uint32_t quads[6][4] = {{0, 2, 3, 1}, {0, 1, 5, 4}, {2, 6, 7, 3},
                                         {0, 4, 6, 2}, {1, 3, 7, 5}, {4, 5, 7, 6}};
    uint32_t first = mesh.vertex_count;
    for (uint32_t i = 0; i < 8; ++i) {
        float* p = mesh.positions + 3 * (size_t)mesh.vertex_count++;
        p[0] = x + ((i & 1) != 0 ? half : -half);
        p[1] = y + ((i & 2) != 0 ? half : -half);
        p[2] = z + ((i & 4) != 0 ? half : -half);
    }
    for (size_t f = 0; f < 6; ++f) {
        const uint32_t* q = quads[f];
        add_triangle(first + q[0], first + q[1], first + q[2]);
        add_triangle(first + q[0], first + q[2], first + q[3]);
    }
}

/// A closed ball with outward fronts.
static void add_ball(float x, float y, float z, float radius)
{
    uint32_t first = mesh.vertex_count;
    for (uint32_t i = 0; i <= BALL_ROWS; ++i) {
        for (uint32_t k = 0; k < BALL_COLUMNS; ++k) {
            double a = STP_PI * i / BALL_ROWS, b = 2.0 * STP_PI * k / BALL_COLUMNS;
            double ring = i % BALL_ROWS == 0 ? 0.0 : sin(a); // all vertices of a pole are one point
            float* p = mesh.positions + 3 * (size_t)mesh.vertex_count++;
            p[0] = x + radius * (float)(ring * cos(b));
            p[1] = y + radius * (float)(ring * sin(b));
            p[2] = z + radius * (float)cos(a);
        }
    }
    for (uint32_t i = 0; i < BALL_ROWS; ++i) {
        for (uint32_t k = 0; k < BALL_COLUMNS; ++k) {
            uint32_t up = first + i * BALL_COLUMNS, low = up + BALL_COLUMNS;
            uint32_t next = (k + 1) % BALL_COLUMNS;
            // the rows at the poles have one triangle each, as welded meshes do
            if (i > 0) {
                add_triangle(up + k, low + (i + 1 < BALL_ROWS ? k : 0), up + next);
            }
            if (i + 1 < BALL_ROWS) {
                add_triangle(up + (i > 0 ? next : 0), low + k, low + next);
            }
        }
    }
}

static void clear_mesh(void)
{
    mesh.vertex_count = mesh.triangle_count = 0;
}

static void invert(void)
{
    for (size_t i = 0; i < 3 * (size_t)mesh.triangle_count; i += 3) {
        uint32_t swapped = mesh.indices[i + 1];
        mesh.indices[i + 1] = mesh.indices[i + 2];
        mesh.indices[i + 2] = swapped;
    }
}

static const uint8_t* front_only; ///< of the next search; NULL: no triangle

static stp_result find_sides(stp_context* context, uint32_t resolution)
{
    stp_seen_desc desc = {.resolution = resolution, .front_only = front_only};
    memset(mesh.sides, 0xEE, sizeof(mesh.sides));
    return stp_find_seen_sides(context, mesh.positions, mesh.vertex_count, mesh.indices,
                               mesh.triangle_count, &desc, mesh.sides);
}

static void find_at(test_state* test, uint32_t resolution)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL && find_sides(context, resolution) == STP_OK);
    stp_context_destroy(context);
}

static void find(test_state* test)
{
    find_at(test, RESOLUTION);
}

/// Number of triangles from `begin` to before `end` that have exactly these sides.
static uint32_t count_sides(uint32_t begin, uint32_t end, uint8_t sides)
{
    uint32_t count = 0;
    for (uint32_t t = begin; t < end; ++t) {
        count += mesh.sides[t] == sides;
    }
    return count;
}

void test_seen_sides_of_a_closed_surface_are_outside(test_state* test)
{
    clear_mesh();
    add_cube(0, 0, 0, 1);
    find_at(test, 0); // the default
    CHECK_EQUAL(12, count_sides(0, 12, STP_SEEN_FRONT));
    invert();
    find(test);
    CHECK_EQUAL(12, count_sides(0, 12, STP_SEEN_BACK));
    clear_mesh();
    add_ball(0, 0, 0, 3);
    find(test);
    CHECK_EQUAL(mesh.triangle_count, count_sides(0, mesh.triangle_count, STP_SEEN_FRONT));
}

void test_seen_sides_leave_out_hidden_triangles(test_state* test)
{
    clear_mesh();
    add_cube(1000, -500, 250, 1); // far from the origin
    add_cube(1000, -500, 250, 0.5f);
    find(test);
    CHECK_EQUAL(12, count_sides(0, 12, STP_SEEN_FRONT));
    CHECK_EQUAL(12, count_sides(12, 24, 0));
}

void test_seen_sides_of_open_surfaces_are_both(test_state* test)
{
    clear_mesh();
    add_cube(0, 0, 0, 1);
    mesh.triangle_count -= 2; // open at the top
    find(test);
    CHECK_EQUAL(10, count_sides(0, 10, STP_SEEN_FRONT | STP_SEEN_BACK));
    mesh.triangle_count = 2; // a sheet without thickness
    find(test);
    CHECK_EQUAL(2, count_sides(0, 2, STP_SEEN_FRONT | STP_SEEN_BACK));
}

// What only shows through backs that are not drawn is seen, too.
void test_seen_sides_through_backs_that_are_not_drawn(test_state* test)
{
    static uint8_t of[MANY];
    clear_mesh();
    add_cube(0, 0, 0, 1); // its fronts face inwards
    invert();
    add_cube(0, 0, 0, 0.5f);
    find(test);
    CHECK_EQUAL(12, count_sides(0, 12, STP_SEEN_BACK));
    CHECK_EQUAL(12, count_sides(12, 24, 0));
    memset(of, 0, sizeof(of));
    memset(of, 1, 12);
    front_only = of;
    find(test);
    CHECK_EQUAL(12, count_sides(0, 12, STP_SEEN_FRONT | STP_SEEN_BACK));
    CHECK_EQUAL(12, count_sides(12, 24, STP_SEEN_FRONT));
    memset(of, 1, sizeof(of)); // the inner one, too: its fronts face the viewer
    find(test);
    CHECK_EQUAL(12, count_sides(0, 12, STP_SEEN_FRONT | STP_SEEN_BACK));
    CHECK_EQUAL(12, count_sides(12, 24, STP_SEEN_FRONT));
    clear_mesh();
    add_cube(0, 0, 0, 1);
    add_cube(0, 0, 0, 0.5f);
    find(test); // closed and faces outwards: hides what is inside
    CHECK_EQUAL(12, count_sides(0, 12, STP_SEEN_FRONT));
    CHECK_EQUAL(12, count_sides(12, 24, 0));
    front_only = NULL;
}

/// Allocations of a search with a context of its own.
static int count_allocations(void)
{
    test_heap heap = TEST_HEAP(-1);
    const stp_context_desc desc = {
        .allocator = {.alloc = test_heap_alloc, .free = test_heap_free, .user = &heap},
        .thread_count = 1};
    stp_context* context = NULL;
    bool done =
        stp_context_create(&context, &desc) == STP_OK && find_sides(context, RESOLUTION) == STP_OK;
    stp_context_destroy(context);
    return done ? heap.count : -1;
}

// Triangles are only listed in another order if some differ.
void test_seen_sides_of_triangles_of_one_kind_need_no_order(test_state* test)
{
    static uint8_t of[MANY];
    clear_mesh();
    add_cube(0, 0, 0, 1);
    int expected = count_allocations();
    CHECK(expected > 0);
    front_only = of;
    for (int some = 0; some <= 12; some += 6) {
        memset(of, 0, sizeof(of));
        memset(of, 1, (size_t)some);
        CHECK_EQUAL(some == 6 ? expected + 1 : expected, count_allocations());
        CHECK_EQUAL(12, count_sides(0, 12, STP_SEEN_FRONT));
    }
    front_only = NULL;
}

// A ball two pixels wide beside a cube: a pixel has more than a thousand triangles, and most win
// none.
void test_seen_sides_of_tiny_triangles_are_completed(test_state* test)
{
    clear_mesh();
    add_cube(0, 0, 0, 1);
    add_ball(1.5f, 1.5f, 1.5f, 0.02f);
    find(test);
    CHECK_EQUAL(mesh.triangle_count, count_sides(0, mesh.triangle_count, STP_SEEN_FRONT));
}

void test_seen_sides_of_flat_and_empty_meshes(test_state* test)
{
    clear_mesh();
    find(test);
    CHECK_EQUAL(0xEE, mesh.sides[0]);
    add_cube(0, 0, 0, 0); // a point
    find(test);
    CHECK_EQUAL(12, count_sides(0, 12, 0));
    clear_mesh();
    add_cube(0, 0, 0, 1);
    for (size_t i = 0; i < 8; ++i) { // a closed box without thickness, seen from above and below
        mesh.positions[3 * i + 2] = 7.0f;
    }
    find(test);
    for (uint32_t t = 0; t < 12; ++t) {
        bool is_cover = t < 2 || t >= 10;
        CHECK(!is_cover || mesh.sides[t] != 0);
    }
}

typedef struct nested_call {
    stp_context* context;
    stp_result result;
} nested_call;

static void find_nested(size_t begin, size_t end, uint32_t worker, void* user)
{
    nested_call* call = user;
    (void)end;
    (void)worker;
    if (begin == 0) {
        call->result = find_sides(call->context, RESOLUTION);
    }
}

void test_seen_sides_are_the_same_for_any_thread_count(test_state* test)
{
    static uint8_t expected[MANY];
    clear_mesh();
    add_ball(0, 0, 0, 1);
    mesh.triangle_count -= mesh.triangle_count / 4;
    add_cube(0.3f, 0.2f, -0.5f, 0.7f);
    find(test);
    memcpy(expected, mesh.sides, mesh.triangle_count);
    CHECK(count_sides(0, mesh.triangle_count, 0) > 0);
    stp_context* context = test_context(NULL, 3, NULL);
    CHECK(context != NULL && find_sides(context, RESOLUTION) == STP_OK);
    CHECK(memcmp(expected, mesh.sides, mesh.triangle_count) == 0);
    nested_call call = {.context = context, .result = STP_ERROR_CANCELLED};
    stp_parallel_for(context, 8, 1, find_nested, &call);
    CHECK(call.result == STP_OK);
    CHECK(memcmp(expected, mesh.sides, mesh.triangle_count) == 0);
    stp_context_destroy(context);
}

void test_seen_sides_survive_failing_allocations(test_state* test)
{
    clear_mesh();
    add_cube(0, 0, 0, 1);
    for (int n = 0;; ++n) { // fail the n-th allocation, until one run gets through
        CHECK(n < 1000);
        test_heap heap = TEST_HEAP(n);
        test_log log = {.errors = 0};
        stp_context* context = test_context(&heap, 2, &log);
        if (context == NULL) {
            continue;
        }
        stp_result result = find_sides(context, RESOLUTION);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
        CHECK(result == STP_OK || (result == STP_ERROR_OUT_OF_MEMORY && log.errors == 1));
        if (result == STP_OK && heap.count <= n) {
            break;
        }
    }
}

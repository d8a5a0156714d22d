// SPDX-License-Identifier: MIT
// Views of a given number of splats of progressive sets: the picture shows exactly the splats of
// that state, with both backends. Each splat is a dot with its own colour and place, so the picture
// tells which are drawn.
#include "support_gl.h"
#include "tests.h"

#include "base/splats/prefix_table.h"
#include "base/splats/progressive.h"
#include "base/splats/splat_codes.h"
#include "store/support_progressive.h"

#include <string.h>

enum {
    PIXELS = PICTURE_SIDE * PICTURE_SIDE,
    COLUMNS = 16,
    SETS = 2,
    MOST = 128,
    ALL = SETS * MOST
};

static const progressive_desc descs[SETS] = {{.seed = 3, .base = 7, .splits = 60},
                                             {.seed = 4, .base = 3, .splits = 50, .coarse = true}};
enum { STATE_MAX = 67 + 53 };

/// The sets; the second one's node moves.
typedef struct two_sets {
    stp_context* context;
    stp_arena arena;
    stp_splats sets[SETS];
    uint32_t order[SETS][MOST];
} two_sets;

static two_sets made;

/// One dot per splat, four pixels apart.
static void spread(stp_splats* set, int which)
{
    set->origin = (stp_vec3){-1, -1, 0};
    set->step = 0x1p-15f;
    for (uint32_t i = 0; i < set->count; ++i) {
        uint32_t row = i / COLUMNS + (which == 0 ? 0 : MOST / COLUMNS),
                 radius = stp_shape_code(1300);
        set->positions[3 * i] = (uint16_t)(4096 * (i % COLUMNS) + 2048);
        set->positions[3 * i + 1] = (uint16_t)(4096 * row + 2048);
        set->positions[3 * i + 2] = 0;
        set->normals[2 * i] = set->normals[2 * i + 1] = 0;
        set->shapes[i] = radius | radius << 12;
        set->colors[3 * i] = (uint8_t)(8 + 16 * (i % COLUMNS));
        set->colors[3 * i + 1] = (uint8_t)(8 + 16 * (i / COLUMNS));
        set->colors[3 * i + 2] = which == 0 ? 255 : 100;
    }
}

static void add_sets(made_picture* p)
{
    made_scene* s = &p->scene;
    two_sets* m = &made;
    m->context = test_context(NULL, 1, NULL);
    m->arena = stp_arena_create(m->context, 1 << 20);
    for (uint32_t k = 0; k < SETS; ++k) {
        uint32_t scratch[MOST];
        stp_splats* set = &m->sets[k];
        if (!progressive_sample_make(&m->arena, &descs[k], set)) {
            return;
        }
        stp_progressive_order(set->ranges, set->count, m->order[k], scratch);
        spread(set, (int)k);
        progressive_sample_octaves(set, 16);
        s->sets[s->set_count++] = *set;
        s->nodes[s->node_count++] = (stp_store_node){
            .set = k, .flags = k, .triangle_count = 1000000, .bounds = {{-1, -1, 0}, {1, 1, 0}}};
        s->edges[s->edge_count++] = (stp_store_edge){k, stp_affine_identity()};
    }
    s->method = (stp_store_method){.name = "psp",
                                   .id = STP_METHOD_PSP,
                                   .columns = STP_SPLATS_SHAPES | STP_SPLATS_RANGES |
                                              STP_SPLATS_FLAT_COLORS};
    p->view.ortho_height = 2.0;
    p->quality.all_sides = true;
}

/// Splats of a state of a set; the first ones if there are fewer than in the base set.
static uint32_t mark_state(int which, uint32_t wanted, uint32_t prefix, bool* marks)
{
    const stp_splats* set = &made.sets[which];
    stp_progressive_counts counts = stp_progressive_count(set->ranges, prefix);
    memset(marks, 0, MOST * sizeof(*marks));
    uint32_t size = progressive_sample_mark(counts, made.order[which], wanted, marks);
    for (uint32_t i = wanted; i < counts.base; ++i) {
        marks[i] = false;
    }
    return size < wanted ? size : wanted;
}

static double area_of(const stp_splats* set)
{
    uint32_t quarter = set->count / 4 + 1;
    double radius = (double)stp_prefix_table_radius(&set->table, quarter);
    return quarter * radius * radius;
}

/// Distributes splats one by one: each set gets one; then always the set with the fewest per area
/// that has more.
static void share_out(uint64_t wanted, uint32_t shares[SETS])
{
    static const uint32_t maximum[SETS] = {67, 53};
    shares[0] = wanted > 0;
    shares[1] = wanted > 1;
    double areas[SETS] = {area_of(&made.sets[0]), area_of(&made.sets[1])};
    for (uint32_t n = 2; n < wanted && n < STATE_MAX; ++n) {
        bool first = (2 * shares[0] + 1) * areas[1] < (2 * shares[1] + 1) * areas[0];
        first = shares[1] == maximum[1] || (first && shares[0] < maximum[0]);
        shares[first ? 0 : 1] += 1;
    }
}

/// The splats of both sets that a view of `wanted` splats draws. @return their number
static uint32_t mark_both(uint64_t wanted, uint32_t prefix, bool marks[ALL])
{
    uint32_t shares[SETS], sum = 0;
    share_out(wanted, shares);
    for (int k = 0; k < SETS; ++k) {
        uint32_t here = prefix < made.sets[k].count ? prefix : made.sets[k].count;
        sum += mark_state(k, shares[k], here, marks + (size_t)k * MOST);
    }
    return sum;
}

/// The dots of a picture. @return their number
static uint32_t find_seen(const uint8_t* pixels, bool seen[ALL])
{
    uint32_t count = 0;
    memset(seen, 0, ALL * sizeof(*seen));
    for (int i = 0; i < PIXELS; ++i) {
        const uint8_t* p = pixels + 4 * i;
        if (p[3] != 0) {
            uint32_t at = (uint32_t)p[1] / 16 * COLUMNS + (uint32_t)p[0] / 16;
            seen[(p[2] > 180 ? 0u : MOST) + at % MOST] = true;
        }
    }
    for (int i = 0; i < ALL; ++i) {
        count += seen[i];
    }
    return count;
}

/// Compares the dots of a picture with the marked ones; if `half`, only right of the middle.
/// @return wrong dots
static int compare(const uint8_t* pixels, const bool marks[ALL], bool half)
{
    bool seen[ALL];
    int wrong = 0;
    (void)find_seen(pixels, seen);
    for (int i = 0; i < ALL; ++i) {
        bool cut = half && i % COLUMNS < COLUMNS / 2;
        wrong += seen[i] != (marks[i] && !cut) ? 1 : 0;
    }
    return wrong;
}

static void free_sets(void)
{
    if (made.context != NULL) {
        stp_arena_destroy(&made.arena);
        stp_context_destroy(made.context);
    }
    made = (two_sets){.context = NULL};
}

static void tear_down(made_gl* m)
{
    m->picture.scene.set_count = 0; // they are in the arena
    made_gl_end(m);
    free_sets();
}

/// Draws a number of splats with either backend; compares the dots and the reported count.
static void check_count(test_state* test, made_gl* m, bool gl, uint64_t wanted)
{
    made_picture* p = &m->picture;
    bool marks[ALL], half = p->view.sections.count > 0;
    p->quality.splat_count = wanted;
    CHECK_EQUAL(STP_OK, gl ? made_gl_draw(m) : made_picture_draw(p));
    uint32_t expected = mark_both(wanted, MOST, marks);
    CHECK_EQUAL(wanted < STATE_MAX ? wanted : STATE_MAX, expected);
    CHECK_EQUAL(expected, p->stats.listed_splats);
    CHECK(half ? p->stats.splats <= expected : p->stats.splats == expected);
    CHECK_EQUAL(0, compare(gl ? m->pixels : p->pixels, marks, half));
}

/// Draws with several splat sizes; compares the reported counts with the dots seen.
static void check_drawn(test_state* test, made_gl* m, bool gl)
{
    made_picture* p = &m->picture;
    bool seen[ALL], fewer = false;
    p->quality.splat_count = 0;
    p->quality.splats_only = true;
    for (float size = 1.0f; size < 100.0f; size *= 1.5f) {
        p->quality.splat_size = size;
        CHECK_EQUAL(STP_OK, gl ? made_gl_draw(m) : made_picture_draw(p));
        CHECK_EQUAL(find_seen(gl ? m->pixels : p->pixels, seen), p->stats.splats);
        CHECK(p->stats.splats <= p->stats.listed_splats);
        fewer = fewer || p->stats.splats < p->stats.listed_splats;
    }
    CHECK(fewer);
    p->quality.splat_size = 1.0f;
    p->quality.splats_only = false;
}

// All counts in turn, then random ones: refines and coarsens.
void test_states_are_drawn_splat_by_splat(test_state* test)
{
    static made_gl m;
    CHECK(made_picture_begin(&m.picture, NULL, 2));
    add_sets(&m.picture);
    CHECK_EQUAL(STP_OK, made_picture_open(&m.picture));
    for (uint64_t n = 1; n < STATE_MAX + 4; ++n) {
        check_count(test, &m, false, n);
    }
    for (uint64_t n = UINT64_MAX; n > 0; n /= 3) {
        check_count(test, &m, false, n);
    }
    check_drawn(test, &m, false);
    // a section that keeps one half
    m.picture.view.sections = (stp_sections){.count = 1, .planes = {{{-1, 0, 0}, 0}}};
    for (uint64_t n = 5; n < STATE_MAX; n += 13) {
        check_count(test, &m, false, n);
    }
    m.picture.scene.set_count = 0;
    made_picture_end(&m.picture);
    free_sets();
}

static void add_broken(made_picture* p)
{
    add_sets(p);
    for (uint32_t k = 0; k < SETS; ++k) {
        stp_splats* set = &p->scene.sets[k];
        for (uint32_t i = descs[k].base + 1; i < set->count; i += 5) {
            set->ranges[i] = (uint32_t)STP_RANGE_INFINITE << 16; // drawn at any level
        }
    }
}

// Sets whose ranges are not a split sequence have no states: at most the given number of splats is
// drawn.
void test_states_of_sets_that_have_none(test_state* test)
{
    static made_picture p;
    CHECK(made_picture_begin(&p, NULL, 2));
    add_broken(&p);
    CHECK_EQUAL(STP_OK, made_picture_open(&p));
    enum { MANY = 86 }; // smaller counts may be states by chance
    for (uint64_t n = 1; n < STATE_MAX; ++n) {
        p.quality.splat_count = n;
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        CHECK(p.stats.splats > 0 && p.stats.splats <= n);
        CHECK(p.stats.covered_pixels > 0);
        CHECK(n < MANY || p.list.items[0].divide == 0);
    }
    p.scene.set_count = 0;
    made_picture_end(&p);
    free_sets();
}

void test_states_survive_failing_allocator(test_state* test)
{
    static made_gl m;
    bool failed = true;
    for (int n = 0; failed; ++n) {
        test_heap heap = TEST_HEAP(-1);
        CHECK(made_picture_begin(&m.picture, &heap, 2));
        add_sets(&m.picture);
        CHECK_EQUAL(STP_OK, made_picture_open(&m.picture));
        m.picture.quality.splat_count = 90;
        heap.fail_at = heap.count + n;
        stp_result result = made_picture_draw(&m.picture);
        heap.fail_at = -1;
        failed = result != STP_OK;
        CHECK(!failed || result == STP_ERROR_OUT_OF_MEMORY);
        CHECK(failed || n >= 8);
        check_count(test, &m, false, 90);
        check_count(test, &m, false, 50);
        m.picture.scene.set_count = 0;
        made_picture_end(&m.picture);
        free_sets();
        CHECK_EQUAL(0, heap.live_bytes);
    }
}

static bool begin_gl(test_state* test, made_gl* m)
{
    bool failed;
    if (made_gl_begin_with(m, add_sets, NULL, NULL, &failed)) {
        return true;
    }
    tear_down(m);
    CHECK(!failed);
    test->skipped = "there is no OpenGL";
    return false;
}

void test_gl_states_are_drawn_splat_by_splat(test_state* test)
{
    static const stp_gl_splats ways[] = {STP_GL_SPLATS_POINTS, STP_GL_SPLATS_COMPUTE};
    static made_gl m;
    if (!begin_gl(test, &m)) {
        return;
    }
    for (int i = 0; i < 2; ++i) {
        stp_draw_gl_set_splats(m.renderer, ways[i]);
        for (uint64_t n = 1; n < STATE_MAX + 4; n += 3) {
            check_count(test, &m, true, n);
        }
        check_drawn(test, &m, true);
    }
    m.picture.view.sections = (stp_sections){.count = 1, .planes = {{{-1, 0, 0}, 0}}};
    check_count(test, &m, true, 41);
    tear_down(&m);
}

// While octaves are missing, the loaded splats are a state with fewer splats, without gaps.
void test_gl_states_are_coarser_until_octaves_come(test_state* test)
{
    const stp_draw_gl_desc settings = {.upload_bytes = 1};
    static made_gl m;
    bool marks[ALL];
    if (!begin_gl(test, &m)) {
        return;
    }
    CHECK_EQUAL(STP_OK, made_gl_renew(&m, &settings));
    m.picture.quality.splat_count = 110;
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    CHECK(stp_draw_gl_get_stats(m.renderer).missing > 0);
    bool part = false; // the first octave, or the first two, of each
    uint32_t shares[SETS];
    share_out(110, shares);
    for (uint32_t i = 0; i < 4; ++i) {
        (void)mark_state(0, shares[0], i % 2 == 0 ? 16 : 64, marks);
        (void)mark_state(1, shares[1], i / 2 == 0 ? 16 : 64, marks + MOST);
        part = part || compare(m.pixels, marks, false) == 0;
    }
    CHECK(part);
    for (int i = 0; i < 20 && stp_draw_gl_get_stats(m.renderer).missing > 0; ++i) {
        CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    }
    check_count(test, &m, true, 110);
    tear_down(&m);
}

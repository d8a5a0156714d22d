// SPDX-License-Identifier: MIT
// Runs of splats with gaps: splats in gaps, and outside their run's depths, are not drawn.
#include "support_gl.h"

#include <string.h>

enum { RUNS = 4, COUNT = 1024, PIXEL_BYTES = PICTURE_SIDE * PICTURE_SIDE * 4 };

typedef struct run_list {
    stp_draw_item item;
    stp_draw_run runs[RUNS];
} run_list;

// The first 64 splats, a gap, then some of the rest. The gap lies between runs, or is a run outside
// all depths.
static run_list make_list(const stp_draw_item* item, bool gaps)
{
    run_list l = {.item = *item};
    const stp_draw_run all[RUNS] = {{0, 64, 0.0f, HUGE_VALF},
                                    {64, 256, 3e38f, HUGE_VALF},
                                    {256, 320, 0.0f, HUGE_VALF},
                                    {320, item->prefix, 3e38f, HUGE_VALF}};
    for (uint32_t i = 0; i < RUNS; i += gaps ? 2 : 1) {
        l.runs[l.item.run_count++] = all[i];
    }
    l.item.first_run = 0;
    return l;
}

static bool draw(stp_renderer* renderer, const made_picture* p, run_list* l, uint8_t* pixels)
{
    stp_draw_list list = {.items = &l->item,
                          .count = 1,
                          .runs = l->runs,
                          .run_count = l->item.run_count,
                          .first_pass_count = 1,
                          .splat_count = l->item.prefix,
                          .id_count = l->item.prefix,
                          .splat_size = 1.0f};
    stp_image image = {PICTURE_SIDE, PICTURE_SIDE, pixels};
    stp_draw_stats stats;
    return stp_renderer_draw(renderer, &p->view, &list, &p->style, &image, &stats) == STP_OK;
}

static void compare(test_state* test, stp_renderer* renderer, made_picture* p)
{
    static uint8_t with_gaps[PIXEL_BYTES], without[PIXEL_BYTES], whole[PIXEL_BYTES];
    p->quality.splats_only = true;
    CHECK_EQUAL(STP_OK, stp_select(p->context, p->store, &p->view, &p->quality, &p->list));
    CHECK(p->list.count > 0 && p->list.items[0].kind == STP_DRAW_SPLATS);
    stp_draw_item item = p->list.items[0];
    item.prefix = item.full_prefix = COUNT;
    item.run_count = 0;
    run_list a = make_list(&item, true), b = make_list(&item, false), all = {.item = item};
    CHECK(a.item.run_count == 2 && b.item.run_count == 4);
    CHECK(draw(renderer, p, &a, with_gaps) && draw(renderer, p, &b, without) &&
          draw(renderer, p, &all, whole));
    CHECK(memcmp(with_gaps, without, PIXEL_BYTES) == 0);
    CHECK(memcmp(with_gaps, whole, PIXEL_BYTES) != 0);
    int covered = 0;
    for (int i = 0; i < PIXEL_BYTES; i += 4) {
        covered += with_gaps[i + 3] != 0 ? 1 : 0;
    }
    CHECK(covered > 50);
}

void test_draw_runs_may_leave_gaps(test_state* test)
{
    static const uint8_t red[3] = {255, 0, 0};
    made_picture p;
    CHECK(made_picture_begin(&p, NULL, 2));
    made_picture_add(&p, 0.0, (stp_vec3d){0, 0, 0}, red);
    CHECK_EQUAL(STP_OK, made_picture_open(&p));
    compare(test, p.renderer, &p);
    made_picture_end(&p);
}

void test_gl_runs_may_leave_gaps(test_state* test)
{
    static made_gl m;
    bool failed = false;
    if (!made_gl_begin(&m, true, &failed)) {
        made_gl_end(&m);
        CHECK(!failed);
        test->skipped = "there is no OpenGL";
        return;
    }
    compare(test, m.renderer, &m.picture);
    made_gl_end(&m);
}

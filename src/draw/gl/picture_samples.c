// SPDX-License-Identifier: MIT
// Samples of a picture: each is drawn and shaded; several are summed.
#include "base/core/clock.h"
#include "base/core/context.h"
#include "base/math/color.h"
#include "draw/gl/gl_renderer.h"
#include "draw/shading_setup.h"
#include "select/eyes.h"
#include "store/file/point_attributes.h"

#include <assert.h>

_Static_assert((uint32_t)STP_FRONT_ONLY_NONE == FRONT_ONLY_NONE &&
                   (uint32_t)STP_FRONT_ONLY_SOME == FRONT_ONLY_SOME &&
                   (uint32_t)STP_FRONT_ONLY_ALL == FRONT_ONLY_ALL,
               "as shaders have it");

enum { POINT_MARGIN = 64 };

/// One sample, and the use of its result.
typedef struct stp_gl_sample {
    uint32_t side, place;   ///< index among side x side
    uint32_t number, count; ///< samples summed before it, and including it
    bool sums;              ///< shading adds it to the sums
    bool bare;              ///< shaded to bytes without a background, then added to the sums
    bool shows;             ///< the picture is resolved from the sums
    bool timed;             ///< by the renderer's timer
} stp_gl_sample;

static void set_vec3(vec4 out, stp_vec3d v)
{
    out[0] = (float)v.x;
    out[1] = (float)v.y;
    out[2] = (float)v.z;
}

static void set_light(const stp_gl_renderer* r, const stp_view_frame* f, view_block* view)
{
    stp_lighting light = stp_lighting_make(f, r->style->headlight);
    set_vec3(view->light, stp_to_double(light.key));
    set_vec3(view->up, stp_to_double(light.up));
    set_vec3(view->left_box, stp_to_double(light.left_box));
    set_vec3(view->right_box, stp_to_double(light.right_box));
}

/// Constants of all pixels: direction to the eye, the negative of (forward + right u + down v).
static void set_eye(const stp_placement* p, view_block* view)
{
    const stp_view_frame* f = &p->frame;
    stp_vec3d start = stp_scaled(f->forward, -1.0);
    if (!f->parallel) {
        double u = -(f->center_x + p->shift_x) / f->scale;
        double v = -(f->center_y + p->shift_y) / f->scale;
        start = stp_subd(start, stp_addd(stp_scaled(f->right, u), stp_scaled(f->down, v)));
        set_vec3(view->eye_across, stp_scaled(f->right, -1.0 / f->scale));
        set_vec3(view->eye_down, stp_scaled(f->down, -1.0 / f->scale));
    }
    set_vec3(view->eye_start, start);
}

static void set_heights(const stp_gl_renderer* r, const stp_placement* p, view_block* view)
{
    const stp_draw_pixels pixels = {p->shift_x, p->shift_y, p->nearness_scale, p->nearness_offset};
    stp_draw_heights h = stp_draw_heights_make(&p->frame, &pixels, r->style);
    for (int i = 0; i < 3; ++i) {
        view->height_place[i] = h.place[i];
        view->height_along[i] = h.along[i];
    }
}

/// Section planes in right, down and depth of the view.
static void set_section_rows(const stp_placement* p, const stp_sections* sections, view_block* view)
{
    const stp_view_frame* f = &p->frame;
    for (uint32_t i = 0; i < sections->count && i < SECTION_PLANES; ++i) {
        const stp_section_plane* plane = &sections->planes[i];
        view->section_rows[i][0] = (float)stp_dotd(plane->normal, f->right);
        view->section_rows[i][1] = (float)stp_dotd(plane->normal, f->down);
        view->section_rows[i][2] = (float)stp_dotd(plane->normal, f->forward);
        view->section_rows[i][3] = (float)(stp_dotd(plane->normal, f->eye) - plane->distance);
    }
}

_Static_assert(SECTION_PLANES == STP_SECTION_PLANES, "as many planes as a view has");

static float ghost_share(const stp_draw_style* style)
{
    return style->ghost > 0.0f ? stp_min(style->ghost, 1.0f) : 0.2f;
}

static view_block make_view(const stp_gl_renderer* r, const stp_gl_sample* sample)
{
    assert(sample->number < sample->count && r->eye < r->target.eye_count);
    assert(STP_BACK_SINE == (float)BACK_SINE && "shaders leave out the same splats");
    const stp_placement* p = &r->placement;
    const stp_view_frame* f = &p->frame;
    float width = (float)r->target.width, height = (float)r->target.height;
    float margin = POINT_MARGIN, ghost = ghost_share(r->style);
    view_block view = {
        .size = {width, height, 1.0f / (width + 2.0f * margin), 1.0f / (height + 2.0f * margin)},
        .nearness_scale = (float)p->nearness_scale,
        .nearness_offset = (float)p->nearness_offset,
        .margin = margin,
        .parallel = f->parallel ? 1 : 0,
        .pattern = sample->place,
        .counts = sample->sums || sample->bare ? 0 : 1,
        .item_count = (uint32_t)r->frame.item_count,
        .id_shift = r->frame.id_shift,
        .sample_number = sample->number,
        .sample_count = sample->count,
        .picture_x = r->eye * r->target.width,
        .depth_y = r->eye * r->target.height,
        .point_extent = r->point_extent,
        .filtered = (uint32_t)r->style->filter,
        .ghost = ghost,
        .hides = stp_store_get_coloring(r->store)->hides ? 1 : 0,
        .recolors = (uint32_t)r->style->coloring,
        .scale_first = SHADINGS + r->directory->material_count,
        .glass = r->layer_pass.active ? GLASS_LAYERS : GLASS_PATTERN,
        .nearest_only = r->style->transparency == STP_TRANSPARENCY_NEAREST ? 1 : 0,
        .ghost_seed = GHOST_SEED,
        .front_only = stp_draws_backs(r->style, &r->view->sections) ? FRONT_ONLY_NONE
                                                                    : (uint32_t)r->front_only,
        .ghost_splats = stp_placement_ghost_part(ghost)};
    view.screen[0] = (float)(f->center_x + p->shift_x);
    view.screen[1] = (float)(f->center_y + p->shift_y);
    view.screen[2] = (float)(1.0 / f->scale);
    set_light(r, f, &view);
    set_eye(p, &view);
    set_heights(r, p, &view);
    set_section_rows(p, &r->view->sections, &view);
    stp_gl_occlusion_pass_set_view(r, &view);
    for (int k = 0; k < 3; ++k) {
        view.background[k] = stp_srgb8_to_linear(r->style->background_color[k]);
    }
    view.background[3] = r->style->background ? 1.0f : 0.0f;
    for (uint32_t i = 0; i < SHADINGS; ++i) {
        view.glass_shadings[i / 128][i / 32 % 4] |= (uint32_t)r->layer_pass.of_shading[i] << i % 32;
        view.front_shadings[i / 128][i / 32 % 4] |= (uint32_t)r->front_only_shadings[i] << i % 32;
    }
    for (uint32_t i = 0; i < r->directory->shading_count; ++i) {
        view.growths[i / 4][i % 4] = r->directory->shadings[i].growth;
    }
    return view;
}

void stp_gl_set_visible_state(stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    const stp_gl_target* t = &r->target;
    gl->BindFramebuffer(GL_FRAMEBUFFER, t->framebuffer);
    gl->Disable(GL_SCISSOR_TEST);
    gl->Disable(GL_BLEND);
    gl->Disable(GL_CULL_FACE);
    gl->Disable(GL_STENCIL_TEST);
    gl->Enable(GL_DEPTH_TEST);
    gl->DepthFunc(GL_GREATER); // nearness
    gl->DepthMask(GL_TRUE);
    gl->ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    gl->ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE); // row 0 is the top row: y is down
    gl->DepthRange(0.0, 1.0);
    gl->Viewport(-POINT_MARGIN, -POINT_MARGIN, (GLsizei)t->width + 2 * POINT_MARGIN,
                 (GLsizei)t->height + 2 * POINT_MARGIN);
}

/// Draws the commands of triangles, and of splats that are not large.
static stp_result draw_commands(stp_gl_renderer* r, bool late)
{
    stp_result result = stp_gl_triangle_pass_draw(r);
    return result == STP_OK ? stp_gl_splat_choice_draw(r, late) : result;
}

/// Draws content that the previous picture does not occlude, then the rest that this one does not
/// occlude. The first picture is drawn in one pass; its depths serve the next ones.
static stp_result draw_passes(stp_gl_renderer* r)
{
    stp_gl_occlusion_pass* pass = &r->occlusion;
    bool serves = stp_gl_occlusion_pass_serves(r);
    bool known = pass->known && pass->width == r->target.width && pass->height == r->target.height;
    pass->culls = serves && known;
    stp_result result = pass->culls ? stp_gl_occlusion_pass_cull(r, false) : STP_OK;
    result = result == STP_OK ? draw_commands(r, false) : result;
    if (result == STP_OK && serves) {
        result = stp_gl_occlusion_pass_fill(r);
    }
    if (result == STP_OK && pass->culls) {
        result = stp_gl_occlusion_pass_cull(r, true);
        result = result == STP_OK ? draw_commands(r, true) : result;
    }
    if (result == STP_OK) {
        stp_gl_splat_choice_draw_large(r);
        result = stp_gl_portion_wait(r);
    }
    return result;
}

/// Draws the visibility buffer of one sample.
static stp_result draw_visible(stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    const stp_gl_target* t = &r->target;
    const GLuint nothing[4] = {NO_ID, NO_ID, NO_ID, NO_ID};
    const GLfloat far = 0.0f;
    stp_gl_set_visible_state(r);
    stp_gl_bind_frame(r);
    gl->ClearNamedFramebufferuiv(t->framebuffer, GL_COLOR, 0, nothing);
    gl->ClearNamedFramebufferfv(t->framebuffer, GL_DEPTH, 0, &far);
    if (stp_gl_filter_is_tolerant(r)) {
        stp_result result = stp_gl_triangle_pass_draw(r);
        return result == STP_OK ? stp_gl_filter_pass_draw_tolerant(r) : result;
    }
    stp_result result = draw_passes(r);
    if (result == STP_OK && r->style->filter == STP_FILTER_EWA) {
        result = stp_gl_filter_pass_blend(r);
    }
    return result;
}

/// Restores the state that draw_gl.h promises.
void stp_gl_leave_state(const stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    gl->UseProgram(0);
    gl->BindVertexArray(0);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl->BindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
    gl->BindBuffer(GL_PARAMETER_BUFFER_ARB, 0);
    gl->Disable(GL_DEPTH_TEST);
    gl->DepthFunc(GL_LESS);
    gl->ClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
}

/// Marks a point in time if the sample is timed.
static void mark_time(const stp_gl_renderer* r, const stp_gl_sample* sample,
                      stp_gl_timer_point point)
{
    if (sample->timed) {
        stp_gl_timer_mark(&r->gl, &r->timer, point);
    }
}

/// Shades the visibility buffer into the picture or the sums.
static stp_result shade(stp_gl_renderer* r, const stp_gl_sample* sample)
{
    bool wanted = r->style->pixel_filter && !sample->sums && !sample->bare;
    bool filters = wanted && stp_gl_pixel_filter_pass_begin(r);
    stp_result result = stp_gl_shade_pass_draw(r, sample->sums, filters);
    result = result == STP_OK ? stp_gl_portion_wait(r) : result;
    bool works_on_bytes = !sample->sums;
    if (result == STP_OK && works_on_bytes) {
        result = stp_gl_cap_pass_draw(r);
    }
    mark_time(r, sample, GL_TIMER_LIT);
    if (result == STP_OK && works_on_bytes) {
        result = stp_gl_effect_pass_draw(r);
        result = result == STP_OK ? stp_gl_portion_wait(r) : result;
    }
    mark_time(r, sample, GL_TIMER_EFFECTS);
    if (result == STP_OK && r->layer_pass.active) {
        result = stp_gl_layer_pass_draw(r);
    }
    mark_time(r, sample, GL_TIMER_LAYERED);
    if (result == STP_OK && filters) {
        stp_gl_pixel_filter_pass_draw(r);
    }
    if (result == STP_OK && sample->bare) {
        result = stp_gl_shade_pass_add(r);
    }
    return result == STP_OK && sample->shows ? stp_gl_shade_pass_average(r) : result;
}

/// Marks the times of a sample that is not shaded.
static void skip_shading(const stp_gl_renderer* r, const stp_gl_sample* sample)
{
    mark_time(r, sample, GL_TIMER_LIT);
    mark_time(r, sample, GL_TIMER_EFFECTS);
    mark_time(r, sample, GL_TIMER_LAYERED);
}

static stp_result draw_sample(stp_gl_renderer* r, stp_gl_sample* sample)
{
    view_block view = make_view(r, sample);
    stp_result result = stp_gl_frame_send(r, &view);
    result = result == STP_OK ? stp_gl_splat_choice_measure(r) : result;
    if (result != STP_OK) {
        return result;
    }
    if (r->eye == 0) {
        r->draw_calls = r->dispatches = 0;
    }
    sample->timed = stp_gl_timer_begin(&r->gl, &r->timer);
    result = draw_visible(r);
    mark_time(r, sample, GL_TIMER_DRAWN);
    if (result == STP_OK && !r->omits.shading) {
        result = shade(r, sample);
    } else {
        skip_shading(r, sample);
    }
    if (sample->timed) {
        stp_gl_timer_end(&r->gl, &r->timer);
    }
    stp_gl_ring_mark(&r->gl, &r->frame.ring);
    stp_gl_ring_mark(&r->gl, &r->pool.ring);
    return result;
}

stp_result stp_gl_draw_eye(stp_gl_renderer* r, uint32_t eye, const stp_gl_sample_range* range)
{
    assert(eye < stp_view_eye_count(r->view) && range->end <= range->side * range->side);
    stp_view one = stp_view_of_eye(r->view, eye);
    r->eye = eye;
    if (!stp_view_frame_make(&one, &r->placement.frame)) {
        return stp_fail(r->base.context, STP_ERROR_ARGUMENT, "view: has no second eye");
    }
    stp_placement_make(&r->placement, r->directory, r->list);
    stp_gl_layer_pass_begin(r);
    double start = stp_clock_ms();
    stp_result result = stp_gl_frame_make(r);
    r->clock.prepare += stp_clock_ms() - start;
    result = result == STP_OK ? stp_gl_make_programs(r) : result;
    // otherwise the picture stays unchanged
    if (result == STP_OK && eye == 0 && range->first < range->end) {
        stp_gl_shade_pass_clear(r);
    }
    for (uint32_t k = range->first; k < range->end && result == STP_OK; ++k) {
        stp_gl_sample sample = {.side = range->side,
                                .place = range->scattered ? stp_resting_sample(range->side, k) : k,
                                .number = k,
                                .count = k + 1,
                                .sums = range->sums && !range->bytes,
                                .bare = range->bytes,
                                .shows = range->sums && k + 1 == range->end};
        stp_placement_shift(range->side, sample.place, &r->placement.shift_x,
                            &r->placement.shift_y);
        stp_gl_frame_place(r, sample.place);
        result = draw_sample(r, &sample);
    }
    return result;
}

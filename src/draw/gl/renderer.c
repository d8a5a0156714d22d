// SPDX-License-Identifier: MIT
// A frame from beginning to end.
#include "draw/gl/renderer.h"

#include "base/clock.h"
#include "base/color.h"
#include "base/context.h"
#include "draw/gl/upload.h"
#include "select/eyes.h"

#include <stdio.h>
#include <string.h>

enum { SUPERSAMPLE_LIMIT = 64, POINT_MARGIN = 64 };
static const uint64_t default_memory = UINT64_C(1) << 30;

static void destroy_programs(gl_renderer* r)
{
    if (r->program_pages > 0) {
        gl_splat_pass_destroy(r);
        gl_raster_pass_destroy(r);
        gl_triangle_pass_destroy(r);
        gl_shade_pass_destroy(r);
    }
    r->program_pages = 0;
}

static void destroy(stp_renderer* renderer)
{
    gl_renderer* r = (gl_renderer*)renderer;
    stp_context* context = renderer->context;
    if (r->pool.gl != NULL) { // the context's functions are known
        destroy_programs(r);
        gl_timer_destroy(&r->gl, &r->timer);
        gl_target_destroy(r);
        gl_frame_destroy(r);
        gl_pool_destroy(&r->pool);
        const GLuint buffers[] = {r->light_materials, r->materials};
        r->gl.DeleteBuffers(2, buffers);
        if (r->debug != NULL) {
            r->gl.DebugMessageCallback(NULL, NULL);
        }
    }
    gl_things_destroy(r);
    if (r->readback != NULL) {
        stp_free(context, r->readback->depth);
    }
    stp_free(context, r->readback);
    stp_free(context, r->debug);
    stp_free(context, r);
}

/// Programs read as many pages as there are, or somewhat more: most pools have one.
static stp_result make_programs(gl_renderer* r)
{
    uint32_t pages = 1;
    while (pages < r->pool.page_count) {
        pages *= 2;
    }
    if (pages == r->program_pages) {
        return STP_OK;
    }
    destroy_programs(r);
    r->program_pages = pages;
    stp_result result = gl_splat_pass_create(r);
    result = result == STP_OK ? gl_raster_pass_create(r) : result;
    result = result == STP_OK ? gl_triangle_pass_create(r) : result;
    return result == STP_OK ? gl_shade_pass_create(r) : result;
}

/// What has gone wrong since the last time: a lost context, or an error that a debug context named.
static stp_result check(gl_renderer* r)
{
    GLenum reset = r->gl.GetGraphicsResetStatus();
    if (reset != GL_NO_ERROR) {
        return stp_fail(r->base.context, STP_ERROR_UNSUPPORTED,
                        "gl: the graphics context was lost (%s): it, and the renderer, must be "
                        "made anew",
                        reset == GL_GUILTY_CONTEXT_RESET     ? "through what was drawn here"
                        : reset == GL_INNOCENT_CONTEXT_RESET ? "through another program"
                                                             : "for an unknown reason");
    }
    if (r->debug != NULL && r->debug->errors > 0) {
        r->debug->errors = 0;
        return stp_fail(r->base.context, STP_ERROR_UNSUPPORTED, "gl: %s", r->debug->message);
    }
    return STP_OK;
}

static void set_vec3(vec4 out, stp_vec3d v)
{
    out[0] = (float)v.x;
    out[1] = (float)v.y;
    out[2] = (float)v.z;
}

/// Light from above the viewer's left shoulder, or from the eye (src/draw/cpu/shade.c).
static stp_vec3d toward_light(const stp_view_frame* f, bool headlight)
{
    stp_vec3d up = stp_scaled(f->down, -1.0), back = stp_scaled(f->forward, -1.0);
    if (headlight) {
        return back;
    }
    stp_vec3d toward = stp_addd(stp_scaled(f->right, -0.45), stp_scaled(up, 0.65));
    return stp_normalized(stp_addd(toward, stp_scaled(back, 0.62)));
}

/// What is the same for all pixels: towards the eye, (forward + right u + down v) turned round.
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

/// Sections in right, down and depth of the view.
static void set_cuts(const stp_placement* p, const stp_sections* sections, view_block* view)
{
    const stp_view_frame* f = &p->frame;
    for (uint32_t i = 0; i < sections->count && i < SECTION_PLANES; ++i) {
        const stp_section_plane* plane = &sections->planes[i];
        view->cuts[i][0] = (float)stp_dotd(plane->normal, f->right);
        view->cuts[i][1] = (float)stp_dotd(plane->normal, f->down);
        view->cuts[i][2] = (float)stp_dotd(plane->normal, f->forward);
        view->cuts[i][3] = (float)(stp_dotd(plane->normal, f->eye) - plane->distance);
    }
}

_Static_assert(SECTION_PLANES == STP_SECTION_PLANES, "as many cuts as a view has");

static float ghost_share(const stp_draw_style* style)
{
    return style->ghost > 0.0f ? stp_min(style->ghost, 1.0f) : 0.2f;
}

static view_block make_view(const gl_renderer* r, uint32_t sample, uint32_t sample_count,
                            uint32_t pattern)
{
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
        .pattern = pattern,
        .item_count = (uint32_t)r->frame.item_count,
        .id_shift = r->frame.id_shift,
        .sample_number = sample,
        .sample_count = sample_count,
        .picture_x = r->eye * r->target.width,
        .depth_y = r->eye * r->target.height,
        .point_extent = r->point_extent,
        .ghost = ghost,
        .ghost_splats = ghost < 1.0f ? ghost * (0.45f + 0.55f * ghost) : 1.0f};
    view.screen[0] = (float)(f->center_x + p->shift_x);
    view.screen[1] = (float)(f->center_y + p->shift_y);
    view.screen[2] = (float)(1.0 / f->scale);
    set_vec3(view.light, toward_light(f, r->style->headlight));
    set_vec3(view.up, stp_scaled(f->down, -1.0));
    set_eye(p, &view);
    set_cuts(p, &r->view->sections, &view);
    for (int k = 0; k < 3; ++k) {
        view.background[k] = stp_srgb8_to_linear(r->style->background_color[k]);
    }
    view.background[3] = r->style->background ? 1.0f : 0.0f;
    return view;
}

void gl_set_visible_state(gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    const gl_target* t = &r->target;
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

/// Visibility of one sample.
static stp_result draw_visible(gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    const gl_target* t = &r->target;
    const GLuint nothing[4] = {NO_ID, NO_ID, NO_ID, NO_ID};
    const GLfloat far = 0.0f;
    gl_set_visible_state(r);
    gl_bind_frame(r);
    gl->ClearNamedFramebufferuiv(t->framebuffer, GL_COLOR, 0, nothing);
    gl->ClearNamedFramebufferfv(t->framebuffer, GL_DEPTH, 0, &far);
    gl_triangle_pass_draw(r);
    return gl_splat_choice_draw(r);
}

/// What the header promises.
static void leave_state(const stp_gl* gl)
{
    gl->UseProgram(0);
    gl->BindVertexArray(0);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl->BindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
    gl->BindBuffer(GL_PARAMETER_BUFFER_ARB, 0);
    gl->Disable(GL_DEPTH_TEST);
    gl->DepthFunc(GL_LESS);
    gl->ClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
}

static stp_result draw_sample(gl_renderer* r, uint32_t side, uint32_t sample, bool sums)
{
    uint32_t count = side * side;
    if (sample > 0) {
        stp_placement_shift(&r->placement, side, sample);
        gl_frame_place(r, sample);
    }
    view_block view = make_view(r, sample, count, sample);
    stp_result result = gl_frame_send(r, &view);
    if (result != STP_OK) {
        return result;
    }
    result = gl_splat_choice_measure(r);
    if (result != STP_OK) {
        return result;
    }
    if (r->eye == 0) {
        r->draw_calls = r->dispatches = 0;
    }
    bool timed = gl_timer_begin(&r->gl, &r->timer);
    result = draw_visible(r);
    if (timed) {
        gl_timer_mark(&r->gl, &r->timer, GL_TIMER_DRAWN);
    }
    if (result == STP_OK) {
        gl_shade_pass_draw(r, sums);
    }
    if (result == STP_OK && sums && sample + 1 == count) {
        gl_shade_pass_average(r);
    }
    if (timed) {
        gl_timer_end(&r->gl, &r->timer);
    }
    gl_ring_mark(&r->gl, &r->frame.ring);
    gl_ring_mark(&r->gl, &r->pool.ring);
    return result;
}

static stp_result read_picture(gl_renderer* r, stp_image* image)
{
    r->gl.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    r->gl.PixelStorei(GL_PACK_ALIGNMENT, 4);
    r->gl.GetTextureImage(r->target.picture, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                          (GLsizei)(4 * image->width * image->height), image->pixels);
    return check(r);
}

static stp_result begin_picture(gl_renderer* r, const stp_view* view, const stp_draw_list* list,
                                const stp_draw_style* style, const stp_image* image, uint32_t side)
{
    bool fits = image == NULL || (image->width == view->width && image->height == view->height);
    stp_view one = stp_view_of_eye(view, 0);
    if (!stp_view_frame_make(&one, &r->placement.frame) || !fits || view->width > 65536 ||
        view->height > 65536 || (uint64_t)view->width * view->height > UINT32_MAX / 4) {
        return stp_fail(r->base.context, STP_ERROR_ARGUMENT,
                        "view: eye, target, angle and size do not make a picture");
    }
    if (side > SUPERSAMPLE_LIMIT) {
        return stp_fail(r->base.context, STP_ERROR_ARGUMENT,
                        "style: at most %d x %d samples a pixel", SUPERSAMPLE_LIMIT,
                        SUPERSAMPLE_LIMIT);
    }
    r->view = view;
    r->style = style;
    r->list = list;
    r->readback->has_depth = false;
    return gl_target_make(r, view, side > 1);
}

/// All samples of what an eye sees.
static stp_result draw_eye(gl_renderer* r, uint32_t eye, uint32_t side)
{
    stp_view one = stp_view_of_eye(r->view, eye);
    uint32_t count = side * side;
    r->eye = eye;
    if (!stp_view_frame_make(&one, &r->placement.frame)) {
        return stp_fail(r->base.context, STP_ERROR_ARGUMENT, "view: it has no second eye");
    }
    stp_placement_make(&r->placement, r->directory, r->list);
    stp_placement_shift(&r->placement, side, 0);
    stp_result result = gl_frame_make(r);
    result = result == STP_OK ? make_programs(r) : result;
    if (result == STP_OK) {
        gl_frame_place(r, 0);
        if (eye == 0) {
            gl_shade_pass_clear(r);
        }
    }
    for (uint32_t i = 0; i < count && result == STP_OK; ++i) {
        result = draw_sample(r, side, i, count > 1);
    }
    return result;
}

/// Figures of a picture that is under way, or done where `image` was read.
static void count_picture(gl_renderer* r, uint32_t samples, double cpu_ms, bool done,
                          stp_draw_stats* stats)
{
    uint32_t eyes = r->target.eye_count;
    gl_timer_read(&r->gl, &r->timer, done);
    double parts = (double)samples * eyes; // each takes about as long as the last
    stats->covered_pixels = done ? gl_shade_pass_covered(r) : 0;
    stats->splats = eyes * r->list->splat_count;
    stats->triangles = eyes * r->list->triangle_count;
    stats->draw_calls = r->draw_calls;
    stats->samples = samples;
    stats->fragments = eyes * r->timer.fragments;
    stats->draw_ms = r->timer.known ? parts * r->timer.draw_ms : cpu_ms;
    stats->shade_ms = parts * r->timer.shade_ms;
}

static stp_result draw(stp_renderer* renderer, const stp_view* view, const stp_draw_list* list,
                       const stp_draw_style* style, stp_image* image, stp_draw_stats* stats)
{
    gl_renderer* r = (gl_renderer*)renderer;
    uint32_t side = style->supersample > 1 ? style->supersample : 1;
    double start = stp_clock_ms();
    *stats = (stp_draw_stats){0};
    stp_result result = begin_picture(r, view, list, style, image, side);
    for (uint32_t i = 0; i < stp_view_eye_count(view) && result == STP_OK; ++i) {
        result = draw_eye(r, i, side);
    }
    leave_state(&r->gl);
    if (result == STP_OK) {
        result = image != NULL ? read_picture(r, image) : check(r);
    }
    if (result == STP_OK) {
        count_picture(r, side * side, stp_clock_ms() - start, image != NULL, stats);
    }
    return result;
}

static stp_result draw_selected(stp_renderer* renderer, const stp_view* view,
                                const stp_quality* quality, const stp_draw_style* style,
                                stp_draw_list* list, stp_image* image, stp_draw_stats* stats)
{
    gl_renderer* r = (gl_renderer*)renderer;
    stp_quality whole = *quality;
    whole.occlusion = NULL;
    double start = stp_clock_ms();
    stp_result result = stp_select(renderer->context, r->store, view, &whole, list);
    double select_ms = stp_clock_ms() - start;
    if (result == STP_OK) {
        result = draw(renderer, view, list, style, image, stats);
    }
    stats->select_ms = select_ms;
    return result;
}

static const float* get_depth(const stp_renderer* renderer)
{
    const gl_renderer* r = (const gl_renderer*)renderer;
    gl_readback* back = r->readback;
    size_t count = (size_t)r->target.width * r->target.height * r->target.eye_count;
    if (count > back->capacity) {
        stp_free(renderer->context, back->depth);
        back->depth = STP_NEW_ARRAY(renderer->context, float, count);
        back->capacity = back->depth != NULL ? count : 0;
        back->has_depth = false;
    }
    if (back->depth != NULL && !back->has_depth && count > 0) {
        r->gl.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
        r->gl.GetTextureImage(r->target.depths, 0, GL_RED, GL_FLOAT,
                              (GLsizei)(count * sizeof(float)), back->depth);
        back->has_depth = true;
    }
    return back->depth;
}

static stp_result accumulate(stp_renderer* renderer, const stp_view* view,
                             const stp_quality* quality, const stp_draw_style* style,
                             stp_draw_list* list, stp_image* image, stp_draw_stats* stats)
{
    return draw_selected(renderer, view, quality, style, list, image, stats);
}

static void APIENTRY on_message(GLenum source, GLenum type, GLuint id, GLenum severity,
                                GLsizei length, const GLchar* message, const void* user)
{
    // the renderer's memory for it, which OpenGL hands back as it was given
    union {
        const void* given;
        gl_debug* debug;
    } to = {.given = user};
    (void)source;
    (void)id;
    (void)severity;
    (void)length;
    if (type != GL_DEBUG_TYPE_ERROR) {
        return;
    }
    if (to.debug->errors++ == 0) {
        snprintf(to.debug->message, sizeof(to.debug->message), "%.*s", (int)strcspn(message, "\n"),
                 message);
    }
}

static stp_result listen(gl_renderer* r)
{
    r->debug = STP_NEW_ZEROED(r->base.context, gl_debug, 1);
    if (r->debug == NULL) {
        return stp_fail_memory(r->base.context);
    }
    r->gl.Enable(GL_DEBUG_OUTPUT);
    r->gl.Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    r->gl.DebugMessageCallback(on_message, r->debug);
    return STP_OK;
}

/// What the context is, and whether it has all that is needed.
static stp_result look_at(gl_renderer* r, const stp_draw_gl_desc* desc)
{
    stp_context* context = r->base.context;
    const char* lacking = stp_gl_load(&r->gl, desc);
    if (lacking != NULL) {
        return stp_fail(context, STP_ERROR_UNSUPPORTED,
                        "gl: the context lacks %s: OpenGL 4.5 core with ARB_indirect_parameters is "
                        "needed",
                        lacking);
    }
    const GLubyte* name = r->gl.GetString(GL_RENDERER);
    snprintf(r->device, sizeof(r->device), "%s", name != NULL ? (const char*)name : "unknown");
    r->is_software = strstr(r->device, "llvmpipe") != NULL ||
                     strstr(r->device, "softpipe") != NULL || strstr(r->device, "swrast") != NULL;
    GLint major = 0, minor = 0, blocks = 0;
    r->gl.GetIntegerv(GL_MAJOR_VERSION, &major);
    r->gl.GetIntegerv(GL_MINOR_VERSION, &minor);
    r->gl.GetIntegerv(GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS, &blocks);
    if (10 * major + minor < 45 || blocks < 12 ||
        (10 * major + minor < 46 && !stp_gl_has(&r->gl, "GL_ARB_shader_draw_parameters"))) {
        return stp_fail(context, STP_ERROR_UNSUPPORTED,
                        "gl: %s has OpenGL %d.%d and %d storage blocks in vertex shaders; 4.5 with "
                        "ARB_shader_draw_parameters, and 12, are needed",
                        r->device, major, minor, blocks);
    }
    GLfloat sizes[2] = {1.0f, 1.0f};
    r->gl.GetFloatv(GL_POINT_SIZE_RANGE, sizes);
    r->point_extent = stp_min((float)POINT_EXTENT, 0.5f * sizes[1] - 2.0f);
    return desc->debug ? listen(r) : STP_OK;
}

stp_result stp_draw_gl_create(stp_context* context, stp_store* store, const stp_draw_gl_desc* desc,
                              stp_renderer** renderer)
{
    gl_renderer* r = STP_NEW_ZEROED(context, gl_renderer, 1);
    *renderer = NULL;
    if (r == NULL) {
        return stp_fail_memory(context);
    }
    r->base = (stp_renderer){.context = context,
                             .destroy = destroy,
                             .draw = draw,
                             .draw_selected = draw_selected,
                             .accumulate = accumulate,
                             .depth = get_depth};
    r->store = store;
    r->directory = stp_store_get_directory(store);
    r->upload_bytes = desc->upload_bytes;
    r->readback = STP_NEW_ZEROED(context, gl_readback, 1);
    stp_result result = r->readback != NULL ? look_at(r, desc) : stp_fail_memory(context);
    result = result == STP_OK ? gl_things_create(r) : result;
    if (result == STP_OK) {
        uint64_t memory = desc->memory_bytes > 0 ? desc->memory_bytes : default_memory;
        result = gl_pool_create(context, &r->gl, r->things.count, memory, &r->pool);
    }
    if (result == STP_OK) {
        gl_timer_create(&r->gl, &r->timer);
        result = gl_materials_create(r);
    }
    if (result == STP_OK) {
        result = check(r);
    }
    if (result != STP_OK) {
        destroy(&r->base);
        return result;
    }
    *renderer = &r->base;
    return STP_OK;
}

uint32_t stp_draw_gl_texture(const stp_renderer* renderer)
{
    return ((const gl_renderer*)renderer)->target.picture;
}

void stp_draw_gl_set_upload_bytes(stp_renderer* renderer, uint64_t bytes)
{
    ((gl_renderer*)renderer)->upload_bytes = bytes;
}

stp_draw_gl_stats stp_draw_gl_get_stats(const stp_renderer* renderer)
{
    const gl_renderer* r = (const gl_renderer*)renderer;
    return (stp_draw_gl_stats){.memory_bytes = r->pool.limit_words * sizeof(uint32_t),
                               .resident_bytes = r->pool.spans.used * sizeof(uint32_t),
                               .uploaded_bytes = r->pool.uploaded_bytes,
                               .missing = r->frame.missing,
                               .draw_calls = r->draw_calls,
                               .dispatches = r->dispatches,
                               .is_software = r->is_software,
                               .splats = r->splat_choice.used,
                               .device = r->device};
}

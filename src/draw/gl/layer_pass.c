// SPDX-License-Identifier: MIT
#include "draw/gl/gl_passes.h"
#include "draw/gl/gl_renderer.h"
#include "draw/transparency.h"
#include "raster/blue_noise.h"
#include "raster/splats_transparent.h"

#include <assert.h>
#include <string.h>

_Static_assert(STP_BLUE_NOISE_SIDE == NOISE_SIDE, "as shaders have it");
_Static_assert(STP_TRANSPARENT_CELL_SHIFT == GLASS_CELL_SHIFT, "as shaders have it");
_Static_assert(STP_OPTICAL_UNIT == OPTICAL_UNIT, "as shaders have it");

stp_result stp_gl_layer_pass_create(stp_gl_renderer* r)
{
    stp_gl_layer_pass* pass = &r->layer_pass;
    pass->possible = stp_transparency_of_scene(r->directory);
    stp_transparency_of_shadings(r->directory, pass->of_shading);
    pass->of_splats = memchr(pass->of_shading, 1, sizeof(pass->of_shading)) != NULL;
    r->gl.CreateBuffers(1, &pass->noise);
    r->gl.NamedBufferStorage(pass->noise, NOISE_SIDE * NOISE_SIDE * sizeof(uint16_t),
                             stp_blue_noise, 0);
    r->gl.ObjectLabel(GL_BUFFER, pass->noise, -1, "blue noise");
    return STP_OK;
}

void stp_gl_layer_pass_destroy_programs(stp_gl_renderer* r)
{
    stp_gl_layer_pass* pass = &r->layer_pass;
    GLuint* programs[] = {&pass->triangles, &pass->points, &pass->large, &pass->take,
                          &pass->compose};
    for (size_t i = 0; i < sizeof(programs) / sizeof(programs[0]); ++i) {
        r->gl.DeleteProgram(*programs[i]);
        *programs[i] = 0;
    }
}

static void destroy_textures(stp_gl_renderer* r)
{
    stp_gl_layer_pass* pass = &r->layer_pass;
    for (int i = 0; i < 2; ++i) {
        const GLuint textures[] = {pass->layers[i].ids, pass->layers[i].nearness};
        r->gl.DeleteFramebuffers(1, &pass->layers[i].framebuffer);
        r->gl.DeleteTextures(2, textures);
    }
    const GLuint textures[] = {pass->light, pass->below, pass->optical_depths};
    r->gl.DeleteTextures(3, textures);
    memset(pass->layers, 0, sizeof(pass->layers));
    pass->light = pass->below = pass->optical_depths = 0;
    pass->width = pass->height = 0;
}

void stp_gl_layer_pass_destroy(stp_gl_renderer* r)
{
    stp_gl_layer_pass_destroy_programs(r);
    destroy_textures(r);
    r->gl.DeleteBuffers(1, &r->layer_pass.noise);
    r->layer_pass.noise = 0;
}

/// Makes the textures of layers. @return false if memory is short
static bool make_textures(stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    stp_gl_layer_pass* pass = &r->layer_pass;
    uint32_t width = r->target.width, height = r->target.height;
    if (pass->width == width && pass->height == height) {
        return true;
    }
    destroy_textures(r);
    while (gl->GetError() != GL_NO_ERROR) { // discard errors of earlier calls
    }
    bool complete = true;
    for (int i = 0; i < 2; ++i) {
        pass->layers[i].ids = stp_gl_make_texture(gl, GL_R32UI, width, height, "layer ids");
        pass->layers[i].nearness =
            stp_gl_make_texture(gl, GL_DEPTH_COMPONENT32F, width, height, "layer nearness");
        GLuint framebuffer;
        gl->CreateFramebuffers(1, &framebuffer);
        gl->NamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, pass->layers[i].ids, 0);
        gl->NamedFramebufferTexture(framebuffer, GL_DEPTH_ATTACHMENT, pass->layers[i].nearness, 0);
        gl->NamedFramebufferDrawBuffer(framebuffer, GL_COLOR_ATTACHMENT0);
        complete = complete && gl->CheckNamedFramebufferStatus(framebuffer, GL_DRAW_FRAMEBUFFER) ==
                                   GL_FRAMEBUFFER_COMPLETE;
        pass->layers[i].framebuffer = framebuffer;
    }
    pass->light = stp_gl_make_texture(gl, GL_RGBA32F, width, height, "layers");
    pass->below = stp_gl_make_texture(gl, GL_R32F, width, height, "layer surfaces");
    pass->optical_depths = stp_gl_make_texture(gl, GL_R32UI, width, height, "optical depths");
    if (gl->GetError() != GL_NO_ERROR || !complete) {
        destroy_textures(r);
        return false;
    }
    pass->width = width;
    pass->height = height;
    return true;
}

void stp_gl_layer_pass_begin(stp_gl_renderer* r)
{
    stp_gl_layer_pass* pass = &r->layer_pass;
    bool wanted = pass->possible && r->style->transparency != STP_TRANSPARENCY_PATTERN;
    pass->active = wanted && make_textures(r);
    if (wanted && !pass->active && !pass->warned) {
        pass->warned = true;
        stp_warn(r->base.context,
                 "gl: not enough graphics memory for layers of transparent surfaces in a picture "
                 "of %ux%u: they are drawn as a pattern of pixels",
                 r->target.width, r->target.height);
    }
}

static stp_result make_programs(stp_gl_renderer* r)
{
    stp_gl_layer_pass* pass = &r->layer_pass;
    stp_context* context = r->base.context;
    char keep[256], layer[256];
    stp_gl_page_defines(r, "#define KEEP\n#define LAYER\n", keep, sizeof(keep));
    stp_gl_page_defines(r, "#define LAYER\n", layer, sizeof(layer));
    const struct {
        GLuint* program;
        const char *vertex, *fragment, *defines;
    } programs[] = {
        {&pass->triangles, "triangle.vert.glsl", "triangle.frag.glsl", keep},
        {&pass->points, "splat.vert.glsl", "splat.frag.glsl", layer},
        {&pass->large, stp_gl_large_vertex_shader(r), stp_gl_large_fragment_shader(r), layer},
        {&pass->take, "layer.comp.glsl", NULL, layer},
        {&pass->compose, "compose.comp.glsl", NULL, NULL}};
    stp_result result = STP_OK;
    for (size_t i = 0; i < sizeof(programs) / sizeof(programs[0]) && result == STP_OK; ++i) {
        bool of_splats =
            programs[i].program == &pass->points || programs[i].program == &pass->large;
        if (*programs[i].program != 0 || (of_splats && !pass->of_splats)) {
            continue;
        }
        result =
            programs[i].fragment != NULL
                ? stp_gl_program_create(context, &r->gl, programs[i].vertex, programs[i].fragment,
                                        programs[i].defines, programs[i].program)
                : stp_gl_program_create_compute(context, &r->gl, programs[i].vertex,
                                                programs[i].defines, programs[i].program);
    }
    return result;
}

/// Draws a layer into textures `number` (0 or 1); the others hold the previous layer.
static stp_result draw_layer(stp_gl_renderer* r, int number)
{
    assert((number == 0 || number == 1) && r->layer_pass.active);
    const stp_gl* gl = &r->gl;
    stp_gl_layer_pass* pass = &r->layer_pass;
    const GLuint nothing[4] = {NO_ID, NO_ID, NO_ID, NO_ID};
    const GLfloat far = 0.0f;
    GLuint framebuffer = pass->layers[number].framebuffer;
    stp_gl_set_visible_state(r);
    stp_gl_bind_frame(r);
    gl->BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl->ClearNamedFramebufferuiv(framebuffer, GL_COLOR, 0, nothing);
    gl->ClearNamedFramebufferfv(framebuffer, GL_DEPTH, 0, &far);
    gl->BindTextureUnit(UNIT_IDS, r->target.ids);
    gl->BindTextureUnit(UNIT_NEARNESS, r->target.nearness);
    gl->BindTextureUnit(UNIT_BEFORE_IDS, pass->layers[1 - number].ids);
    gl->BindTextureUnit(UNIT_BEFORE_NEARNESS, pass->layers[1 - number].nearness);
    gl->BindTextureUnit(UNIT_BELOW, pass->below);
    gl->BindImageTexture(IMAGE_OPTICAL, pass->optical_depths, 0, GL_FALSE, 0, GL_READ_WRITE,
                         GL_R32UI);
    // without caps, opaque surfaces occlude as much
    gl->BindTextureUnit(UNIT_CAPS, r->cap_pass.shows ? r->cap_pass.nearness : r->target.nearness);
    gl->BindBuffer(GL_DRAW_INDIRECT_BUFFER, r->frame.buffer);
    gl->BindBuffer(GL_PARAMETER_BUFFER_ARB, r->frame.buffer);
    const stp_gl_commands* triangles = &r->frame.commands[GL_COMMANDS_GLASS_TRIANGLES];
    stp_result result = STP_OK;
    if (triangles->count > 0) {
        gl->BindVertexArray(r->triangles.vertex_array);
        gl->UseProgram(pass->triangles);
        result = stp_gl_portion_draw(r, GL_TRIANGLES, triangles, triangles->offset,
                                     triangles->count_offset);
    }
    const stp_gl_commands* splats = &r->frame.commands[GL_COMMANDS_GLASS_SPLATS];
    if (splats->count > 0 && result == STP_OK) {
        stp_gl_splat_pass_begin(r);
        gl->Enable(GL_PROGRAM_POINT_SIZE);
        gl->BindVertexArray(r->splats.vertex_array);
        gl->UseProgram(pass->points);
        if (pass->count == 0) {
            stp_gl_timer_begin_count(gl, &r->timer, GL_COUNTED_GLASS);
        }
        result = stp_gl_portion_draw(r, GL_POINTS, splats, splats->offset, splats->count_offset);
        if (pass->count == 0) {
            stp_gl_timer_end_count(gl, &r->timer);
        }
        gl->Disable(GL_PROGRAM_POINT_SIZE);
        if (pass->count == 0) {
            stp_gl_timer_begin_count(gl, &r->timer, GL_COUNTED_LARGE_GLASS);
        }
        stp_gl_splat_pass_large(r, pass->large);
        if (pass->count == 0) {
            stp_gl_timer_end_count(gl, &r->timer);
        }
    }
    return result;
}

/// Composites the layer.
static void take_layer(stp_gl_renderer* r, int number)
{
    const stp_gl* gl = &r->gl;
    stp_gl_layer_pass* pass = &r->layer_pass;
    stp_gl_bind_frame(r);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_COUNTERS, r->shade.counters);
    gl->BindTextureUnit(UNIT_IDS, pass->layers[number].ids);
    gl->BindTextureUnit(UNIT_NEARNESS, pass->layers[number].nearness);
    gl->BindImageTexture(IMAGE_LIGHT, pass->light, 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
    gl->BindImageTexture(IMAGE_BELOW, pass->below, 0, GL_FALSE, 0, GL_READ_WRITE, GL_R32F);
    gl->BindImageTexture(IMAGE_OPTICAL, pass->optical_depths, 0, GL_FALSE, 0, GL_READ_ONLY,
                         GL_R32UI);
    gl->MemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    stp_gl_dispatch_pixels(r, pass->take, r->target.width, r->target.height);
    gl->MemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT |
                      GL_BUFFER_UPDATE_BARRIER_BIT);
}

/// Draws and composites layers until one is empty. Waits for each.
static stp_result draw_layers(stp_gl_renderer* r)
{
    stp_gl_layer_pass* pass = &r->layer_pass;
    uint32_t pixels = 1;
    for (; pixels > 0 && pass->count < STP_LAYERS_MAX; ++pass->count) {
        stp_result result = draw_layer(r, (int)(pass->count & 1));
        if (result != STP_OK) {
            return result;
        }
        uint32_t before = stp_gl_shade_pass_read(r, GL_COUNTER_LAYERS);
        take_layer(r, (int)(pass->count & 1));
        pixels = stp_gl_shade_pass_read(r, GL_COUNTER_LAYERS) - before;
    }
    pass->count -= pixels == 0; // the last pass found none
    assert(pass->count <= STP_LAYERS_MAX);
    return STP_OK;
}

/// Draws and composites the layer that stands for all.
static stp_result draw_nearest_layer(stp_gl_renderer* r)
{
    const GLuint none[4] = {0};
    r->gl.ClearTexImage(r->layer_pass.optical_depths, 0, GL_RED_INTEGER, GL_UNSIGNED_INT, none);
    stp_result result = draw_layer(r, 0);
    if (result == STP_OK) {
        take_layer(r, 0);
        r->layer_pass.count = 1;
    }
    return result;
}

stp_result stp_gl_layer_pass_draw(stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    stp_gl_layer_pass* pass = &r->layer_pass;
    assert(pass->active && pass->width == r->target.width && pass->height == r->target.height);
    pass->count = 0;
    if (r->frame.commands[GL_COMMANDS_GLASS_TRIANGLES].count == 0 &&
        r->frame.commands[GL_COMMANDS_GLASS_SPLATS].count == 0) {
        return STP_OK;
    }
    stp_result result = make_programs(r);
    if (result != STP_OK) {
        return result;
    }
    const GLfloat clear[4] = {0.0f, 0.0f, 0.0f, 1.0f}, all = 2.0f, near = 1.0f;
    const GLuint first[4] = {0};
    gl->ClearTexImage(pass->light, 0, GL_RGBA, GL_FLOAT, clear);
    gl->ClearTexImage(pass->below, 0, GL_RED, GL_FLOAT, &all);
    gl->ClearNamedFramebufferuiv(pass->layers[1].framebuffer, GL_COLOR, 0, first);
    gl->ClearNamedFramebufferfv(pass->layers[1].framebuffer, GL_DEPTH, 0, &near);
    result =
        r->style->transparency == STP_TRANSPARENCY_NEAREST ? draw_nearest_layer(r) : draw_layers(r);
    if (result != STP_OK) {
        return result;
    }
    gl->BindImageTexture(IMAGE_PICTURE, r->target.picture, 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA8);
    stp_gl_dispatch_pixels(r, pass->compose, r->target.width, r->target.height);
    gl->MemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT |
                      GL_TEXTURE_UPDATE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    return STP_OK;
}

// SPDX-License-Identifier: MIT
#include "program/viewer/model/painter_scene.h"

#include <GL/gl.h>
#include <GL/glext.h>
#include <assert.h>
#include <stdlib.h>
#include <string.h>

struct painter_gl_functions {
    PFNGLCREATETEXTURESPROC create_textures;
    PFNGLTEXTURESTORAGE2DPROC texture_storage;
    PFNGLTEXTUREPARAMETERIPROC texture_parameter;
    PFNGLCOPYIMAGESUBDATAPROC copy_image;
    void (*delete_textures)(GLsizei, const GLuint*);
    void (*finish)(void);
    GLenum (*get_error)(void);
};

bool painter_gl_create(painter_gl* g, const stp_draw_gl_desc* desc)
{
    *g = (painter_gl){0};
    painter_gl_functions* f = calloc(1, sizeof(*f));
    const struct {
        const char* name;
        void* place;
    } list[] = {
        {"glCreateTextures", &f->create_textures},
        {"glTextureStorage2D", &f->texture_storage},
        {"glTextureParameteri", &f->texture_parameter},
        {"glCopyImageSubData", &f->copy_image},
        {"glDeleteTextures", &f->delete_textures},
        {"glFinish", &f->finish},
        {"glGetError", &f->get_error},
    };
    bool all = f != NULL;
    for (size_t i = 0; all && i < sizeof(list) / sizeof(list[0]); ++i) {
        stp_gl_proc function = desc->get_proc_address(list[i].name, desc->user);
        memcpy(list[i].place, &function, sizeof(function));
        all = function != NULL;
    }
    if (!all) {
        free(f);
        return false;
    }
    g->functions = f;
    return true;
}

void painter_gl_destroy(painter_gl* g)
{
    if (g->functions != NULL) {
        g->functions->delete_textures(PAINTER_GL_SLOTS, g->textures);
        g->functions->finish();
    }
    free(g->functions);
    *g = (painter_gl){0};
}

static bool fit(painter_gl* g, int slot, uint32_t width, uint32_t height)
{
    const painter_gl_functions* f = g->functions;
    if (g->width[slot] == width && g->height[slot] == height) {
        return true;
    }
    f->delete_textures(1, &g->textures[slot]);
    f->create_textures(GL_TEXTURE_2D, 1, &g->textures[slot]);
    while (f->get_error() != GL_NO_ERROR) {
    }
    f->texture_storage(g->textures[slot], 1, GL_RGBA8, (GLsizei)width, (GLsizei)height);
    bool room = f->get_error() == GL_NO_ERROR;
    f->texture_parameter(g->textures[slot], GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    f->texture_parameter(g->textures[slot], GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    f->texture_parameter(g->textures[slot], GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    f->texture_parameter(g->textures[slot], GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    g->width[slot] = room ? width : 0;
    g->height[slot] = room ? height : 0;
    return room;
}

uint32_t painter_gl_keep(painter_gl* g, int slot, uint32_t picture, uint32_t width, uint32_t height)
{
    assert(g->functions != NULL && slot >= 0 && slot < PAINTER_GL_SLOTS);
    if (!fit(g, slot, width, height)) {
        return 0;
    }
    g->functions->copy_image(picture, GL_TEXTURE_2D, 0, 0, 0, 0, g->textures[slot], GL_TEXTURE_2D,
                             0, 0, 0, 0, (GLsizei)width, (GLsizei)height, 1);
    g->functions->finish(); // another context shows the texture
    return g->textures[slot];
}

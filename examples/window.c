// SPDX-License-Identifier: MIT
//
// A file in a host's own window. SDL2 creates the window and the OpenGL context, Stipple draws into
// a texture of that context, and the host copies it to the window and draws its own overlay. Arrow
// keys turn the model, Escape quits.
//
//   cc window.c $(pkg-config --cflags --libs stipple sdl2 gl) -lm -o window
//   ./window FILE.stip [--frames N OUT.ppm]   draws N frames, writes the last one, ends
#include <stipple/stipple.h>

#include <SDL.h>
#include <SDL_opengl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static PFNGLGENFRAMEBUFFERSPROC gen_framebuffers;
static PFNGLBINDFRAMEBUFFERPROC bind_framebuffer;
static PFNGLFRAMEBUFFERTEXTURE2DPROC framebuffer_texture;
static PFNGLBLITFRAMEBUFFERPROC blit_framebuffer;

static void on_log(stp_log_level level, const char* message, void* user)
{
    (void)user;
    fprintf(stderr, "window: %s%s\n", level == STP_LOG_ERROR ? "error: " : "", message);
}

static stp_gl_function get_function(const char* name, void* user)
{
    (void)user;
    void* address = SDL_GL_GetProcAddress(name);
    stp_gl_function function;
    memcpy(&function, &address, sizeof(function));
    return function;
}

static void load(void* place, const char* name)
{
    stp_gl_function function = get_function(name, NULL);
    memcpy(place, &function, sizeof(function));
}

static void write_window(const char* path, int width, int height)
{
    unsigned char* pixels = malloc((size_t)width * (size_t)height * 3);
    FILE* file = fopen(path, "wb");
    if (pixels != NULL && file != NULL) {
        glPixelStorei(GL_PACK_ALIGNMENT, 1);
        glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, pixels);
        fprintf(file, "P6\n%d %d\n255\n", width, height);
        for (int row = height - 1; row >= 0; --row) {
            fwrite(pixels + 3 * (size_t)width * (size_t)row, 1, 3 * (size_t)width, file);
        }
    }
    if (file != NULL) {
        fclose(file);
    }
    free(pixels);
}

// Moves the eye around the target.
static void turn(stp_view* view, double angle)
{
    double x = view->eye.x - view->target.x, z = view->eye.z - view->target.z;
    view->eye.x = view->target.x + x * cos(angle) + z * sin(angle);
    view->eye.z = view->target.z + z * cos(angle) - x * sin(angle);
    view->up = (stp_vec3d){0, 1, 0};
}

static stp_result run(stp_model* model, SDL_Window* window, long frames, const char* out)
{
    int width, height;
    GLuint framebuffer;
    SDL_GL_GetDrawableSize(window, &width, &height);
    stp_painter* painter = NULL;
    stp_painter_desc on_gl = {.get_proc_address = get_function};
    stp_paint_desc paint = {.budget_ms = 33, .background = true, .background_color = {32, 34, 37}};
    stp_view view = {.width = (uint32_t)width, .height = (uint32_t)height};
    stp_result result = stp_model_get_view(model, "iso", &view);
    result = result == STP_OK ? stp_painter_create(model, &on_gl, &painter) : result;
    gen_framebuffers(1, &framebuffer);
    for (long frame = 0; result == STP_OK && (frames == 0 || frame < frames); ++frame) {
        SDL_Event event;
        while (SDL_PollEvent(&event)) {
            SDL_Keycode key = event.type == SDL_KEYDOWN ? event.key.keysym.sym : 0;
            frames = event.type == SDL_QUIT || key == SDLK_ESCAPE ? frame + 1 : frames;
            turn(&view, key == SDLK_LEFT ? -0.1 : key == SDLK_RIGHT ? 0.1 : 0.0);
        }
        result = stp_painter_draw(painter, &view, &paint, NULL, NULL); // NULL: stays a texture
        if (result != STP_OK) {
            break;
        }
        bind_framebuffer(GL_READ_FRAMEBUFFER, framebuffer);
        framebuffer_texture(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D,
                            stp_painter_get_texture(painter), 0);
        bind_framebuffer(GL_DRAW_FRAMEBUFFER, 0);
        blit_framebuffer(0, 0, width, height, 0, height, width, 0, GL_COLOR_BUFFER_BIT, GL_NEAREST);
        bind_framebuffer(GL_FRAMEBUFFER, 0); // here the host would draw its own content
        if (out != NULL && frame + 1 == frames) {
            write_window(out, width, height);
        }
        SDL_GL_SwapWindow(window);
    }
    stp_painter_destroy(painter); // while its context is current
    return result;
}

int main(int argc, char** argv)
{
    int counted = argc == 5 && strcmp(argv[2], "--frames") == 0;
    if (argc != 2 && !counted) {
        fprintf(stderr, "usage: window FILE.stip [--frames N OUT.ppm]\n");
        return 2;
    }
    if (SDL_Init(SDL_INIT_VIDEO) != 0) {
        fprintf(stderr, "window: %s\n", SDL_GetError());
        return 77;
    }
    SDL_GL_SetAttribute(SDL_GL_CONTEXT_MAJOR_VERSION, 4);
    SDL_GL_SetAttribute(SDL_GL_CONTEXT_MINOR_VERSION, 5);
    SDL_GL_SetAttribute(SDL_GL_CONTEXT_PROFILE_MASK, SDL_GL_CONTEXT_PROFILE_CORE);
    SDL_Window* window = SDL_CreateWindow("Stipple in a window", 0, 0, 640, 480, SDL_WINDOW_OPENGL);
    SDL_GLContext gl = window != NULL ? SDL_GL_CreateContext(window) : NULL;
    if (gl == NULL) {
        fprintf(stderr, "window: %s\n", SDL_GetError());
        return 77;
    }
    load(&gen_framebuffers, "glGenFramebuffers");
    load(&bind_framebuffer, "glBindFramebuffer");
    load(&framebuffer_texture, "glFramebufferTexture2D");
    load(&blit_framebuffer, "glBlitFramebuffer");
    stp_context* context = NULL;
    stp_model* model = NULL;
    stp_context_desc desc = {.log = on_log};
    stp_model_desc opening = {.path = argv[1]};
    stp_result result = stp_context_create(&context, &desc);
    result = result == STP_OK ? stp_model_open(context, &opening, &model) : result;
    if (result == STP_OK) {
        result = run(model, window, counted ? atol(argv[3]) : 0, counted ? argv[4] : NULL);
    }
    stp_model_close(model);
    stp_context_destroy(context);
    SDL_Quit();
    return result == STP_OK ? 0 : 1;
}
